"""Lubricants that cannot be (tribo/material/oil.py)."""

import math

import pytest

from tribo import InputError, Oil, lubrication_regime
from tribo.material import minimum_line_film, minimum_point_film

WHITE = {
    "temperatures": (313.15, 373.15),
    "viscosities": (32e-6, 5e-6),
    "density": 866.0,
    "pressure_coefficients": (20e-9, 15e-9),
}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"pressure_coefficients": (20e-9, 0.0)}, "pressure_coefficient is 0"),
        ({"temperatures": (373.15, 313.15)}, "they must rise"),
        ({"viscosities": (5e-6, 32e-6)}, "they must fall"),
        ({"density": -1.0}, "density is -1"),
    ],
)
def test_an_oil_that_cannot_be_is_refused(change, said):
    Oil(**WHITE)
    with pytest.raises(InputError, match=said):
        Oil(**(WHITE | change))


@pytest.mark.parametrize("film", [minimum_line_film, minimum_point_film])
def test_a_film_knows_no_direction_and_needs_a_load(film):
    assert film(-1.0, 0.05, 20e-9, 100.0, 2e-3, 1e11) == film(1.0, 0.05, 20e-9, 100.0, 2e-3, 1e11)
    with pytest.raises(InputError, match=r"load.* is 0"):
        film(1.0, 0.05, 20e-9, 0.0, 2e-3, 1e11)


def test_no_regime_or_viscosity_is_made_up():
    with pytest.raises(InputError, match="film_parameter is nan"):
        lubrication_regime(math.nan)
    with pytest.raises(InputError, match="temperature is -5"):
        Oil(**WHITE).viscosity(-5.0)

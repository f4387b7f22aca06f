"""Lubricants that cannot be (tribo/material/oil.py)."""

import math

import pytest

from tribo import InputError, Oil, lubrication_regime
from tribo.material import minimum_line_film, minimum_point_film, viscosity_index, warm_viscosity

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


@pytest.mark.parametrize("cold", [22e-6, 46e-6, 220e-6, 680e-6])
@pytest.mark.parametrize("index", [40.0, 95.0, 100.0, 160.0, 250.0])
def test_the_viscosity_at_100_degrees_has_the_index(cold, index):
    """The equations of D2270 join within 0.2 % of L and H at the ends of their ranges."""
    warm = warm_viscosity(cold, index)
    assert viscosity_index(cold, warm) == pytest.approx(index, abs=0.5)
    assert warm < warm_viscosity(cold, index + 5)


@pytest.mark.parametrize(
    ("warm", "L", "H"),
    # Of Table 1 of ASTM D2270, as printed by programs and pages that reprint it.
    [(4e-6, 25.32, 19.56), (10e-6, 147.7, 82.87), (20e-6, 493.2, 229.5)],
)
def test_the_index_is_0_and_100_at_the_viscosities_of_the_standard(warm, L, H):
    assert viscosity_index(1e-6 * L, warm) == pytest.approx(0, abs=1)
    assert viscosity_index(1e-6 * H, warm) == pytest.approx(100, abs=1)

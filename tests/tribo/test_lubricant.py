"""Lubricants that cannot be (tribo/lubricant.py)."""

import pytest

from tribo import InputError, Oil

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

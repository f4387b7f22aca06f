"""Quantities in the usual units, which are read without the library of all others."""

import pytest

from pipeline.scene import units

USUAL = [(si, unit) for si, group in units._USUAL.items() for unit in group]


@pytest.mark.parametrize("number", ["1", "-0.27", "273.15", "6.6e3", "1.23456789012345678e-7"])
@pytest.mark.parametrize(("si", "unit"), USUAL, ids=[unit for _, unit in USUAL])
def test_usual_units_are_what_they_are_among_all(monkeypatch, si, unit, number):
    own = units.exact_si(f"{number} {unit}", like=f"1 {si}")
    monkeypatch.setattr(units, "_USUAL", {"Pa": {}})
    among_all = units.exact_si(f"{number} {unit}", like=f"1 {si}")
    assert float(own) == float(among_all)


def test_usual_units_of_another_dimension_are_refused():
    for si, unit in USUAL:
        for other in units._USUAL:
            if other != si:
                with pytest.raises(units.UnitError):
                    units.exact_si(f"1 {unit}", like=f"1 {other}")

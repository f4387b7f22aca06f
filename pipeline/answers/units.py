"""Values of entries that vary in a sweep, in the units in which users are shown them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.quantities import display
from pipeline.units import typeset

if TYPE_CHECKING:
    import xarray as xr

_OWN_UNITS = {"m": "mm", "K": "°C", "Pa": "GPa", "m s-1": "m/s"}
"""Usual units for columns that the user added, by SI unit."""


def value_words(axis: xr.DataArray, value: float | str) -> str:
    """A value of an entry that varies, whose coordinate is `axis`, as text with its usual unit."""
    if isinstance(value, str):
        return value
    return display(value, usual_unit(axis)).removesuffix(" 1").strip()


def named_value(one: xr.DataArray) -> str:
    """A value of an entry or condition that varies, with its name, such as "pin radius 4 mm"."""
    return f"{str(one.name).replace('_', ' ')} {value_words(one, one.item())}"


def usual_unit(axis: xr.DataArray) -> str:
    """Unit in which users are shown values of the coordinate `axis`, such as "mm" for a radius."""
    unit, own = str(axis.attrs.get("units", "")), str(axis.attrs.get("shown_in", ""))
    return typeset(own) if own and unit else _OWN_UNITS.get(unit, unit)

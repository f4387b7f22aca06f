"""The conditions that decide, in every door the same: those of a case, with some replaced."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypedDict

import numpy as np
import xarray as xr

from pipeline.quantities import display
from pipeline.sweep.conditions import OIL_WORKS, PATHS, Conditions
from pipeline.units import in_si, share_of
from tribo import InputError
from tribo.types import Array, Mask

_COLDEST, _HOTTEST = (in_si("temperature.bulk", end, "1 K") for end in OIL_WORKS)
NAMES = tuple(PATHS)
"""Conditions that answers take as keywords."""
Values = float | str | Sequence[float | str] | np.ndarray[Any, Any] | xr.DataArray
"""One value in SI or text with its unit, or several, which make a dimension."""


class ConditionValues(TypedDict, total=False):
    """Conditions to judge by in place of the scene's, as keywords of answers."""

    friction: Values | None
    bulk_temperature: Values | None
    critical_temperature: Values | None
    critical_area_fraction: Values | None
    added_rise_fraction: Values | None


class Operation(NamedTuple):
    """Operating points (k,), each with the friction coefficient and bulk temperature it has."""

    load: Array  # [N]
    velocity: Array  # [m/s]
    friction: Array
    bulk_temperature: Array  # [K]

    @classmethod
    def under(cls, conditions: Conditions, loads: Array, velocities: Array) -> Operation:
        """Points that all have the friction and bulk temperature of `conditions`."""
        same = conditions.friction, conditions.bulk_temperature
        return cls(loads, velocities, *(np.full(loads.shape, one) for one in same))

    def take(self, which: Any) -> Operation:
        """Some of the points."""
        return Operation(*(one[which] for one in self))


def by_bulk(bulks: Array, function: Callable[[float, Mask], Array]) -> Array:
    """Values (k,) of a function of a bulk temperature [K] and of which of the points have it."""
    found = np.full(bulks.shape, np.nan)
    for bulk in np.unique(bulks).tolist():
        here = bulks == bulk
        found[here] = function(bulk, here)
    return found


def judged(own: Conditions, given: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, with those `given` by name, single values, in place of its own."""
    arrays = in_arrays(given)
    if several := [name for name, one in arrays.items() if one.size > 1]:
        raise InputError(f"{several[0]} takes a single value here")
    return replaced(own, {name: one.item() for name, one in arrays.items()})


def replaced(own: Conditions, values: Mapping[str, Any]) -> Conditions:
    """Conditions with some values [SI] replaced; None leaves one as it is."""
    return replace(own, **{name: one for name, one in values.items() if one is not None})


def in_arrays(given: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Conditions as arrays in SI: those given as lists have a dimension of their own."""
    if unknown := given.keys() - {*NAMES}:
        raise InputError(f"{min(unknown)} is no condition; there are {', '.join(NAMES)}")
    found = dict[str, xr.DataArray]()
    for name, value in given.items():
        if value is None:
            continue
        found[name] = in_array(name, value, functools.partial(_si, name), name)
        if found[name].dims == (name,) and not isinstance(value, xr.DataArray):
            values = found[name].values.tolist()
            if len(values) != len({*values}):
                raise InputError(f"{name} has a value twice; give each once")
            found[name] = found[name].assign_coords({name: values})
    return found


def in_array(name: str, value: Any, read: Callable[[Any], Any], dim: str) -> xr.DataArray:
    """An argument as an array of what `read` makes of its values; a list has the dimension `dim`.

    A unit in the attributes of a DataArray follows each number.
    """
    values = np.asarray(value, object)
    if not values.size:
        raise InputError(f"{name} is empty; give at least one value")
    unit = value.attrs.get("units") if isinstance(value, xr.DataArray) else None
    found = np.empty(values.shape, object)
    for place, one in np.ndenumerate(values):
        bare = not unit or isinstance(one, str) or (isinstance(one, float) and np.isnan(one))
        found[place] = read(one if bare else f"{one} {unit}")
    if isinstance(value, xr.DataArray):
        return value.copy(data=found).drop_attrs()
    if found.ndim > 1:
        raise InputError(f"{name} has {found.ndim} dimensions; give a DataArray, which names them")
    return xr.DataArray(found, dims=[dim] * found.ndim)


def _si(name: str, value: Any) -> float | None:
    """A value in SI; None, which stands for that of the scene, stays."""
    if value is None:
        return None
    if name in ("bulk_temperature", "critical_temperature"):
        return _oil_temperature(name, value)
    try:
        if isinstance(value, bool | np.bool_):
            raise ValueError
        return float(share_of(value.removesuffix(" 1") if isinstance(value, str) else value))
    except (OverflowError, TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; give a number such as 0.1") from None


def _oil_temperature(name: str, value: Any) -> float:
    kelvin = in_si(name, value, "80 degC")
    hottest = _HOTTEST if name == "bulk_temperature" else math.inf
    if kelvin < _COLDEST or hottest < kelvin < math.inf:
        raise InputError(
            f"{name} is {display(kelvin, '°C', 4)} ({kelvin:g} K), at which no oil works; a "
            'number in Python is in kelvins, and text has its unit, such as "80 degC"'
        )
    return float(kelvin)

"""The conditions that decide, in every door the same: those of a case, with some replaced."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
import xarray as xr

from pipeline.quantities import display
from pipeline.sweep.conditions import (
    OIL_WORKS,
    PATHS,
    Conditions,
    changed_conditions,
    changes_of,
)
from pipeline.units import in_si, share_of
from tribo import InputError

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
    share: Values | None
    unmodelled_rise: Values | None


def judged(own: Conditions, given: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, with those `given` by name in place of its own."""
    values = {name: one.item() for name, one in in_arrays(given).items()}
    return changed_conditions(own, changes_of(**values))


def in_arrays(given: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Conditions as arrays in SI: those given as lists have a dimension of their own."""
    unknown = given.keys() - {*NAMES}
    if unknown:
        raise InputError(f"{min(unknown)} is no condition; there are {', '.join(NAMES)}")
    return {name: _array(name, value) for name, value in given.items() if value is not None}


def _array(name: str, value: Any) -> xr.DataArray:
    if isinstance(value, xr.DataArray):
        return value.copy(
            data=np.vectorize(lambda one: _si(name, one), otypes=[object])(value.values)
        )
    if isinstance(value, list | tuple | np.ndarray):
        values = [_si(name, one) for one in np.asarray(value, object).tolist()]
        if len(values) != len(set(map(str, values))):
            raise InputError(f"{name} has a value twice; give each once")
        return xr.DataArray(np.array(values, object), {name: values}, [name])
    held = np.empty((), object)
    held[()] = _si(name, value)
    return xr.DataArray(held)


def _si(name: str, value: Any) -> Any:
    if value is None:  # that of the scene
        return None
    match name:
        case "bulk_temperature" | "critical_temperature":
            return _oil_temperature(name, value)
        case "share" | "unmodelled_rise":
            return share_of(value)
    try:
        return float(value)
    except ValueError:
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

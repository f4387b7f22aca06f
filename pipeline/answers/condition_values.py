"""Conditions of an answer: those of a case, some of them replaced by arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pipeline.arguments import plain_value
from pipeline.condition_kinds import CONDITIONS
from pipeline.messages import did_you_mean
from pipeline.sweep.case import Conditions
from tribo import InputError
from tribo.types import Array

PAIRS = "place"
"""Dimension of operating points given as lists, or as a table."""


class QueryPoints(NamedTuple):
    """Operating points (k,), each with a friction coefficient and a bulk temperature."""

    load: Array  # [N]
    velocity: Array  # [m/s]
    friction: Array
    bulk_temperature: Array  # [K]

    @classmethod
    def under(cls, conditions: Conditions, loads: Array, velocities: Array) -> QueryPoints:
        """Points that all have the friction and bulk temperature of `conditions`."""
        values = conditions.friction, conditions.bulk_temperature
        return cls(loads, velocities, *(np.full(loads.shape, value) for value in values))

    def take(self, index: Any) -> QueryPoints:
        """Points selected by `index`, which may be a mask."""
        return QueryPoints(*(column[index] for column in self))


def oil_of(conditions: Conditions) -> tuple[Any, ...]:
    """Values of all conditions but those that points replace: equal for the points of one oil."""
    names = (field.name for field in fields(conditions))
    return tuple(getattr(conditions, name) for name in names if name not in QueryPoints._fields)


def override_conditions(conditions: Conditions, overrides: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, some replaced by the single values of `overrides`."""
    arrays = condition_arrays(overrides)
    if several := [name for name, array in arrays.items() if array.size > 1]:
        raise InputError(f"{several[0]} takes a single value here; give it once")
    return replace_conditions(conditions, {name: array.item() for name, array in arrays.items()})


def replace_conditions(conditions: Conditions, values: Mapping[str, Any]) -> Conditions:
    """Conditions with some values [SI] replaced, except by None."""
    return replace(
        conditions, **{name: value for name, value in values.items() if value is not None}
    )


def condition_arrays(overrides: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Conditions as arrays in SI; a list has a dimension with the name of its condition."""
    if unknown := overrides.keys() - {*CONDITIONS}:
        hint = did_you_mean(min(unknown), CONDITIONS)
        raise InputError(
            f"{min(unknown)} is not a condition{hint}; the conditions are {', '.join(CONDITIONS)}"
        )
    arrays = dict[str, xr.DataArray]()
    for name, value in overrides.items():
        if value is None:
            continue
        arrays[name] = argument_array(name, value, _condition, name)
        if arrays[name].dims == (name,) and not isinstance(value, xr.DataArray):
            values = arrays[name].values.tolist()
            if len(values) != len({*values}):
                raise InputError(f"{name} has a value twice; give each once")
            arrays[name] = arrays[name].assign_coords({name: values})
    return arrays


def argument_array(
    name: str, value: Any, read: Callable[[str, Any], Any], dim: str
) -> xr.DataArray:
    """Array of the values of an argument, read with its name; a list has the dimension `dim`."""
    plain = plain_value(name, value)
    shape = value.shape if isinstance(value, xr.DataArray) else _shape_of(name, plain)
    values = np.array(plain, object).reshape(shape)
    if not values.size:
        raise InputError(f"{name} is empty; give at least one value")
    converted = np.empty(values.shape, object)
    for index, item in np.ndenumerate(values):
        converted[index] = read(name, item)
    if None not in converted.ravel().tolist():
        converted = converted.astype(float)
    if isinstance(value, xr.DataArray):
        return value.copy(data=converted).drop_attrs()
    return xr.DataArray(converted, dims=[dim] * converted.ndim)


def _shape_of(name: str, plain: Any) -> tuple[int, ...]:
    """Shape of a plain value: that of a number, or of a list of them."""
    if not isinstance(plain, list):
        return ()
    if any(isinstance(item, list) for item in plain):
        raise InputError(f"{name} is a nested list; give a DataArray, with named dimensions")
    return (len(plain),)


def _condition(name: str, value: Any) -> float | None:
    """A condition in SI; None, for the value of the scene, remains None."""
    return None if value is None else float(CONDITIONS[name].kind.argument(name, value))


def arguments_of_case(
    arguments: Mapping[str, xr.DataArray], case_labels: Mapping[str, Any]
) -> dict[str, xr.DataArray]:
    """Arguments of a case; those that vary along the dimensions of cases, at its labels.

    Points along `PAIRS` are no rows, even if these have a column of this name.
    """
    selected = {**arguments}
    for name, argument in arguments.items():
        dims = [dim for dim in argument.dims if dim != PAIRS or dim in argument.coords]
        labels = {dim: case_labels[str(dim)] for dim in dims if dim in case_labels}
        try:
            selected[name] = argument.sel(labels, drop=True) if labels else argument
        except (IndexError, KeyError, TypeError):
            raise InputError(f"{name} lacks some {min(map(str, labels))} of the sweep") from None
    return selected

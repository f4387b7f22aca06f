"""Convert user arguments to text with units, numbers, lists or tables.

Whatever comes in as an override, an argument or an attribute of an array passes `plain_value`,
which keeps the unit of a value or refuses the value.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from decimal import Decimal
from typing import Any

import numpy as np

from tribo import InputError

_WITHOUT_UNIT = {"", "1", "-", "–", "dimensionless"}
"""Units of numbers, as attributes of arrays state them."""
_MAX_LEVELS = 10


def plain_value(name: str, value: Any, unit: str = "", level: int = 0) -> Any:
    """Convert a value to what TOML can hold: text, number, truth value, list or table.

    Numbers of NumPy and `decimal.Decimal` become numbers of Python, arrays, tuples, and objects of
    pandas and xarray become lists. A quantity of pint, and a number in an array whose attributes
    have ``units``, become text with the unit; `unit` is this unit. None stays None.

    Raises
    ------
    InputError
        If the value is of another type, or has a unit that cannot be kept; it begins with `name`.
    """
    if level > _MAX_LEVELS:
        raise InputError(f"{name} has lists or tables nested more than {_MAX_LEVELS} deep")
    package = type(value).__module__.partition(".")[0]
    if callable(getattr(value, "to_base_units", None)):
        return _plain_quantity(name, value, level)
    if package in ("xarray", "pandas") and hasattr(value, "to_numpy"):
        return _plain_array(name, value, level)
    if value is None or isinstance(value, bool | np.bool_):
        return value if value is None else bool(value)
    if isinstance(value, str | os.PathLike):
        return str(value)
    # Truth values, numbers, objects and text; a subclass may have masked values or units.
    if type(value) is np.ndarray and value.dtype.kind in "biufOU":
        return plain_value(name, value.tolist(), unit, level)
    if isinstance(value, list | tuple | range):
        return [plain_value(name, item, unit, level + 1) for item in value]
    if isinstance(value, Mapping) and package not in ("xarray", "pandas"):
        return {str(key): plain_value(name, item, unit, level + 1) for key, item in value.items()}
    return _plain_number(name, value, unit)


def _plain_number(name: str, value: Any, unit: str) -> Any:
    """A number, or text with the number and its unit."""
    is_duration = isinstance(value, np.timedelta64)  # a subclass of whole numbers
    if isinstance(value, Decimal) and value.is_finite():
        value = int(value) if not unit and value == value.to_integral_value() else float(value)
    if is_duration or not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{name} is of type {type(value).__name__}; give a number or text")
    number = int(value) if isinstance(value, int | np.integer) else float(value)
    return f"{number!r} {unit}" if unit and not math.isnan(number) else number


def _plain_quantity(name: str, value: Any, level: int) -> Any:
    """Text of a quantity of pint, or a list of them."""
    if np.ndim(value.magnitude):
        return [plain_value(name, item, level=level + 1) for item in value]
    if isinstance(value.magnitude, complex):
        raise InputError(f"{name} is {value}, which is not real; give a real number")
    return f"{value:~C}"


def _plain_array(name: str, value: Any, level: int) -> Any:
    """List of an array of xarray or pandas; its attribute ``units`` is the unit of its numbers."""
    if type(value).__name__ == "DataFrame":
        raise InputError(f"{name} is a table; give one of its columns")
    data = getattr(value, "data", None)
    if callable(getattr(data, "to_base_units", None)):  # an array of pint within one of xarray
        return plain_value(name, data, level=level)
    attributes = getattr(value, "attrs", {})
    unit = str(attributes.get("units", attributes.get("unit", "")) or "").strip()
    items = value.to_numpy() if np.ndim(value) == 0 or hasattr(value, "dims") else [*value]
    return plain_value(name, items, "" if unit in _WITHOUT_UNIT else unit, level)

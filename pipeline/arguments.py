"""Convert user arguments to text with units, numbers, lists or tables.

Whatever comes in as an override, an argument or an attribute of an array passes `plain_value`,
which keeps the unit of a value or refuses the value.
"""

from __future__ import annotations

import functools
import inspect
import math
import os
from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any, ParamSpec, TypeVar

import numpy as np

from pipeline.messages import did_you_mean, quoted
from pipeline.units import UnitError, share_of, to_si
from tribo import InputError

_WITHOUT_UNIT = {"", "1", "-", "–", "dimensionless"}
"""Units of numbers, as attributes of arrays state them."""
P = ParamSpec("P")
T = TypeVar("T")
_MAX_LEVELS = 10


_PATH = (str, os.PathLike), "text or a Path"
_TEXT = str, "text"
_FLAG = (bool, np.bool_), "True or False"
_ALLOWED: dict[str, tuple[Any, str]] = {
    "path": _PATH, "out": _PATH, "source": _PATH, "title": _TEXT, "author": _TEXT,
    "preset": (str, "text; entries of a scene go into overrides="),
    "command": _TEXT, "like": _TEXT, "kind": _TEXT, "plain": _FLAG, "retry_failed": _FLAG,
    "dashboard": _FLAG, "without_tests": _FLAG,
    "sweep": (_PATH[0], "a Sweep, or the path of a scene"),
    "scene": (_PATH[0], "a Sweep, or the path of a scene"),
    "ds": (_PATH[0], "a Dataset of pipeline.open_sweep, or the path of a store"),
    "progress": (Callable, "a function of a Progress"),
    "changes": (Mapping, "a mapping of values by name"),
    "overrides": (Mapping, "a mapping of values by key path"),
    "name": (tuple, "a tuple of pairs (dimension, label)"),
}  # fmt: skip
"""Types of arguments of public functions, by their names, and what is allowed."""
_CLASSES = {
    "sweep": ("Sweep",), "scene": ("Sweep",), "ds": ("Dataset", "Trade"),
}  # fmt: skip
"""Further types of arguments, by name, since importing them is slow."""
_POINTS = {"load": ("500 N", "finite and above 0"), "velocity": ("2 m/s", "finite and at least 0")}
"""Arguments that give a point, each with an example and what is allowed."""


def typed_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: refuse an argument of a wrong type by its name, before the function begins."""
    parameters = inspect.signature(function).parameters
    names = [*parameters]

    @functools.wraps(function)
    def checked(*arguments: P.args, **keywords: P.kwargs) -> T:
        for name in keywords:
            if name not in parameters and (hint := did_you_mean(name, names)):
                raise InputError(f"unknown argument {name}{hint}")
        for name, value in {**dict(zip(names, arguments, strict=False)), **keywords}.items():
            types, description = _ALLOWED.get(name, (object, ""))
            is_default = value is None and name in parameters and parameters[name].default is None
            is_allowed = isinstance(value, types) or type(value).__name__ in _CLASSES.get(name, ())
            if not (is_default or is_allowed):
                value_text = " ".join(repr(value).split())
                raise InputError(f"{name} is {value_text:.80}; give {description}")
        return function(*arguments, **keywords)

    return checked


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


def single_value(name: str, value: Any, example: object) -> Any:
    """Convert a value to a number or text; `InputError` for a list, a table or no value."""
    plain = plain_value(name, value)
    if isinstance(plain, list):
        raise InputError(f"{name} takes a single value; give one such as {quoted(example)}")
    if plain is None or isinstance(plain, bool | dict):
        raise InputError(
            f"{name} is {quoted(plain)}, which is not a number; give one such as {quoted(example)}"
        )
    return plain


def in_si(name: str, value: Any, like: str) -> float:
    """Convert text with a unit, or a quantity, to SI; return a number as it is.

    `like` is any quantity of the required dimension. Raises an `InputError` that begins with `name`
    if the value is neither.
    """
    plain = single_value(name, value, like)
    try:
        return to_si(plain, like) if isinstance(plain, str) else float(plain)
    except (UnitError, OverflowError) as error:
        raise InputError(f'{name}: {error}; give one such as "{like}"') from error


def in_load_or_velocity(name: str, value: Any) -> float:
    """Convert the argument ``load`` or ``velocity`` to SI; `InputError` if it is out of range."""
    like, allowed = _POINTS[name]
    number = in_si(name, value, like)
    if not 0 <= number < math.inf or (name == "load" and number == 0):
        raise InputError(f'{name} is {number:g}; it must be {allowed}, such as "{like}"')
    return number


def in_share(name: str, value: Any) -> float:
    """Convert a share to a number; `InputError` that begins with `name` if it is none."""
    plain = single_value(name, value, 0.1)
    try:
        return float(share_of(plain))
    except (InputError, OverflowError):
        raise InputError(f"{name} is {plain!r}; give a number such as 0.1") from None


def in_count(name: str, value: Any, minimum: int = 1) -> int:
    """Convert a whole number of at least `minimum`; `InputError` that begins with `name`."""
    plain = single_value(name, value, minimum)
    if isinstance(plain, str) or not (plain >= minimum and plain == plain // 1):
        raise InputError(f"{name} is {plain!r}; it must be a whole number of at least {minimum}")
    return int(plain)

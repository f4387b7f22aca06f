"""Values as users pass them in Python: to text with a unit, plain numbers, lists and tables.

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

from pipeline.messages import quoted
from pipeline.units import UnitError, share_of, to_si
from tribo import InputError

_WITHOUT_UNIT = {"", "1", "-", "–", "dimensionless"}
"""Units of numbers, as attributes of arrays state them."""
P = ParamSpec("P")
T = TypeVar("T")
_MAX_LEVELS = 10


def _is_path(value: Any) -> bool:
    return isinstance(value, str | os.PathLike)


def _is_scene(value: Any) -> bool:
    return _is_path(value) or hasattr(value, "case_table")


def _is_dataset(value: Any) -> bool:
    return _is_path(value) or type(value).__name__ == "Dataset" or hasattr(value, "drawn_by")


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_flag(value: Any) -> bool:
    return isinstance(value, bool | np.bool_)


def _is_mapping(value: Any) -> bool:
    return isinstance(value, Mapping)


def _is_case(value: Any) -> bool:
    return isinstance(value, tuple) and all(
        isinstance(label, tuple) and len(label) == 2 for label in value
    )


_PATH = _is_path, "text or a Path"
_SCENE = _is_scene, "a Sweep, or the path of a scene"
_DATASET = _is_dataset, "a Dataset of pipeline.open_sweep, or the path of a store"
_TEXT = _is_text, "text"
_FLAG = _is_flag, "True or False"
_ALLOWED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "path": _PATH, "out": _PATH, "source": _PATH, "sweep": _SCENE, "scene": _SCENE, "ds": _DATASET,
    "progress": (callable, "a function of a Progress"), "title": _TEXT, "author": _TEXT,
    "command": _TEXT, "like": _TEXT, "kind": _TEXT, "plain": _FLAG, "retry_failed": _FLAG,
    "dashboard": _FLAG, "preset": _TEXT, "changes": (_is_mapping, "a mapping of values by name"),
    "overrides": (_is_mapping, "a mapping of values by key path"),
    "name": (_is_case, "a tuple of pairs (dimension, label)"),
}  # fmt: skip
"""What arguments of public functions must be, by their names; None, too, if it is the default."""


_POINTS = {"load": ("500 N", "finite and above 0"), "velocity": ("2 m/s", "finite and at least 0")}
"""Arguments that give a point, each with an example and what is allowed."""


def typed_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator: refuse an argument of a wrong type by its name, before the function begins."""
    parameters = inspect.signature(function).parameters
    names = [*parameters]

    @functools.wraps(function)
    def checked(*arguments: P.args, **keywords: P.kwargs) -> T:
        for name, value in {**dict(zip(names, arguments, strict=False)), **keywords}.items():
            is_allowed, description = _ALLOWED.get(name, (None, ""))
            is_default = value is None and name in parameters and parameters[name].default is None
            if is_allowed and not (is_default or is_allowed(value)):
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
    """Text of a quantity of pint in base units, or the number of a dimensionless one."""
    if "delta_" in str(value.units):
        raise InputError(f"{name} is a difference of temperatures; give a temperature")
    try:
        base = value.to_base_units()
        unit = "" if base.dimensionless else f"{base.units:~C}"
    except Exception as error:  # pint raises errors that are not its own
        raise InputError(f"{name} is {value}, which cannot be converted: {error}") from error
    return plain_value(name, _rounded(name, base.magnitude), unit, level)


def _rounded(name: str, magnitude: Any) -> Any:
    """Magnitude in base units with 15 digits, so that 0.27 µm is 2.7e-07 m."""
    if isinstance(magnitude, np.ndarray | list | tuple):
        return [_rounded(name, item) for item in magnitude]
    number = plain_value(name, magnitude)
    return float(f"{number:.15g}") if isinstance(number, int | float) else number


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

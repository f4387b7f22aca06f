"""Exceptions that ``tribo`` raises.

::

    TriboError
    ├── InputError (also a ValueError)          a value that physics or the method does not allow
    ├── ConvergenceError (also a RuntimeError)  a solver that did not reach its tolerance
    ├── InvariantError                          a result that breaks a law it must obey
    └── RangeError (also an ArithmeticError)    numbers too large or small for double precision

A message says what is wrong, the value given, what is allowed and what to do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tribo.types import Array


class TriboError(Exception):
    """Base class of all exceptions that this project raises on purpose.

    Examples
    --------
    >>> import tribo
    >>> try:
    ...     tribo.Ramp(rate=-150.0, reference_load=750.0)
    ... except tribo.TriboError as error:
    ...     print(error)
    rate is -150.0; it must be finite and greater than 0
    """


class InputError(TriboError, ValueError):
    """A value that physics or the method does not allow.

    Examples
    --------
    >>> import tribo
    >>> tribo.Wear(specific_wear_rate=-1.0)
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: specific_wear_rate is -1.0; it must be finite and ≥ 0
    """


class ConvergenceError(TriboError, RuntimeError):
    """A solver did not reach its tolerance.

    Attributes
    ----------
    solution
        The best solution, of the solver's result type, with its residual.

    Examples
    --------
    >>> try:
    ...     raise ConvergenceError("the contact did not converge", solution="as far as it got")
    ... except ConvergenceError as error:
    ...     error.solution
    'as far as it got'
    """

    def __init__(self, message: str, solution: Any) -> None:
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[type[ConvergenceError], tuple[str, Any]]:
        """Pickle both arguments of the error, so that it can be sent between processes."""
        return type(self), (str(self), self.solution)


class InvariantError(TriboError):
    """A result that breaks a law it must obey, for example a law of physics.

    It shows a defect of the program, or of a user-defined wear law or surface.

    Examples
    --------
    >>> issubclass(InvariantError, TriboError)
    True
    """


class RangeError(TriboError, ArithmeticError):
    """An intermediate number is too large or too small for double precision.

    Examples
    --------
    >>> issubclass(RangeError, TriboError)
    True
    """


@contextmanager
def law_errors(name: str) -> Iterator[None]:
    """Context manager: turn an error in a user-defined law into an `InputError`.

    `name` names the law in the message. A `TriboError` is raised unchanged.
    """
    try:
        yield
    except TriboError:
        raise
    except Exception as error:
        raise InputError(f"{name}: {type(error).__name__}: {error}") from error


def require_number(**values: Any) -> None:
    """Raise `InputError` for the first value that is not one real number."""
    for name, value in values.items():
        if type(value) is float:
            continue
        try:
            if isinstance(value, str | bytes | bool) or np.ndim(value):
                raise TypeError
            float(value)
        except (TypeError, ValueError):
            raise InputError(
                f"{name} is {f'{value!r}'[:100]}; it must be one number, in SI units"
            ) from None


def require_instance(kind: type | tuple[type, ...], **values: Any) -> None:
    """Raise `InputError` for the first value that is not of a type, or of one of several."""
    for name, value in values.items():
        if not isinstance(value, kind):
            kinds = kind if isinstance(kind, tuple) else (kind,)
            allowed = " or ".join(f"tribo.{allowed.__name__}" for allowed in kinds)
            raise InputError(f"{name} is {f'{value!r}'[:100]}; it must be a {allowed}")


def require_pair(**values: Any) -> None:
    """Raise `InputError` for the first value that is not a pair of real numbers."""
    for name, value in values.items():
        if (
            not isinstance(value, Sequence | np.ndarray)
            or isinstance(value, str)
            or len(value) != 2
        ):
            raise InputError(f"{name} is {f'{value!r}'[:100]}; it must hold two values")
        for item in value:
            require_number(**{name: item})


def require_positive(**values: float) -> None:
    """Raise `InputError` for the first value that is not finite and positive."""
    require_number(**values)
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name} is {value!r}; it must be finite and greater than 0")


def require_not_negative(**values: float) -> None:
    """Raise `InputError` for the first value that is not finite and at least 0."""
    require_number(**values)
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0):
            raise InputError(f"{name} is {value!r}; it must be finite and at least 0")


def require_integer(lowest: int, **values: float) -> None:
    """Raise `InputError` for the first value that is not an integer of at least `lowest`."""
    for name, value in values.items():
        if not (isinstance(value, Integral) and value >= lowest):
            raise InputError(f"{name} is {value!r}; it must be an integer of at least {lowest}")


def real_array(name: str, values: ArrayLike) -> Array:
    """Convert values to a float64 array; `InputError` unless they are real numbers."""
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must hold real numbers: {error}") from error


def finite_field(name: str, field: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Convert `field` to a float64 array; `InputError` unless it is real, finite and of `shape`."""
    try:
        array = np.asarray(field)
    except ValueError as error:
        raise InputError(f"{name} is not an array: {error}") from error
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name} holds {array.dtype}; it must hold real numbers")
    if array.shape != shape:
        raise InputError(f"{name} has shape {array.shape}; it must be {shape}, like the grid")
    finite = np.isfinite(array)
    if not finite.all():
        nonfinite = np.argwhere(~finite)
        raise InputError(
            f"{name} holds NaN or inf at {len(nonfinite)} of {array.size} places, the first at "
            f"{tuple(nonfinite[0].tolist())}, counted from 0; every value must be finite"
        )
    return array.astype(np.float64, copy=False)

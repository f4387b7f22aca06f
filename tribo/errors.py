"""Exceptions that ``tribo`` raises.

::

    TriboError
    ├── InputError (also a ValueError)          a value that physics or the method does not allow
    └── ConvergenceError (also a RuntimeError)  a solver that did not reach its tolerance

A message says what is wrong, the value given, what is allowed and what to do.
"""

from __future__ import annotations

import math
from typing import Any

__all__ = ["ConvergenceError", "InputError", "TriboError", "require_positive"]


class TriboError(Exception):
    """Base of every exception that this project raises on purpose."""


class InputError(TriboError, ValueError):
    """A value that physics or the method does not allow."""


class ConvergenceError(TriboError, RuntimeError):
    """A solver that did not reach its tolerance.

    Attributes
    ----------
    solution
        The best solution found, of the solver's own result type, with its residual.
    """

    def __init__(self, message: str, solution: Any) -> None:
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[type[ConvergenceError], tuple[str, Any]]:
        """Pickle both arguments, since the error crosses process borders."""
        return type(self), (str(self), self.solution)


def require_positive(**values: float) -> None:
    """Raise `InputError` for the first value that is not finite and positive.

    Examples
    --------
    >>> require_positive(radius=2e-3)
    >>> require_positive(radius=-2e-3)
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: radius is -0.002; it must be finite and greater than 0
    """
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name} is {value!r}; it must be finite and greater than 0")

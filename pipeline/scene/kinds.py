"""Kinds of single values: what each allows, and how it is read.

Reading a value gives it as the program wants it; or None, and a `Fault` that says what is wrong.
``str(kind)`` says what is allowed.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from pipeline.scene.entries import did_you_mean, quoted
from pipeline.scene.faults import Fault
from pipeline.scene.units import UnitError, exact_si

_LARGEST = 1e300


class UnfitError(Exception):
    """A value that does not fit its kind; the message says why."""


class Kind(ABC):
    """Values allowed at one place of a file."""

    def read(self, value: object, place: str, faults: list[Fault]) -> Any:
        """Read a value; None if it is faulty.

        Parameters
        ----------
        value : object
            Value as TOML has it.
        place : str
            Key path of the value.
        faults : list of Fault
            List to which every fault found is added.
        """
        try:
            return self._read(value, place, faults)
        except UnfitError as problem:
            faults.append(Fault(place, f"{problem}; give {self}"))
            return None

    @abstractmethod
    def _read(self, value: Any, place: str, faults: list[Fault]) -> Any:
        """Raise `UnfitError` if the value as a whole is wrong; note the faults of its parts."""


@dataclass(frozen=True)
class Text(Kind):
    """Text that is not empty."""

    def __str__(self) -> str:
        return "text in quotes"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> str:
        if not isinstance(value, str):
            raise UnfitError(f"{quoted(value)} is not text")
        if not value:
            raise UnfitError("the text is empty")
        if "\0" in value:  # which no name of a file may have
            raise UnfitError(f"{quoted(value)} has a null character")
        return value


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    def __str__(self) -> str:
        return "true or false"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> bool:
        if not isinstance(value, bool):
            raise UnfitError(f"{quoted(value)} is neither true nor false")
        return value


@dataclass(frozen=True)
class Choice(Kind):
    """One of a few words."""

    options: tuple[str, ...]

    def __str__(self) -> str:
        *others, last = map(quoted, self.options)
        return f"{', '.join(others)} or {last}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> str:
        if not isinstance(value, str):
            raise UnfitError(f"{quoted(value)} is not text")
        if value not in self.options:
            raise UnfitError(f"{quoted(value)} is unknown{did_you_mean(value, self.options)}")
        return value


@dataclass(frozen=True)
class Number(Kind):
    """A number without a unit."""

    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf

    def __str__(self) -> str:
        return f"a number without a unit{self._limits()}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UnfitError(f"{quoted(value)} is not a plain number")
        fits = self.above < value < self.below and self.at_least <= value <= self.at_most
        if not fits or abs(value) > _LARGEST:
            raise UnfitError(f"{quoted(value)} is out of range")
        return float(value)

    def _limits(self) -> str:
        limits = {
            "above": self.above,
            "at least": self.at_least,
            "below": self.below,
            "at most": self.at_most,
        }
        bounds = [f"{word} {limit:g}" for word, limit in limits.items() if math.isfinite(limit)]
        return ", " * bool(bounds) + " and ".join(bounds)


@dataclass(frozen=True)
class Whole(Number):
    """A whole number."""

    def __str__(self) -> str:
        return f"a whole number{self._limits()}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise UnfitError(f"{quoted(value)} is not a whole number")
        super()._read(value, place, faults)
        return value


@dataclass(frozen=True)
class Quantity(Kind):
    """A positive number with a unit, read as its value in SI.

    Parameters
    ----------
    name : str
        Name of the quantity, with its article.
    example : str
        Example of it, which fixes the dimension.
    zero : bool
        True if 0 is allowed.
    exact : bool
        True if the value is kept as a decimal, without rounding.
    """

    name: str
    example: str
    zero: bool = False
    exact: bool = False

    def __str__(self) -> str:
        limit = "of at least 0" if self.zero else "above 0"
        return f"{self.name} {limit}, such as {quoted(self.example)}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> float | Decimal:
        if not isinstance(value, str):
            raise UnfitError(f"{quoted(value)} has no unit")
        try:
            exact = exact_si(value, like=self.example)
        except UnitError as error:
            raise UnfitError(str(error)) from error
        rounded = float(exact)
        if not (0 <= rounded < math.inf if self.zero else 0 < rounded < math.inf):
            raise UnfitError(f"{quoted(value)} is out of range")
        return exact if self.exact else rounded


@dataclass(frozen=True)
class Unit(Kind):
    """A unit alone, read as its value in SI."""

    name: str
    example: str

    def __str__(self) -> str:
        return f"{self.name}, such as {quoted(self.example)}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> float:
        try:
            return float(exact_si(f"1 {value}", like=f"1 {self.example}"))
        except UnitError as error:
            raise UnfitError(f"{quoted(value)} is not {self.name}") from error

"""Kinds of single values in a scene file: text, numbers and quantities.

A kind reads a value, and states what is allowed, as text (``str(kind)``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from pipeline.messages import did_you_mean, is_unprintable, quoted
from pipeline.quantities import DIMENSIONS
from pipeline.scene.faults import Faults
from pipeline.sweep.notes import unusual_warning
from pipeline.units import UnitError, exact_si, share_of, si_unit, to_si
from tribo import InputError

FROM_TESTS = "from tests"
"""Value of a critical temperature that answers find from the tests of the scene."""


class InvalidValueError(Exception):
    """A value does not fit its kind; the message says why."""


class Kind:
    """Base class of kinds of scene entry: reads a value, and states what is allowed."""

    words: ClassVar[str] = ""
    value_types: ClassVar[type | tuple[type, ...]] = ()
    """Types of values that select this kind among several."""

    def __str__(self) -> str:
        return self.words

    def read(self, value: object, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read the value of the entry at path `path`; None, with a fault added, if it is wrong.

        The fault says what is allowed: this kind, or `allowed` if it is given.
        """
        try:
            return self._read(value, path, faults)
        except (InvalidValueError, UnitError) as problem:
            faults.refuse(path, f"{problem}; give {allowed or self}")
            return None

    def _read(self, value: Any, path: str, faults: Faults) -> Any:
        """Read a value or raise an `InvalidValueError`; faults in a list are added to `faults`."""
        raise NotImplementedError


def require(value: Any, kind: type | tuple[type, ...], problem: str) -> None:
    """Raise `InvalidValueError` with a `problem` unless a value is of the type `kind`.

    True and false are not numbers.
    """
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise InvalidValueError(f"{quoted(value)} {problem}")


class Text(Kind):
    """Kind of scene entry: text that is not empty."""

    words = "text in quotes"
    value_types = str

    def _read(self, value: Any, path: str, faults: Faults) -> str:
        require(value, str, "is not text")
        if not value:
            raise InvalidValueError("the text is empty")
        if is_unprintable(value):
            raise InvalidValueError(f"{quoted(value)} has a line break or a control character")
        return str(value)


class Flag(Kind):
    """Kind of scene entry: true or false."""

    words = "true or false"
    value_types = bool

    def _read(self, value: Any, path: str, faults: Faults) -> bool:
        require(value, bool, "is neither true nor false")
        return bool(value)


@dataclass(frozen=True)
class OneOf(Kind):
    """Kind of scene entry: one of a few words."""

    value_types = str
    options: tuple[str, ...]
    translations: Mapping[str, str] = field(default_factory=dict)
    """Options for other words, which a refusal lists."""

    def __str__(self) -> str:
        *first, last = map(quoted, self.options)
        return f"{', '.join(first)} or {last}" if first else last

    def _read(self, value: Any, path: str, faults: Faults) -> str:
        require(value, str, "is not text")
        if value not in self.options:
            hint = did_you_mean(value, self.options)
            if value.lower() in self.translations:
                hint = f" (write {self.translations[value.lower()]})"
            elif self.translations and not hint:
                pairs = ", ".join(
                    f"{word} → {option}" for word, option in self.translations.items()
                )
                hint = f" ({pairs})"
            raise InvalidValueError(f"{quoted(value)} is not a valid choice{hint}")
        return str(value)


@dataclass(frozen=True)
class Number(Kind):
    """Kind of scene entry: a number without a unit."""

    words = "a number without a unit"
    value_types = (int, float)
    unit = ""
    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf
    usual: tuple[float, float] | None = None

    def __str__(self) -> str:
        bounds = {
            "above": self.above, "at least": self.at_least,
            "below": self.below, "at most": self.at_most,
        }  # fmt: skip
        texts = [f"{name} {bound:g}" for name, bound in bounds.items() if math.isfinite(bound)]
        return f"{self.words}, {' and '.join(texts)}" if texts else self.words

    def _read(self, value: Any, path: str, faults: Faults) -> float:
        require(value, (int, float), "is not a number")
        self._require_fit(value, smallest=1e-15, largest=1e15)
        faults.warnings += unusual_warning(path, value, self.usual, self.unit)
        return float(value)

    def _require_fit(self, value: float, smallest: float, largest: float) -> None:
        """Raise `InvalidValueError` if a value is outside its bounds, or too small or large."""
        if not (self.above < value < self.below and self.at_least <= value <= self.at_most):
            raise InvalidValueError(f"{quoted(value)} is outside the allowed range")
        if value and not smallest <= abs(value) <= largest:
            raise InvalidValueError(
                f"{quoted(value)} is outside the allowed range, which is {smallest:g} to "
                f"{largest:g}"
            )


class Share(Number):
    """Kind of scene entry: a share of a whole, as a number or in percent."""

    words = 'a share such as 0.1 or "10%"'

    def _read(self, value: Any, path: str, faults: Faults) -> float:
        with suppress(InputError):
            value = share_of(value)
        return super()._read(value, path, faults)


class Integer(Number):
    """Kind of scene entry: a whole number."""

    words = "a whole number"

    def _read(self, value: Any, path: str, faults: Faults) -> int:
        require(value, int, "is not a whole number")
        self._require_fit(value, smallest=0, largest=2**63 - 1)  # which a store can keep
        return int(value)


class Scalar(Kind):
    """Kind of scene entry: a number or a quantity of any dimension."""

    words = "a number, or a quantity in quotes"

    def _read(self, value: Any, path: str, faults: Faults) -> Any:
        require(value, (int, float, str), "is neither a number nor a quantity")
        return value


@dataclass(frozen=True)
class Quantity(Kind):
    """Kind of scene entry: a number with a unit, read in SI; its example fixes the dimension.

    The number must be above 0, or at least 0 if `zero` is true. With `from_tests`, the text "from
    tests" is read as NaN.
    """

    value_types = str
    example: str
    zero: bool = False
    usual: tuple[float, float] | None = None  # in the unit of the example
    ends: tuple[str, str] | None = None  # bounds, if not the dimension's
    name: str = ""  # in messages, if not the dimension's
    from_tests: bool = False

    def __str__(self) -> str:
        dimension = si_unit(self.example)
        limit = " of at least 0" if self.zero else " above 0"
        if dimension == "K":
            limit = ""  # °C may be below 0
        tests = f", or {quoted(FROM_TESTS)}" if self.from_tests else ""
        name = self.name or DIMENSIONS[dimension].name
        return f"{name}{limit}, such as {quoted(self.example)}{tests}"

    @property
    def unit(self) -> str:
        """Unit of the kind's example of a value, such as "mm" of "2 mm"."""
        return self.example.partition(" ")[2]

    def _read(self, value: Any, path: str, faults: Faults) -> float:
        if self.from_tests and value == FROM_TESTS:
            return math.nan
        if not isinstance(value, str):
            raise InvalidValueError(f"{quoted(value)} has no unit")
        number = exact_si(value, like=self.example)
        if number == 0 and self.zero:
            return float(number)
        if number <= 0:
            raise InvalidValueError(f"{quoted(value)} is outside the allowed range")
        low, high = self.ends or DIMENSIONS[si_unit(self.example)].limits
        if not exact_si(low, self.example) <= number <= exact_si(high, self.example):
            raise InvalidValueError(
                f"{quoted(value)} is outside the allowed range, which is {low} to {high}"
            )
        faults.warnings += unusual_warning(path, float(number), self.usual, self.unit)
        return float(number)


class Level(NamedTuple):
    """A load or a velocity: which of them it is, and its value in SI."""

    axis: str
    value: float


@dataclass(frozen=True)
class LoadOrVelocity(Kind):
    """Kind of scene entry: a load or a velocity, read as a `Level`."""

    load: Quantity
    velocity: Quantity

    def __str__(self) -> str:
        return f"{self.velocity} or {self.load}"

    def _read(self, value: Any, path: str, faults: Faults) -> Level:
        require(value, str, "has no unit")
        axis = {"N": "load", "m s-1": "velocity"}.get(si_unit(value))
        if axis is None:
            raise InvalidValueError(f"{quoted(value)} has the wrong dimension")
        return Level(axis, getattr(self, axis)._read(value, path, faults))


class UnitOfLength(Kind):
    """Kind of scene entry: a unit without a number, such as "um", read as its size [m]."""

    words = 'a unit of length, such as "um"'

    def _read(self, value: Any, path: str, faults: Faults) -> float:
        text = str(value)
        try:  # "2 nm" is a unit, too
            return to_si(text if text[:1].isdigit() else f"1 {text}", like="1 um")
        except UnitError as error:
            raise InvalidValueError(f"{quoted(value)} is not a unit of length") from error

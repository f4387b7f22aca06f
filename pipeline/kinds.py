"""Kinds of single values: text, numbers and quantities.

A kind reads a value, and states what is allowed, as text (``str(kind)``). Entries of scene files,
cells of tables, options of commands and arguments in Python are read by the same kinds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from pipeline.arguments import plain_value
from pipeline.faults import Fault, Faults
from pipeline.messages import did_you_mean, is_unprintable, quoted
from pipeline.quantities import DIMENSIONS, display
from pipeline.sweep.notes import unusual_warning
from pipeline.units import UnitError, exact_si, share_of, si_unit, to_si, typeset
from tribo import InputError
from tribo.simulation.usual_values import USUAL

FROM_TESTS = "from tests"
"""Value of a critical temperature that answers find from the tests of the scene."""


class InvalidValueError(UnitError):
    """A value does not fit its kind; the message says why."""


class Kind:
    """Base class of kinds of value: reads a value, and states what is allowed."""

    words: ClassVar[str] = ""
    value_types: ClassVar[type | tuple[type, ...]] = ()
    """Types of values that select this kind among several."""
    usual: tuple[float, float] | None = None
    """Usual range of numbers, in the unit in which they are printed."""

    def __str__(self) -> str:
        return self.words

    @property
    def unit(self) -> str:
        """Unit in which numbers are printed; empty for a kind without units."""
        return ""

    @property
    def si_unit(self) -> str:
        """SI unit of numbers; empty for a kind without units."""
        return ""

    def to_text(self, value: float) -> str:
        """A value in SI as text with its unit, such as "25 °C"."""
        return display(value, typeset(self.unit)).rstrip()

    def value(self, typed: object) -> Any:
        """Value of what is typed in a table or a command; `InputError` if it is wrong."""
        try:
            return self._value(typed)
        except UnitError as problem:
            raise InputError(f"{problem}; give {self}") from problem

    def argument(self, name: str, value: object) -> Any:
        """Value of an argument in Python, which may be a number in SI.

        Raises an `InputError` that begins with its `name` if it is wrong.
        """
        with self._named(name):
            plain = _single(name, value)
            if self.si_unit and not isinstance(plain, str):
                plain = f"{plain!r} {self.si_unit}"
            return self._value(plain)

    @contextmanager
    def _named(self, name: str) -> Iterator[None]:
        """Context manager: turn the error of a value into that of the argument `name`."""
        try:
            yield
        except (UnitError, OverflowError) as problem:
            or_number = f", or a number in {self.si_unit}" if self.si_unit else ""
            raise InputError(f"{name}: {problem}; give {self}{or_number}") from problem

    def read(self, value: object, path: str, faults: Faults, allowed: object = None) -> Any:
        """Value of the scene's entry at path `path`; None, with a fault added, if it is wrong.

        The fault says what is allowed: this kind, or `allowed` if it is given.
        """
        try:
            return self._read(value, path, faults)
        except UnitError as problem:
            faults.refuse(path, f"{problem}; give {allowed or self}")
            return None

    def _read(self, value: Any, path: str, faults: Faults) -> Any:
        """Read an entry or raise a `UnitError`; faults in a list are added to `faults`."""
        result = self._value(value)
        if result:  # 0 leaves an effect out
            faults.warnings += unusual_warning(path, result, self.usual, self.unit)
        return result

    def _value(self, value: Any) -> Any:
        """Value in SI; raises a `UnitError` that says what is wrong."""
        raise NotImplementedError


def _single(name: str, value: object) -> Any:
    """Convert an argument to a number or text; anything else raises an error."""
    plain = plain_value(name, value)
    if plain is None or isinstance(plain, bool | dict | list):
        raise InvalidValueError(f"{quoted(plain)} is not a number")
    return plain


def require(value: Any, kind: type | tuple[type, ...], problem: str) -> None:
    """Raise `InvalidValueError` with a `problem` unless a value is of the type `kind`.

    True and false are not numbers.
    """
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise InvalidValueError(f"{quoted(value)} {problem}")


class Text(Kind):
    """Kind of value: text that is not empty."""

    words = "text in quotes"
    value_types = str

    def _value(self, value: Any) -> str:
        require(value, str, "is not text")
        if not value:
            raise InvalidValueError("the text is empty")
        if is_unprintable(value):
            raise InvalidValueError(f"{quoted(value)} has a line break or a control character")
        return str(value)


class Flag(Kind):
    """Kind of value: true or false."""

    words = "true or false"
    value_types = bool

    def _value(self, value: Any) -> bool:
        require(value, bool, "is neither true nor false")
        return bool(value)


@dataclass(frozen=True)
class OneOf(Kind):
    """Kind of value: one of a few words."""

    value_types = str
    options: tuple[str, ...]
    translations: Mapping[str, str] = field(default_factory=dict)
    """Options for other words, which a refusal lists."""

    def __str__(self) -> str:
        *first, last = map(quoted, self.options)
        return f"{', '.join(first)} or {last}" if first else last

    def _value(self, value: Any) -> str:
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
    """Kind of value: a number without a unit."""

    words = "a number without a unit"
    value_types = (int, float)
    magnitudes: ClassVar[tuple[float, float]] = (1e-15, 1e15)
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

    def _value(self, value: Any) -> Any:
        number = self._number(value)
        if not (self.above < number < self.below and self.at_least <= number <= self.at_most):
            raise InvalidValueError(f"{quoted(value)} is outside the allowed range")
        smallest, largest = self.magnitudes
        if number and not smallest <= abs(number) <= largest:
            raise InvalidValueError(
                f"{quoted(value)} is outside the allowed range, which is {smallest:g} to "
                f"{largest:g}"
            )
        return number

    def _number(self, value: Any) -> float:
        require(value, (int, float), "is not a number")
        return float(value)


class Share(Number):
    """Kind of value: a share of a whole, as a number or in percent."""

    words = 'a share such as 0.1 or "10%"'

    def to_text(self, value: float) -> str:
        """A share in percent."""
        return display(value, "%")

    def _number(self, value: Any) -> float:
        with suppress(InputError):
            value = share_of(value)
        return super()._number(value)


class Integer(Number):
    """Kind of value: a whole number."""

    words = "a whole number"
    magnitudes = (0, 2**63 - 1)  # which a store can keep

    def _number(self, value: Any) -> int:
        require(value, int, "is not a whole number")
        return int(value)


class Scalar(Kind):
    """Kind of value: a number or a quantity of any dimension."""

    words = "a number, or a quantity in quotes"

    def _value(self, value: Any) -> Any:
        require(value, (int, float, str), "is neither a number nor a quantity")
        return value


@dataclass(frozen=True)
class Quantity(Kind):
    """Kind of value: a number with a unit, read in SI; its example fixes the dimension.

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

    @property
    def si_unit(self) -> str:
        """SI unit of the kind's dimension, such as "m"."""
        return next(iter(DIMENSIONS[si_unit(self.example)].units))

    def in_si(self, name: str, value: object) -> float:
        """Value of an argument in SI, also one outside all bounds; an `InputError` names it."""
        with self._named(name):
            plain = _single(name, value)
            return to_si(plain, self.example) if isinstance(plain, str) else float(plain)

    def _value(self, value: Any) -> float:
        if self.from_tests and value == FROM_TESTS:
            return math.nan
        if not isinstance(value, str):
            raise InvalidValueError(f"{quoted(value)} has no unit")
        number = exact_si(value, like=self.example)
        if number == 0 and self.zero:
            return float(number)
        if number <= 0 and self.ends is None:
            raise InvalidValueError(f"{quoted(value)} is outside the allowed range")
        low, high = self.ends or DIMENSIONS[si_unit(self.example)].limits
        if not exact_si(low, self.example) <= number <= exact_si(high, self.example):
            raise InvalidValueError(
                f"{quoted(value)} is outside the allowed range, which is {low} to {high}"
            )
        return float(number)


class Level(NamedTuple):
    """A load or a velocity: which of them it is, and its value in SI."""

    axis: str
    value: float


@dataclass(frozen=True)
class LoadOrVelocity(Kind):
    """Kind of value: a load or a velocity, read as a `Level`."""

    load: Quantity
    velocity: Quantity

    def __str__(self) -> str:
        return f"{self.velocity} or {self.load}"

    def _value(self, value: Any) -> Level:
        require(value, str, "has no unit")
        axis = {"N": "load", "m s-1": "velocity"}.get(si_unit(value))
        if axis is None:
            raise InvalidValueError(f"{quoted(value)} has the wrong dimension")
        return Level(axis, getattr(self, axis)._value(value))


class UnitOfLength(Kind):
    """Kind of value: a unit without a number, such as "um", read as its size [m]."""

    words = 'a unit of length, such as "um"'

    def _value(self, value: Any) -> float:
        text = str(value)
        try:  # "2 nm" is a unit, too
            return to_si(text if text[:1].isdigit() else f"1 {text}", like="1 um")
        except UnitError as error:
            raise InvalidValueError(f"{quoted(value)} is not a unit of length") from error


LOAD = Quantity("200 N")
VELOCITY = Quantity("1.25 m/s", zero=True, usual=USUAL["velocity"].ends)
SPEED = Quantity("1.25 m/s")
ACCURACY = Share(above=0, below=1)
WORKERS = Integer(at_least=1)
POINT_KINDS: dict[str, Kind] = {"load": LOAD, "velocity": SPEED}
"""Kinds of the load and velocity of an operating point."""


def faults_in(row: Mapping[str, Any], kinds: Mapping[str, Kind]) -> Iterator[Fault]:
    """Faults of a row of a table, by column; `kinds` has the kinds of columns that have one."""
    faults = Faults()
    for name, kind in kinds.items():
        if name in row:
            kind.read(row[name], name, faults)
    yield from faults

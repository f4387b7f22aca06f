"""The schema of tables: kinds of values, and classes of tables whose fields are their entries.

    class Window(Declared):
        pixels: tuple[int, int] = entry(List(Integer(at_least=1), length=2), "Number of pixels.")

An entry has a kind, a meaning, and a default if it may be left out. A kind reads a value, and
states what is allowed, as text (``str(kind)``). Faults, warnings of unusual values, and the
reference page follow from these.
"""

from __future__ import annotations

import functools
import itertools
import keyword
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from decimal import Decimal
from typing import Any, ClassVar, NamedTuple, dataclass_transform

from pipeline.limits import MAX_CASES, MAX_HINTS, MAX_ON_AXIS, MAX_VARIED_ENTRIES
from pipeline.messages import did_you_mean, is_unprintable, key_path, quoted
from pipeline.quantities import DIMENSIONS
from pipeline.scene.entries import flat
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


# Single values


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

    def __str__(self) -> str:
        *first, last = map(quoted, self.options)
        return f"{', '.join(first)} or {last}" if first else last

    def _read(self, value: Any, path: str, faults: Faults) -> str:
        require(value, str, "is not text")
        if value not in self.options:
            raise InvalidValueError(
                f"{quoted(value)} is not a valid choice{did_you_mean(value, self.options)}"
            )
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
        limit = "of at least 0" if self.zero else "above 0"
        name = self.name or DIMENSIONS[si_unit(self.example)].name
        tests = f", or {quoted(FROM_TESTS)}" if self.from_tests else ""
        return f"{name} {limit}, such as {quoted(self.example)}{tests}"

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


# Lists and ranges


@dataclass(frozen=True)
class List(Kind):
    """Kind of scene entry: a list of one or more values of one kind, read as a tuple."""

    value_types = list
    item_kind: Kind
    length: int | None = None
    distinct: bool = False
    max_length: int = MAX_CASES

    def __str__(self) -> str:
        if self.length:
            return f"a list of {self.length} values, each {self.item_kind}"
        return f"a list of values, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> tuple[Any, ...] | None:
        require(value, list, "is not a list")
        if len(value) > self.max_length:
            raise InvalidValueError(
                f"{len(value)} entries are too many, at most {self.max_length} are allowed"
            )
        if not value:
            raise InvalidValueError("[] is empty")
        items = _read_items([self.item_kind] * (self.length or len(value)), value, path, faults)
        if items and self.distinct:
            order = sorted(range(len(items)), key=lambda k: (isinstance(items[k], str), items[k]))
            for first, second in map(sorted, itertools.pairwise(order)):
                if _are_equal(items[first], items[second]):
                    problem = f"{quoted(value[second])} repeats entry [{first}]"
                    faults.refuse(f"{path}[{second}]", f"{problem}; give each value once")
        return items


def _read_items(
    kinds: Sequence[Kind], values: Sequence[Any], path: str, faults: Faults
) -> tuple[Any, ...] | None:
    """Read the values of a list, each by its kind; None if one is faulty."""
    if len(values) != len(kinds):
        raise InvalidValueError(f"{quoted(values)} needs {len(kinds)} values, not {len(values)}")
    items = tuple(
        kind.read(value, f"{path}[{index}]", faults)
        for index, (kind, value) in enumerate(zip(kinds, values, strict=True))
    )
    return None if None in items else items


def _are_equal(first: Any, second: Any) -> bool:
    """True if values are equal, or numbers that differ only by rounding."""
    return first == second or (isinstance(first, float) and math.isclose(first, second))


@dataclass(frozen=True)
class MixedList(Kind):
    """Kind of scene entry: a list of values, each of the kind at its position in `kinds`."""

    value_types = list
    kinds: tuple[Kind, ...]

    def __str__(self) -> str:
        return f"a list of {' and '.join(map(str, self.kinds))}"

    def _read(self, value: Any, path: str, faults: Faults) -> tuple[Any, ...] | None:
        require(value, list, "is not a list")
        return _read_items(self.kinds, value, path, faults)


@dataclass(frozen=True)
class Range(Kind):
    """Kind of scene entry: a range of quantities, by its ends and either a step or a count."""

    value_types = dict
    item_kind: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, and step or count, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> tuple[float, ...] | None:
        by_key: dict[str, Kind] = {"from": self.item_kind, "to": self.item_kind}
        by_key["step"] = replace(self.item_kind, zero=False)
        by_key["count"] = Integer(at_least=2, at_most=MAX_ON_AXIS)
        if value.keys() not in ({"from", "to", "step"}, {"from", "to", "count"}):
            keys = ", ".join(value)
            raise InvalidValueError(f"a table with {keys} needs from, to, and either step or count")
        values = [by_key[key].read(item, f"{path}.{key}", faults) for key, item in value.items()]
        if None in values:
            return None
        # Decimals, so that three steps of 0.1 m/s make 0.3 and not 0.30000000000000004.
        first, last = (exact_si(value[key], like=self.item_kind.example) for key in ("from", "to"))
        span = f"from {quoted(value['from'])} to {quoted(value['to'])}"
        if first > last:
            raise InvalidValueError(f'{span} is descending; "from" is the lower end')
        if count := value.get("count"):
            fractions = (Decimal(i) / (count - 1) for i in range(count))
            return tuple(float(first + fraction * (last - first)) for fraction in fractions)
        step = exact_si(value["step"], like=self.item_kind.example)
        step_count = (last - first) / step
        if step_count > MAX_ON_AXIS or abs(step_count - round(step_count)) > 1e-9:
            raise InvalidValueError(
                f"{span} there are {step_count:.6g} steps of {quoted(value['step'])}; the number "
                f"of steps must be whole, and at most {MAX_ON_AXIS}"
            )
        return tuple(float(first + i * step) for i in range(round(step_count) + 1))


class Either(Kind):
    """Kind of scene entry that allows several kinds of value, the usual one first.

    A value is read by the first kind that accepts its Python type; of several tables, the first
    whose `mark` is among its keys, or else the usual one.
    """

    def __init__(self, usual: Kind, *other_kinds: Kind) -> None:
        self.kinds = (usual, *other_kinds)

    def __str__(self) -> str:
        return "; or ".join(map(str, self.kinds))

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read a value by the kind for it, as `Kind.read` does.

        Faults of a table or list that is not of the usual kind name only its kind.
        """
        fitting = [kind for kind in self.kinds if isinstance(value, kind.value_types)]
        tables = [kind for kind in fitting if isinstance(kind, Table) and kind.mark in value]
        kind = (tables or fitting or [self.kinds[0]])[0]
        is_unusual = kind is not self.kinds[0] and kind.value_types is not str
        return kind.read(value, path, faults, None if is_unusual else self)


class Sorted(Either):
    """Kind of scene entry: a list or a range of values, sorted and without duplicates when read."""

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read a list or a range, sorted and without duplicates."""
        values = super().read(value, path, faults, allowed)
        return values and tuple(sorted(set(values)))


# Tables


class Entry(NamedTuple):
    """A key of a table: kind and meaning of its value, and its default if it may be left out."""

    kind: Kind
    meaning: str = ""
    default: Any = None
    is_needed: bool = False


def entry(kind: Kind, meaning: str, default: Any = MISSING) -> Any:
    """Field of a `Declared` class: kind and meaning of an entry, and its default, if any."""
    return field(default=default, metadata={"kind": kind, "meaning": meaning})


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(entry,))
class Declared:
    """Base class of tables of a scene file: the fields of a table are its entries.

    Pages name the table by its class, such as "random surface", or by its `form`. A value with the
    key `mark` is this table, where an entry may be one of several tables.
    """

    form: ClassVar[str] = ""
    mark: ClassVar[str] = ""

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)


@dataclass(frozen=True)
class Table(Kind):
    """Kind of scene entry: a table of fixed keys, read as an object of its `Declared` class."""

    value_types = dict
    declared: type[Declared]

    def __str__(self) -> str:
        return f"a table with {', '.join(self.needed or self.keys)}"

    @property
    def keys(self) -> dict[str, Entry]:
        """Declarations of the keys of the table."""
        declared: Any = self.declared
        return _keys_of(declared)

    @property
    def needed(self) -> list[str]:
        """Keys that may not be left out."""
        return [key for key, entry in self.keys.items() if entry.is_needed]

    @property
    def mark(self) -> str:
        """Key that tells this table from others; empty for the usual one."""
        return self.declared.mark

    @property
    def form(self) -> str:
        """Name of the table on pages."""
        name = self.declared.__name__.removesuffix("Table")
        return self.declared.form or re.sub("(?<=.)(?=[A-Z])", " ", name).lower()

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read the entries of a table, None for each faulty one; None if it is no table.

        A table that was read already is returned.
        """
        if isinstance(value, Declared):
            return value
        if not isinstance(value, dict):
            faults.refuse(path, f"{quoted(value)} is not a table; expected {allowed or self}")
            return None
        for key in (key for key in value if key not in self.keys):
            hint = did_you_mean(key, self.keys) if len(faults) < MAX_HINTS else ""
            allowed_keys = ", ".join(self.keys)
            faults.refuse(key_path(path, key), f"unknown key{hint}; allowed: {allowed_keys}")
        values = {}
        for key, entry in self.keys.items():
            name = f"{key}_" if keyword.iskeyword(key) else key
            values[name] = entry.default
            if key in value:
                values[name] = entry.kind.read(value[key], key_path(path, key), faults)
            elif entry.is_needed:
                faults.refuse(key_path(path, key), f"missing; required: {entry.kind}")
        return self.declared(**values)


@functools.cache
def _keys_of(declared: Any) -> dict[str, Entry]:
    """Declarations of the entries of a `Declared` class, by key."""

    def declaration(field: Field[Any]) -> Entry:
        if field.default is MISSING:
            return Entry(**field.metadata, is_needed=True)
        return Entry(**field.metadata, default=field.default)

    return {field.name.rstrip("_"): declaration(field) for field in fields(declared)}


@dataclass(frozen=True)
class Tables(Kind):
    """Kind of scene entry: one or more tables of one kind, under names of the user's choice."""

    value_types = dict
    item_kind: Table

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise InvalidValueError(f"{quoted(value)} is not a table of tables")
        return {
            key: self.item_kind.read(item, key_path(path, key), faults)
            for key, item in value.items()
        }


@dataclass(frozen=True)
class ByPath(Kind):
    """Kind of scene entry: a table of values by the path of another entry, such as "pin.radius".

    Without an `item_kind`, the values are read later, in place of the entries.
    """

    value_types = dict
    item_kind: Kind | None = None

    def __str__(self) -> str:
        if self.item_kind is None:
            return 'a table of entries by their paths, such as { "pin.radius" = "3 mm" }'
        return f"a table whose keys are paths of other entries, each with {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        require(value, dict, "is not a table")
        items = dict(flat(value))
        if len(items) > MAX_VARIED_ENTRIES:
            raise InvalidValueError(
                f"{len(items)} entries are too many; give {MAX_VARIED_ENTRIES} at most"
            )
        if self.item_kind is None:
            return items
        return {
            entry_path: self.item_kind.read(item, f"{path}.{quoted(entry_path)}", faults)
            for entry_path, item in items.items()
        }


def entries_in(kind: Kind, path: str = "") -> Iterator[tuple[str, Entry]]:
    """Yield the path and declaration of every entry that a table may hold, at any depth.

    In a path such as "materials.NAME.density", NAME stands for any name that the user gives.
    """
    match kind:
        case Table():
            for key, entry in kind.keys.items():
                entry_path = f"{path}.{key}" if path else key
                yield entry_path, entry
                yield from entries_in(entry.kind, entry_path)
        case Tables(item_kind):
            yield from entries_in(item_kind, f"{path}.NAME")
        case List(item_kind):
            yield from entries_in(item_kind, path)
        case Either():
            for alternative in kind.kinds:
                yield from entries_in(alternative, path)


def number_in(kind: Kind) -> Quantity | Number | None:
    """The kind of number within a list or among several kinds; None if there is none."""
    if isinstance(kind, Quantity | Number):
        return kind
    members = kind.kinds if isinstance(kind, Either) else [getattr(kind, "item_kind", None)]
    numbers = (number_in(member) for member in members if isinstance(member, Kind))
    return next((number for number in numbers if number), None)

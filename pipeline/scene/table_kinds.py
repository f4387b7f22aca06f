"""Tables and lists of a scene file. Tables are classes whose fields are their entries.

    class Window(Declared):
        pixels: tuple[int, int] = entry(List(Integer(at_least=1), length=2), "Number of pixels.")

An entry has a kind, a meaning, and a default if it may be left out. Faults, warnings
of unusual values, and the reference page follow from these.
"""

from __future__ import annotations

import functools
import itertools
import keyword
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from decimal import Decimal
from typing import Any, ClassVar, NamedTuple, dataclass_transform

from pipeline.faults import Faults
from pipeline.kinds import Integer, InvalidValueError, Kind, Number, Quantity, require
from pipeline.limits import MAX_CASES, MAX_HINTS, MAX_ON_AXIS, MAX_VARIED_ENTRIES
from pipeline.messages import did_you_mean, key_path, quoted
from pipeline.scene.entries import flat
from pipeline.units import exact_si


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
class TableKind(Kind):
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
    item_kind: TableKind

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
        tables = [kind for kind in fitting if isinstance(kind, TableKind) and kind.mark in value]
        kind = (tables or fitting or [self.kinds[0]])[0]
        is_unusual = kind is not self.kinds[0] and kind.value_types is not str
        return kind.read(value, path, faults, None if is_unusual else self)


class Sorted(Either):
    """Kind of scene entry: a list or a range of values, sorted and without duplicates when read."""

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read a list or a range, sorted and without duplicates."""
        values = super().read(value, path, faults, allowed)
        return values and tuple(sorted(set(values)))


def entries_in(kind: Kind, path: str = "") -> Iterator[tuple[str, Entry]]:
    """Yield the path and declaration of every entry that a table may hold, at any depth.

    In a path such as "materials.NAME.density", NAME stands for any name that the user gives.
    """
    match kind:
        case TableKind():
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
        if isinstance(value, dict) and str(self.item_kind).startswith("a table"):
            raise InvalidValueError(f"[{path}] is a single table; write [[{path}]]")
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

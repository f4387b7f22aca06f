"""Declared tables: a class is a table of a file, and its annotations say what is allowed.

    radius: A[float, Quantity("2 mm", usual=(0.1, 1000)), "Radius in the plane of sliding."]

Each entry has a type, a kind, a meaning, and a default if it may be left out. Reader, faults,
warnings of unusual values, reference and template follow from these.
"""

from __future__ import annotations

import functools
import itertools
import keyword
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from decimal import Decimal
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from pipeline.limits import MAX_CASES, MAX_HINTS, MAX_ON_AXIS, MAX_VARIED_ENTRIES
from pipeline.messages import did_you_mean, key_path, pluralized, quoted
from pipeline.scene.entries import flat
from pipeline.scene.faults import Faults
from pipeline.scene.kinds import (
    Flag,
    Integer,
    InvalidValueError,
    Kind,
    Number,
    OneOf,
    Quantity,
    Text,
    require,
)
from pipeline.units import exact_decimals, exact_si
from tribo.loading.ramp import MOST_STEPS


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Declared:
    """Base class of tables of a scene file: the annotated fields of a table are its entries.

    Messages name the table by its class, such as "random surface", or by the class's `form_name`.
    `refused` says why a key of another table cannot stand in this one.
    """

    refused: ClassVar[Mapping[str, str]] = {}

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)


class Entry(NamedTuple):
    """A key of a table: kind and meaning of its value, and its default if it may be left out."""

    kind: Kind
    meaning: str = ""
    default: Any = None
    is_needed: bool = False


@functools.cache
def table_of(declared: Any) -> Table:
    """Convert a `Declared` class to a `Table` of its keys and their kinds."""
    hints = get_type_hints(declared, include_extras=True)
    keys = dict[str, Entry]()
    for field in fields(declared):
        hint, is_needed = hints[field.name], field.default is MISSING
        annotations = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        keys[field.name.rstrip("_")] = Entry(
            kind_of(hint),
            meaning=next((text for text in annotations if isinstance(text, str)), ""),
            default=None if is_needed else field.default,
            is_needed=is_needed,
        )
    class_name = declared.__name__.removesuffix("Table")
    spaced_name = re.sub("(?<=.)(?=[A-Z])", " ", class_name).lower()
    return Table(keys, declared, getattr(declared, "form_name", spaced_name))


def kind_of(hint: Any) -> Kind:
    """Kind of an entry from its type hint: the `Kind` in its annotation, else one for its type."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        kinds = (kind for kind in arguments[1:] if isinstance(kind, Kind))
        return next(kinds, None) or kind_of(arguments[0])
    if origin in (Union, UnionType):
        alternatives = [kind_of(member) for member in arguments if member is not NoneType]
        return Either(*alternatives) if len(alternatives) > 1 else alternatives[0]
    if origin is Literal:
        return OneOf(arguments)
    if origin is tuple:
        return List(kind_of(arguments[0]), None if arguments[-1] is ... else len(arguments))
    if origin is dict:
        return Tables(kind_of(arguments[1]))
    if isinstance(hint, type) and is_dataclass(hint):
        return table_of(hint)
    return {int: Integer(at_most=MOST_STEPS), float: Number(), bool: Flag(), str: Text()}[hint]


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
        if self.length and len(value) != self.length:
            count = pluralized(len(value), "entry", "entries")
            raise InvalidValueError(f"{quoted(value)} has {count}")
        items = _read_items([self.item_kind] * len(value), value, path, faults)
        if items and self.distinct:
            order = sorted(range(len(items)), key=lambda k: (isinstance(items[k], str), items[k]))
            for pair in itertools.pairwise(order):
                first, second = sorted(pair)
                if _are_equal(items[first], items[second]):
                    problem = f"{quoted(value[second])} repeats entry [{first}]"
                    faults.refuse(f"{path}[{second}]", f"{problem}; give each value once")
        return items


def _read_items(
    kinds: Sequence[Kind], values: Sequence[Any], path: str, faults: Faults
) -> tuple[Any, ...] | None:
    """Read the values of a list, each by its kind; None if one is faulty."""
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
        if len(value) != len(self.kinds):
            raise InvalidValueError(
                f"{quoted(value)} needs {len(self.kinds)} values, not {len(value)}"
            )
        return _read_items(self.kinds, value, path, faults)


@dataclass(frozen=True)
class Range(Kind):
    """Kind of scene entry: a range of quantities, by its ends and either a step or a count."""

    value_types = dict
    item_kind: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, and step or count, each {self.item_kind}"

    @exact_decimals()
    def _read(self, value: Any, path: str, faults: Faults) -> tuple[float, ...] | None:
        fault_count = len(faults)
        entries = {
            "from": Entry(self.item_kind, is_needed=True),
            "to": Entry(self.item_kind, is_needed=True),
            "step": Entry(replace(self.item_kind, zero=False)),
            "count": Entry(Integer(at_least=2, at_most=MAX_ON_AXIS)),
        }
        Table(entries).read(value, path, faults)
        if len(faults) > fault_count:
            return None
        # Decimals, so that three steps of 0.1 m/s make 0.3 and not 0.30000000000000004.
        first, last = (exact_si(value[key], like=self.item_kind.example) for key in ("from", "to"))
        span = f"from {quoted(value['from'])} to {quoted(value['to'])}"
        if first > last:
            raise InvalidValueError(f'{span} is descending; "from" is the lower end')
        if ("step" in value) == ("count" in value):
            raise InvalidValueError(f"{span} needs either step or count")
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
    """Kind of scene entry that allows several kinds of value.

    The first kind reads the value, with two exceptions:

    - If the first kind is not a table, the first of the other kinds that accepts the Python type of
      the value reads the value.
    - If the first kind is a table, and the value has keys unknown to this table, the other table
      that knows most of these keys reads the value.
    """

    def __init__(self, usual: Kind, *other_kinds: Kind) -> None:
        self.kinds = (usual, *other_kinds)

    def __str__(self) -> str:
        return "; or ".join(map(str, self.kinds))

    def kind_for(self, value: Any) -> Kind:
        """Choose the kind by which to read a value."""
        usual, *other_kinds = self.kinds
        if not isinstance(usual, Table):
            fitting = (kind for kind in other_kinds if isinstance(value, kind.value_types))
            return next(fitting, usual)
        if not isinstance(value, dict):
            return usual
        unknown_keys = value.keys() - usual.keys.keys()
        tables = [kind for kind in other_kinds if isinstance(kind, Table)]
        known_counts = [len(unknown_keys & table.keys.keys()) for table in tables]
        if not any(known_counts):
            return usual
        return tables[known_counts.index(max(known_counts))]

    def read(self, value: object, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read a value by the kind for it, as `Kind.read` does.

        Faults of a table or list that is not of the usual kind name only its kind.
        """
        kind = self.kind_for(value)
        is_unusual = kind is not self.kinds[0] and kind.value_types is not str
        return kind.read(value, path, faults, None if is_unusual else self)


class Sorted(Either):
    """Kind of scene entry: a list or a range of values, sorted and without duplicates when read."""

    def read(self, value: object, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read a list or a range, sorted and without duplicates."""
        values = super().read(value, path, faults, allowed)
        return values and tuple(sorted(set(values)))


@dataclass(frozen=True)
class Table(Kind):
    """Kind of scene entry: a table of fixed keys.

    The function `construct` is called with the values of the keys, None for a faulty value. `form`
    is the name of this table where an entry may be one of several tables.
    """

    value_types = dict
    keys: Mapping[str, Entry]
    construct: Callable[..., Any] = dict
    form: str = ""

    def __str__(self) -> str:
        return f"a table with {', '.join(self.needed or self.keys)}"

    @property
    def needed(self) -> list[str]:
        """Keys that may not be left out."""
        return [key for key, entry in self.keys.items() if entry.is_needed]

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read the entries of a table, and construct an object of them; None if it is no table.

        A table that was read already is returned.
        """
        if isinstance(value, Declared):
            return value
        if not isinstance(value, dict):
            faults.refuse(path, f"{quoted(value)} is not a table; expected {allowed or self}")
            return None
        for key in value:
            if key not in self.keys:
                hint = did_you_mean(key, self.keys) if len(faults) < MAX_HINTS else ""
                problem = f"unknown key{hint}; allowed: {', '.join(self.keys)}"
                refused_keys = getattr(self.construct, "refused", {})
                faults.refuse(key_path(path, key), refused_keys.get(key, problem))
        values = {}
        for key, entry in self.keys.items():
            attribute = f"{key}_" if keyword.iskeyword(key) else key
            values[attribute] = entry.default
            if key in value:
                values[attribute] = entry.kind.read(value[key], key_path(path, key), faults)
            elif entry.is_needed:
                faults.refuse(key_path(path, key), f"missing; required: {entry.kind}")
        return self.construct(**values)


@dataclass(frozen=True)
class Tables(Kind):
    """Kind of scene entry: one or more tables of one kind, under names of the user's choice."""

    value_types = dict
    item_kind: Kind

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise InvalidValueError(f"{quoted(value)} is not a table of tables")
        return {
            key: self.item_kind.read(item, key_path(path, key), faults)
            for key, item in value.items()
        }


class Changes(Kind):
    """Kind of scene entry: other entries of the scene, by paths, which are read there."""

    words = 'a table of entries by their paths, such as { "pin.radius" = "3 mm" }'
    value_types = dict

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        require(value, dict, "is not a table")
        changes = dict(flat(value))
        if len(changes) > MAX_VARIED_ENTRIES:
            raise InvalidValueError(
                f"{len(changes)} entries are too many; give {MAX_VARIED_ENTRIES} at most"
            )
        return changes


@dataclass(frozen=True)
class ByPath(Kind):
    """Kind of scene entry: a table of values by the path of another entry, such as "pin.radius"."""

    value_types = dict
    item_kind: Kind
    keys: str

    def __str__(self) -> str:
        return f"a table whose keys are {self.keys}, each with {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        require(value, dict, "is not a table")
        items = {
            entry_path: self.item_kind.read(item, f"{path}.{quoted(entry_path)}", faults)
            for entry_path, item in flat(value)
        }
        return {entry_path: item for entry_path, item in items.items() if item is not None}


def entries_in(kind: Kind, path: str = "") -> Iterator[tuple[str, Entry]]:
    """Yield the path and declaration of every entry that a table may hold, at any depth.

    In a path such as "materials.NAME.density", NAME stands for any name that the user gives.
    """
    match kind:
        case Table(keys):
            for key, entry in keys.items():
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

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
from collections.abc import Callable, Iterator, Mapping
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

from pipeline.limits import MOST_HINTS, MOST_ON_AXIS, MOST_SCENES, MOST_VARIED
from pipeline.messages import did_you_mean, key_path, quoted
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
def table_of(table: Any) -> Table:
    """Convert a `Declared` class to a `Table` of its keys and their kinds; cached."""
    hints = get_type_hints(table, include_extras=True)
    keys = dict[str, Entry]()
    for field in fields(table):
        hint, is_needed = hints[field.name], field.default is MISSING
        notes = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        keys[field.name.rstrip("_")] = Entry(
            kind_of(hint),
            meaning=next((note for note in notes if isinstance(note, str)), ""),
            default=None if is_needed else field.default,
            is_needed=is_needed,
        )
    name = table.__name__.removesuffix("Table")
    words = re.sub("(?<=.)(?=[A-Z])", " ", name).lower()
    return Table(keys, table, getattr(table, "form_name", words))


def attribute_of(key: str) -> str:
    """Name of the attribute with the value of a key; words of Python get an underscore."""
    return f"{key}_" if keyword.iskeyword(key) else key


def kind_of(hint: Any) -> Kind:
    """Kind of an entry from its type hint: the `Kind` in its annotation, else one for its type."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        annotated = (note for note in args[1:] if isinstance(note, Kind))
        return next(annotated, None) or kind_of(args[0])
    if origin in (Union, UnionType):
        kinds = [kind_of(member) for member in args if member is not NoneType]
        return Either(*kinds) if len(kinds) > 1 else kinds[0]
    if origin is Literal:
        return OneOf(args)
    if origin is tuple:
        return List(kind_of(args[0]), None if args[-1] is ... else len(args))
    if origin is dict:
        return Tables(kind_of(args[1]))
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
    max_length: int = MOST_SCENES

    def __str__(self) -> str:
        return f"a list of {f'{self.length} ' if self.length else ''}values, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> tuple[Any, ...] | None:
        require(value, list, "is not a list")
        if len(value) > self.max_length:
            raise InvalidValueError(
                f"{len(value)} entries are too many, at most {self.max_length} are allowed"
            )
        if len(value) != (self.length or max(len(value), 1)):
            count = f"has {len(value)} {'entry' if len(value) == 1 else 'entries'}"
            raise InvalidValueError(f"{quoted(value)} {count if value else 'is empty'}")
        items = [self.item_kind.read(item, f"{path}[{i}]", faults) for i, item in enumerate(value)]
        if self.distinct and None not in items:
            order = sorted(range(len(items)), key=lambda k: (isinstance(items[k], str), items[k]))
            for pair in itertools.pairwise(order):
                first, index = sorted(pair)
                if _are_alike(items[first], items[index]):
                    problem = f"{quoted(value[index])} repeats entry [{first}]"
                    faults.refuse(f"{path}[{index}]", f"{problem}; give each value once")
        return None if None in items else tuple(items)


def _are_alike(a: Any, b: Any) -> bool:
    """True if values are equal, or numbers that differ only by rounding."""
    return a == b or (isinstance(a, float) and math.isclose(a, b, rel_tol=1e-9))


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
        pairs = zip(self.kinds, value, strict=True)
        items = [kind.read(item, f"{path}[{i}]", faults) for i, (kind, item) in enumerate(pairs)]
        return None if None in items else tuple(items)


@dataclass(frozen=True)
class Range(Kind):
    """Kind of scene entry: a range of quantities, by its ends and either a step or a count."""

    value_types = dict
    item_kind: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, and step or count, each {self.item_kind}"

    @exact_decimals()
    def _read(self, value: Any, path: str, faults: Faults) -> tuple[float, ...] | None:
        fault_count, end = len(faults), Entry(self.item_kind, is_needed=True)
        step_apart = Entry(replace(self.item_kind, zero=False))
        number = Entry(Integer(at_least=2, at_most=MOST_ON_AXIS))
        keys = {"from": end, "to": end, "step": step_apart, "count": number}
        Table(keys).read(value, path, faults)
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
            parts = (Decimal(i) / (count - 1) for i in range(count))
            return tuple(float(first + part * (last - first)) for part in parts)
        step = exact_si(value["step"], like=self.item_kind.example)
        steps = (last - first) / step
        if steps > MOST_ON_AXIS or abs(steps - round(steps)) > 1e-9:
            raise InvalidValueError(
                f"{span} there are {steps:.6g} steps of {quoted(value['step'])}; the number of "
                f"steps must be whole, and at most {MOST_ON_AXIS}"
            )
        return tuple(float(first + i * step) for i in range(round(steps) + 1))


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
            fits = (isinstance(value, other.value_types) for other in other_kinds)
            return next(itertools.compress(other_kinds, fits), usual)
        if not isinstance(value, dict):
            return usual
        unknown_keys = value.keys() - usual.keys.keys()
        forms = (kind for kind in other_kinds if isinstance(kind, Table))
        best = max(forms, key=lambda form: len(unknown_keys & form.keys.keys()), default=usual)
        return best if unknown_keys & best.keys.keys() else usual

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

    The function `make` is called with the values of the keys, None for a faulty value. `form` is
    the name of this table where an entry may be one of several tables.
    """

    value_types = dict
    keys: Mapping[str, Entry]
    make: Callable[..., Any] = dict
    form: str = ""

    def __str__(self) -> str:
        return f"a table with {', '.join(self.needed or self.keys)}"

    @property
    def needed(self) -> list[str]:
        """Keys that may not be left out."""
        return [key for key, entry in self.keys.items() if entry.is_needed]

    def read(self, value: Any, path: str, faults: Faults, allowed: object = None) -> Any:
        """Read the entries of a table, and make an object of them; None if it is no table.

        A table that was read already is returned.
        """
        if isinstance(value, Declared):
            return value
        if not isinstance(value, dict):
            faults.refuse(path, f"{quoted(value)} is not a table; expected {allowed or self}")
            return None
        for key in value:
            if key not in self.keys:
                hint = did_you_mean(key, self.keys) if len(faults) < MOST_HINTS else ""
                problem = f"unknown key{hint}; allowed: {', '.join(self.keys)}"
                problem = getattr(self.make, "refused", {}).get(key, problem)
                faults.refuse(key_path(path, key), problem)
        entries = {}
        for key, entry in self.keys.items():
            name = attribute_of(key)
            entries[name] = entry.default
            if key in value:
                entries[name] = entry.kind.read(value[key], key_path(path, key), faults)
            elif entry.is_needed:
                faults.refuse(key_path(path, key), f"missing; required: {entry.kind}")
        return self.make(**entries)


@dataclass(frozen=True)
class Tables(Kind):
    """Kind of scene entry: one or more tables of one kind, under names of the user's choice."""

    value_types = dict
    item_kind: Kind

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.item_kind}"

    def _read(self, value: Any, path: str, faults: Faults) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise InvalidValueError(f"{quoted(value)} is not a table that holds tables")
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
        if len(changes) > MOST_VARIED:
            raise InvalidValueError(
                f"{len(changes)} entries are too many; give {MOST_VARIED} at most"
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
        read = {
            entry: self.item_kind.read(leaf, f"{path}.{quoted(entry)}", faults)
            for entry, leaf in flat(value)
        }
        return {entry: leaf for entry, leaf in read.items() if leaf is not None}


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


@functools.cache
def keys_of(table: Any) -> dict[str, Entry]:
    """Declarations of all entries in a table, by path; the first of several forms counts."""
    return dict(reversed([*entries_in(table_of(table))]))


def number_at(table: Any, path: str) -> Quantity | Number:
    """Kind of the number that an entry holds; without an entry, a `Number` without bounds."""
    entry = keys_of(table).get(re.sub(r"^materials\.[^.]+", "materials.NAME", path))
    return (entry and _number_in(entry.kind)) or Number()


def _number_in(kind: Kind) -> Quantity | Number | None:
    """The kind of number within a list or among several kinds; None if there is none."""
    if isinstance(kind, Quantity | Number):
        return kind
    inner = kind.kinds if isinstance(kind, Either) else [getattr(kind, "item_kind", None)]
    numbers = (_number_in(item) for item in inner if isinstance(item, Kind))
    return next((number for number in numbers if number), None)

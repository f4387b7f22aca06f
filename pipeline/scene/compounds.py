"""Kinds of compound values: lists, ranges and tables of single values."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any, get_type_hints

from pipeline.docstrings import first_sentences
from pipeline.scene.faults import Faults, did_you_mean, joined, quoted
from pipeline.scene.kinds import Kind, OneOf, Quantity, UnfitError, Whole, kind_of, require
from pipeline.scene.units import exact_si

_MOST_STEPS = 100_000


@dataclass(frozen=True)
class Entry:
    """A key of a table: kind and meaning of its value, and an example if its kind has none."""

    kind: Kind
    meaning: str = ""
    example: Any = None
    default: Any = None


class Optional(Entry):
    """A key that may be left out."""


@dataclass(frozen=True)
class List(Kind):
    """Values of one kind, at least one of them, read as a tuple."""

    of: Kind
    length: int | None = None
    distinct: bool = False

    def __str__(self) -> str:
        return f"a list of {f'{self.length} ' if self.length else ''}values, each {self.of}"

    def _read(self, value: Any, place: str, faults: Faults) -> tuple[Any, ...] | None:
        require(value, list, "is not a list")
        if len(value) != (self.length or max(len(value), 1)):
            count = f"has {len(value)} {'entry' if len(value) == 1 else 'entries'}"
            raise UnfitError(f"{quoted(value)} {count if value else 'is empty'}")
        items = [self.of.read(item, f"{place}[{i}]", faults) for i, item in enumerate(value)]
        if self.distinct:
            first: dict[Any, int] = {}
            for index, item in enumerate(items):
                if item is not None and first.setdefault(item, index) != index:
                    problem = f"{quoted(value[index])} equals entry [{first[item]}]"
                    faults.refuse(f"{place}[{index}]", f"{problem}; give each value once")
        return None if None in items else tuple(items)


@dataclass(frozen=True)
class Range(Kind):
    """Quantities between two ends, a step apart, or a count at even steps or equal factors."""

    of: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, and step or count, each {self.of}"

    @property
    def ends(self) -> Table:
        """Both ends, and what lies between them."""
        end, step = Entry(self.of), Optional(replace(self.of, zero=False))
        count, spacing = Whole(at_least=2, at_most=_MOST_STEPS), OneOf(("linear", "log"))
        between = {"count": Optional(count), "spacing": Optional(spacing)}
        return Table({"from": end, "to": end, "step": step} | between)

    def _read(self, value: Any, place: str, faults: Faults) -> tuple[float, ...] | None:
        before = len(faults)
        read = self.ends.read(value, place, faults)
        if read is None or len(faults) > before:
            return None
        # Decimals, so that three steps of 0.1 m/s make 0.3 and not 0.30000000000000004.
        first, last = (exact_si(value[key], like=self.of.example) for key in ("from", "to"))
        span = f"from {quoted(value['from'])} to {quoted(value['to'])}"
        if first > last:
            raise UnfitError(f"{span} falls, and from is the lower end")
        step, count, is_log = read["step"], read["count"], read["spacing"] == "log"
        if (step is None) == (count is None):
            has = "has neither step nor count" if step is None else "has both step and count"
            raise UnfitError(f"{span} {has}")
        if is_log and (step or not first):
            why = "has a step" if step else "begins at 0"
            raise UnfitError(f'{span} {why}, and spacing = "log" takes count, and from above 0')
        if count:
            parts = [Decimal(i) / (count - 1) for i in range(count)]
            if is_log:
                return tuple(float(first * (last / first) ** part) for part in parts)
            return tuple(float(first + part * (last - first)) for part in parts)
        step = exact_si(value["step"], like=self.of.example)
        steps = (last - first) / step
        if steps > _MOST_STEPS or abs(steps - round(steps)) > 1e-9:
            raise UnfitError(
                f"{span} there are {steps:.6g} steps of {quoted(value['step'])}, not a whole "
                f"number up to {_MOST_STEPS}"
            )
        return tuple(float(first + i * step) for i in range(round(steps) + 1))


class Either(Kind):
    """One of several kinds: the first, or the one that `when` or the form of a value names.

    `when` gives the number of a value's kind, or True for the second. A table has the form that
    shares most of its keys, not counting those of the first form.
    """

    def __init__(
        self, usual: Kind, *others: Kind, when: Callable[[Any], int] | None = None
    ) -> None:
        self.kinds, self._when = (usual, *others), when

    def __str__(self) -> str:
        return "; or ".join(map(str, self.kinds))

    def kind_for(self, value: Any) -> Kind:
        """The kind that a value is to be read as."""
        usual, *others = self.kinds
        if self._when:
            return self.kinds[self._when(value)]
        if not isinstance(usual, Table):
            fits = (isinstance(value, list if isinstance(x, List) else dict) for x in others)
            return next(itertools.compress(others, fits), usual)
        tables = [other for other in others if isinstance(other, Table)]
        keys = value.keys() - usual.keys.keys() if isinstance(value, dict) else set[str]()
        best = max(tables, key=lambda table: len(keys & table.keys.keys()), default=usual)
        return best if keys & best.keys.keys() else usual

    def _read(self, value: Any, place: str, faults: Faults) -> Any:
        kind = self.kind_for(value)
        if kind is not self.kinds[0]:
            return kind.read(value, place, faults)  # a fault asks for this form alone
        return kind._read(value, place, faults)


@dataclass(frozen=True)
class Table(Kind):
    """A table of fixed keys, read as a dict, None where faulty; `form` names one of several."""

    keys: Mapping[str, Entry]
    form: str = ""

    def __str__(self) -> str:
        return f"a table with {', '.join(self.needed or self.keys)}"

    @property
    def needed(self) -> list[str]:
        """Keys that may not be left out."""
        return [key for key, entry in self.keys.items() if not isinstance(entry, Optional)]

    def _read(self, value: Any, place: str, faults: Faults) -> dict[str, Any]:
        require(value, dict, "is not a table")
        for key in value:
            if key not in self.keys:
                hint = did_you_mean(key, self.keys)
                problem = f"unknown key{hint}; give one of {', '.join(self.keys)}"
                faults.refuse(joined(place, key), problem)
        entries = {}
        for key, entry in self.keys.items():
            if key in value:
                entries[key] = entry.kind.read(value[key], joined(place, key), faults)
            elif isinstance(entry, Optional):
                entries[key] = entry.default
            else:
                entries[key] = None
                faults.refuse(joined(place, key), f"missing; give {entry.kind}")
        return entries


@dataclass(frozen=True)
class Tables(Kind):
    """Tables of one kind, at least one, under names of the user's choice."""

    of: Table

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.of}"

    def _read(self, value: Any, place: str, faults: Faults) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise UnfitError(f"{quoted(value)} is not a table that holds tables")
        return {
            name: self.of.read(table, joined(place, name), faults) for name, table in value.items()
        }


@dataclass(frozen=True)
class ByPath(Kind):
    """Values of one kind by the paths of entries, in quotes or as tables in tables."""

    of: Kind
    keys: str

    def __str__(self) -> str:
        return f"a table whose keys are {self.keys}, each with {self.of}"

    def _read(self, value: Any, place: str, faults: Faults) -> dict[str, Any]:
        require(value, dict, "is not a table")
        read = {
            path: self.of.read(leaf, f"{place}.{quoted(path)}", faults)
            for path, leaf in self.leaves(value)
        }
        return {path: leaf for path, leaf in read.items() if leaf is not None}

    def leaves(self, value: dict[str, Any]) -> Iterator[tuple[str, Any]]:
        """Paths of entries, and what stands at each in the file."""
        return flat(value, "", self.of.leaf_keys)


def flat(
    tables: dict[str, Any], above: str = "", ends: Collection[str] = ()
) -> Iterator[tuple[str, Any]]:
    """Paths and values of nested tables; a table that is empty or has a key of `ends` is one."""
    for key, inner in tables.items():
        path = f"{above}.{key}" if above else key
        if isinstance(inner, dict) and inner and not set(ends) & set(inner):
            yield from flat(inner, path, ends)
        else:
            yield path, inner


def fields_of(kind: type[Any]) -> dict[str, Entry]:
    """Fields of a class as entries, each with the first sentence on it in the docstring."""
    sentences = {
        name: f"{sentence}.".replace('``"', '"').replace('"``', '"')
        for name, sentence in first_sentences(kind.__doc__ or "").items()
    }
    hints = get_type_hints(kind)
    return {name: Optional(kind_of(hint), sentences[name]) for name, hint in hints.items()}

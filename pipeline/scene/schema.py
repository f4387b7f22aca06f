"""Kinds of which a file format is made: lists, ranges and tables of the kinds of single values.

A format is a tree of kinds, one for each place in the file. Reading a value gives it as the
program wants it; or None, and a `Fault` for everything that is wrong. A table with a fault still
gives its sound entries, so that these can be checked further.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pipeline.scene.entries import did_you_mean, joined, quoted
from pipeline.scene.faults import Fault
from pipeline.scene.kinds import Kind, Quantity, UnfitError

_MOST_STEPS = 100_000


@dataclass(frozen=True)
class List(Kind):
    """Values of one kind, at least one of them, read as a tuple."""

    of: Kind
    length: int | None = None
    distinct: bool = False

    def __str__(self) -> str:
        return f"a list{f' of {self.length}' if self.length else ''}, each {self.of}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> tuple[Any, ...] | None:
        if not isinstance(value, list):
            raise UnfitError(f"{quoted(value)} is not a list")
        if len(value) != (self.length or max(len(value), 1)):
            count = f"has {len(value)} {'entry' if len(value) == 1 else 'entries'}"
            raise UnfitError(f"{quoted(value)} {count if value else 'is empty'}")
        entries = [
            self.of.read(item, f"{place}[{index}]", faults) for index, item in enumerate(value)
        ]
        if self.distinct:
            first: dict[Any, int] = {}
            for index, item in enumerate(entries):
                if item is not None and first.setdefault(item, index) != index:
                    problem = f"{quoted(value[index])} equals entry [{first[item]}]"
                    faults.append(Fault(f"{place}[{index}]", f"{problem}; give each value once"))
        return None if None in entries else tuple(entries)


@dataclass(frozen=True)
class Range(Kind):
    """Evenly spaced quantities, ``{ from = ..., to = ..., step = ... }``, read as a tuple."""

    of: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, step, each {self.of}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> tuple[float, ...] | None:
        # Decimals, so that three steps of 0.1 m/s make 0.3 and not 0.30000000000000004.
        end = replace(self.of, exact=True)
        step = replace(end, zero=False)
        entries = Table({"from": end, "to": end, "step": step}).read(value, place, faults)
        if entries is None or None in entries.values():
            return None
        steps = (entries["to"] - entries["from"]) / entries["step"]
        if not 0 <= steps <= _MOST_STEPS or abs(steps - round(steps)) > 1e-9:
            raise UnfitError(
                f"from {quoted(value['from'])} to {quoted(value['to'])} there are {steps:.6g} "
                f"steps of {quoted(value['step'])}, not a whole number up to {_MOST_STEPS}"
            )
        return tuple(float(entries["from"] + i * entries["step"]) for i in range(round(steps) + 1))


@dataclass(frozen=True)
class Either(Kind):
    """`other` where `when` is true of the value, `usual` where not."""

    usual: Kind
    other: Kind
    when: Callable[[Any], bool]

    def __str__(self) -> str:
        return f"{self.usual}; or {self.other}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> Any:
        return (self.other if self.when(value) else self.usual)._read(value, place, faults)


@dataclass(frozen=True)
class Optional:
    """A key of a table that may be left out."""

    kind: Kind
    default: Any = None


@dataclass(frozen=True)
class Table(Kind):
    """A table of fixed keys, read as a dict of all of them, None where faulty."""

    keys: Mapping[str, Kind | Optional]

    def __str__(self) -> str:
        return f"a table with {', '.join(self.needed or self.keys)}"

    @property
    def needed(self) -> list[str]:
        """Keys that may not be left out."""
        return [key for key, entry in self.keys.items() if not isinstance(entry, Optional)]

    def _read(self, value: Any, place: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise UnfitError(f"{quoted(value)} is not a table")
        for key in value:
            if key not in self.keys:
                hint = did_you_mean(key, self.keys)
                problem = f"unknown key{hint}; give one of {', '.join(self.keys)}"
                faults.append(Fault(joined(place, key), problem))
        entries = {}
        for key, entry in self.keys.items():
            kind = entry.kind if isinstance(entry, Optional) else entry
            if key in value:
                entries[key] = kind.read(value[key], joined(place, key), faults)
            else:
                entries[key] = entry.default if isinstance(entry, Optional) else None
                if kind is entry:
                    faults.append(Fault(joined(place, key), f"missing; give {kind}"))
        return entries


@dataclass(frozen=True)
class Scalar(Kind):
    """A number, or a quantity whose dimension another entry fixes."""

    def __str__(self) -> str:
        return "a number, or a quantity in quotes"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> float | int | str:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise UnfitError(f"{quoted(value)} is neither a number nor a quantity")
        return value


def _flat(tables: dict[str, Any], above: str, ends: Collection[str]) -> Iterator[tuple[str, Any]]:
    """Paths, and what stands there: no table, an empty one, or one with any of some keys."""
    for key, inner in tables.items():
        path = f"{above}.{key}" if above else key
        if isinstance(inner, dict) and inner and not set(ends) & set(inner):
            yield from _flat(inner, path, ends)
        else:
            yield path, inner


@dataclass(frozen=True)
class ByPath(Kind):
    """Values of one kind by the paths of entries, in quotes or as tables in tables."""

    of: Kind

    def __str__(self) -> str:
        return f"a table with the paths of others, each with {self.of}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise UnfitError(f"{quoted(value)} is not a table")
        read = {
            path: self.of.read(leaf, f"{place}.{quoted(path)}", faults)
            for path, leaf in _flat(value, "", ())
        }
        return {path: leaf for path, leaf in read.items() if leaf is not None}


@dataclass(frozen=True)
class Distributions(Kind):
    """Distributions of entries, by the entries' paths, in quotes or as tables in tables.

    Parameters
    ----------
    of : list of Table
        Allowed keys of a distribution.
    listed : Kind
        A list in place of a distribution.
    """

    of: tuple[Table, ...]
    listed: Kind

    def __str__(self) -> str:
        pairs = [" and ".join(table.needed) for table in self.of]
        return f"a table with {', or '.join(pairs)}; or {self.listed}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise UnfitError(f"{quoted(value)} is not a table")
        ours = {key for table in self.of for key in table.keys}
        entries = {
            path: self._one(leaf, path, place, faults) for path, leaf in _flat(value, "", ours)
        }
        return {path: leaf for path, leaf in entries.items() if leaf is not None}

    def _one(self, value: Any, path: str, place: str, faults: list[Fault]) -> Any:
        key = f"{place}.{quoted(path)}"
        if isinstance(value, list):
            return self.listed.read(value, key, faults)
        keys = set(value) if isinstance(value, dict) else set()
        fits = (table for table in self.of if set(table.needed) <= keys <= set(table.keys))
        table = next(fits, None)
        if table is None:
            shown = f"a table with {', '.join(value)}" if isinstance(value, dict) else quoted(value)
            faults.append(Fault(key, f"{shown} is not a distribution; give {self}"))
            return None
        read = table.read(value, key, faults)
        return None if None in read.values() else read


@dataclass(frozen=True)
class Tables(Kind):
    """Tables of one kind, at least one, under names of the user's choice."""

    of: Table

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.of}"

    def _read(self, value: Any, place: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise UnfitError(f"{quoted(value)} is not a table that holds tables")
        return {
            name: self.of.read(table, joined(place, name), faults) for name, table in value.items()
        }

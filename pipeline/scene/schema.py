"""Kinds of values, of which a file format is made, and their reader, which finds every fault.

A format is a tree of kinds, one for each place in the file. Reading a value gives it as the
program wants it; or None, and a `Fault` for everything that is wrong. A table with a fault still
gives its sound entries, so that these can be checked further. ``str(kind)`` says what is allowed.
"""

from __future__ import annotations

import difflib
import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from pipeline.scene.faults import Fault
from pipeline.scene.units import UnitError, exact_si

_MOST_STEPS = 10_000
_LARGEST = 1e300


class UnfitError(Exception):
    """A value that does not fit its kind; the message says why."""


class Kind(ABC):
    """What is allowed at one place of a file."""

    def read(self, value: object, at: str, faults: list[Fault]) -> Any:
        """Read a value; None if it is faulty.

        Parameters
        ----------
        value : object
            Value as TOML has it.
        at : str
            Key path of the value.
        faults : list of Fault
            List to which every fault found is added.
        """
        try:
            return self._read(value, at, faults)
        except UnfitError as problem:
            faults.append(Fault(at, f"{problem}; give {self}"))
            return None

    @abstractmethod
    def _read(self, value: Any, at: str, faults: list[Fault]) -> Any:
        """Raise `UnfitError` if the value as a whole is wrong; note the faults of its parts."""


@dataclass(frozen=True)
class Text(Kind):
    """Text that is not empty."""

    def __str__(self) -> str:
        return "text in quotes"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> str:
        if not isinstance(value, str):
            raise UnfitError(f"{quoted(value)} is not text")
        if not value:
            raise UnfitError("the text is empty")
        return value


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    def __str__(self) -> str:
        return "true or false"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> bool:
        if not isinstance(value, bool):
            raise UnfitError(f"{quoted(value)} is neither true nor false")
        return value


@dataclass(frozen=True)
class Choice(Kind):
    """One of a few words."""

    options: tuple[str, ...]

    def __str__(self) -> str:
        return " or ".join(map(quoted, self.options))

    def _read(self, value: Any, at: str, faults: list[Fault]) -> str:
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

    def _read(self, value: Any, at: str, faults: list[Fault]) -> float:
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
        given = [f"{word} {limit:g}" for word, limit in limits.items() if math.isfinite(limit)]
        return ", " * bool(given) + " and ".join(given)


@dataclass(frozen=True)
class Whole(Number):
    """A whole number."""

    def __str__(self) -> str:
        return f"a whole number{self._limits()}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise UnfitError(f"{quoted(value)} is not a whole number")
        super()._read(value, at, faults)
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
        Whether 0 is allowed.
    exact : bool
        Whether the value is kept as a decimal, without rounding.
    """

    name: str
    example: str
    zero: bool = False
    exact: bool = False

    def __str__(self) -> str:
        limit = "of at least 0" if self.zero else "above 0"
        return f"{self.name} {limit}, such as {quoted(self.example)}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> float | Decimal:
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

    def _read(self, value: Any, at: str, faults: list[Fault]) -> float:
        try:
            return float(exact_si(f"1 {value}", like=f"1 {self.example}"))
        except UnitError as error:
            raise UnfitError(f"{quoted(value)} is not {self.name}") from error


@dataclass(frozen=True)
class List(Kind):
    """Values of one kind, at least one of them, read as a tuple."""

    of: Kind
    length: int | None = None
    distinct: bool = False

    def __str__(self) -> str:
        return f"a list{f' of {self.length}' if self.length else ''}, each {self.of}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> tuple[Any, ...] | None:
        if not isinstance(value, list):
            raise UnfitError(f"{quoted(value)} is not a list")
        if len(value) != (self.length or max(len(value), 1)):
            count = f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
            raise UnfitError(f"{quoted(value)} has {count}")
        found = [self.of.read(item, f"{at}[{index}]", faults) for index, item in enumerate(value)]
        if self.distinct:
            first: dict[Any, int] = {}
            for index, item in enumerate(found):
                if item is not None and first.setdefault(item, index) != index:
                    problem = f"{quoted(value[index])} equals entry [{first[item]}]"
                    faults.append(Fault(f"{at}[{index}]", f"{problem}; give each value once"))
        return None if None in found else tuple(found)


@dataclass(frozen=True)
class Range(Kind):
    """Evenly spaced quantities, ``{ from = ..., to = ..., step = ... }``, read as a tuple."""

    of: Quantity

    def __str__(self) -> str:
        return f"a table with from, to, step, each {self.of}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> tuple[float, ...] | None:
        # Decimals, so that three steps of 0.1 m/s make 0.3 and not 0.30000000000000004.
        end = replace(self.of, exact=True)
        step = replace(end, zero=False)
        found = Table({"from": end, "to": end, "step": step}).read(value, at, faults)
        if found is None or None in found.values():
            return None
        steps = (found["to"] - found["from"]) / found["step"]
        if not 0 <= steps <= _MOST_STEPS or abs(steps - round(steps)) > 1e-9:
            raise UnfitError(
                f"from {quoted(value['from'])} to {quoted(value['to'])} there are {steps:.6g} "
                f"steps of {quoted(value['step'])}, not a whole number up to {_MOST_STEPS}"
            )
        return tuple(float(found["from"] + i * found["step"]) for i in range(round(steps) + 1))


@dataclass(frozen=True)
class Either(Kind):
    """`other` where `when` is true of the value, `usual` where not."""

    usual: Kind
    other: Kind
    when: Callable[[Any], bool]

    def __str__(self) -> str:
        return f"{self.usual}; or {self.other}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> Any:
        return (self.other if self.when(value) else self.usual)._read(value, at, faults)


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
        needed = [key for key, entry in self.keys.items() if not isinstance(entry, Optional)]
        return f"a table with {', '.join(needed or self.keys)}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise UnfitError(f"{quoted(value)} is not a table")
        for key in value:
            if key not in self.keys:
                hint = did_you_mean(key, self.keys)
                problem = f"unknown key{hint}; give one of {', '.join(self.keys)}"
                faults.append(Fault(_join(at, key), problem))
        found = {}
        for key, entry in self.keys.items():
            kind = entry.kind if isinstance(entry, Optional) else entry
            if key in value:
                found[key] = kind.read(value[key], _join(at, key), faults)
            else:
                found[key] = entry.default if isinstance(entry, Optional) else None
                if kind is entry:
                    faults.append(Fault(_join(at, key), f"missing; give {kind}"))
        return found


@dataclass(frozen=True)
class Tables(Kind):
    """Tables of one kind, at least one, under names of the user's choice."""

    of: Table

    def __str__(self) -> str:
        return f"at least one table under a name of your choice, each {self.of}"

    def _read(self, value: Any, at: str, faults: list[Fault]) -> dict[str, Any]:
        if not isinstance(value, dict) or not value:
            raise UnfitError(f"{quoted(value)} is not a table that holds tables")
        return {name: self.of.read(table, _join(at, name), faults) for name, table in value.items()}


def quoted(value: object) -> str:
    """Show a value on one line, about as it stands in the file."""
    if isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"[{', '.join(map(quoted, value[:4]))}{', ...' if len(value) > 4 else ''}]"
    elif isinstance(value, str):
        text = json.dumps(value, ensure_ascii=not value.isprintable())
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int) and abs(value) > 10**30:
        text = "a number above 10^30"
    else:
        text = str(value)
    return text if len(text) <= 100 else f"{text[:96]} ..."


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Ask whether the nearest known word was meant; empty if none is near.

    Examples
    --------
    >>> did_you_mean("swetp", ["local", "swept"]), did_you_mean("hurst", ["hurst_exponent"])
    (' (did you mean "swept"?)', ' (did you mean "hurst_exponent"?)')
    """
    word, known = word[:80].lower(), list(known)
    longer = [other for other in known if len(word) > 2 and other.startswith(word)]
    near = longer or difflib.get_close_matches(word, known, n=1)
    return f' (did you mean "{near[0]}"?)' if near else ""


def entry_at(found: Mapping[str, Any], path: str) -> Any:
    """Look up a path; None where it, or a table on the way to it, is missing or faulty."""
    entry: Any = found
    for key in path.split("."):
        entry = None if entry is None else entry.get(key)
    return entry


def _join(at: str, key: str) -> str:
    """Path of a key of the table `at`, as TOML writes it."""
    bare = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)
    return f"{at}.{bare}" if at else bare

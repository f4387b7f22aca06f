"""Kinds of lists and ranges in a scene file."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from pipeline.faults import Faults
from pipeline.kinds import Integer, InvalidValueError, Kind, Quantity, require
from pipeline.limits import MAX_CASES, MAX_ON_AXIS
from pipeline.messages import quoted
from pipeline.units import exact_si


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

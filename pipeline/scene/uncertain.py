"""The table ``[uncertainty]`` of a scene: standard uncertainties of entries, as in the GUM."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pipeline.scene.cases_of_tests import TestReader, attach_case, case_of, is_in
from pipeline.scene.faults import Faults, did_you_mean
from pipeline.scene.format import FROM_TESTS
from pipeline.scene.kinds import Number, Quantity, Share, UnfitError, Whole
from pipeline.scene.reference import all_keys, find_entry, number_in
from pipeline.scene.units import difference_in_si, share_of, si_unit, typeset
from pipeline.sweep.inputs import CRITICAL, RISE, Input
from pipeline.sweep.measurement import Case, Measurement
from pipeline.sweep.tables import Entries, entry_at
from tribo import InputError, Stages

_KELVIN = ("temperature.bulk", CRITICAL)
AFTER = {"friction.coefficient", *_KELVIN, RISE}
"""Entries that act after the simulation, so that no case is needed."""
_CHOICES = ("sweep", "window", "fidelity", "measured", "tested", "oil", "loading.reference_load")
"""Tables and entries that are chosen, or move nothing that is computed."""
_FACTOR = re.compile(r"\s*factor\s+([\d.]+)\s*")
_MOST = 10.0  # factor


def uncertain_inputs(
    reader: TestReader, base: Case, tests: Sequence[Measurement], faults: Faults
) -> Iterator[Input]:
    """Yield the uncertain inputs of a scene, `base`, with its `tests`; faults go to `faults`."""
    for path, text in (reader.parts.declared.uncertainty or {}).items():
        try:
            entry = numeric_entry(path, reader.entries)
            from_tests = text == FROM_TESTS and path == CRITICAL
            spread = None if from_tests else _spread(path, text)
            made = Input(path, text, entry.values[0], entry.unit, spread, path in _KELVIN)
            if path not in AFTER and spread is not None:
                value = entry.scaled(math.exp(spread))
                case = _in_window(_changed_case(reader, base, {path: value}), base)
                own = dict(_cases_of_tests(reader, base, path, value, tests))
                made = replace(made, case=case, tests=own)
            yield made
        except (UnfitError, InputError) as problem:
            faults.refuse(f'uncertainty."{path}"', str(problem))


def _cases_of_tests(
    reader: TestReader, base: Case, path: str, value: Any, tests: Sequence[Measurement]
) -> Iterator[tuple[int, Case]]:
    """Yield number and case of each test with another value; what a test states is exact for it."""
    for number, test in enumerate(tests):
        is_stated = any(is_in(own, path) for own in test.changes)
        if is_stated or (path == "loading.hold" and test.hold is not None):
            continue
        case = _changed_case(reader, base, {**test.changes, path: value})
        case = replace(case, scene=reader.staged(case.scene, test))
        case = attach_case(test, number, case).simulated
        yield number, _in_window(case, test.simulated)


def _changed_case(reader: TestReader, base: Case, changes: dict[str, Any]) -> Case:
    parts, found = reader.read_changed(changes)
    if parts is None or found:
        problem = found[0].problem if found else "it cannot be read"
        raise UnfitError(f"one standard uncertainty more is refused: {problem}")
    return case_of(parts, base)


def _in_window(case: Case, other: Case) -> Case:
    """The case in the window of another one: a wider window would have another surface."""
    if case.scene.pixels == other.scene.pixels or not isinstance(case.scene.loading, Stages):
        return case
    return replace(case, scene=replace(case.scene, pixels=other.scene.pixels))


@dataclass(frozen=True)
class NumericEntry:
    """A measured quantity in a scene: the kind of its number, and its values in SI.

    It has several values if it is a list, as one along x and one along y.
    """

    kind: Quantity | Number
    values: tuple[float, ...]
    is_list: bool

    @property
    def unit(self) -> str:
        """Unit in which the values are shown; empty without one."""
        return typeset(self.kind.unit) if isinstance(self.kind, Quantity) else ""

    def scaled(self, factor: float) -> Any:
        """The values times a factor, as a scene file has them."""
        unit = f" {si_unit(self.kind.example)}" if isinstance(self.kind, Quantity) else ""
        values = [f"{factor * one!r}{unit}" if unit else factor * one for one in self.values]
        return values if self.is_list else values[0]


def numeric_entry(path: str, entries: Entries) -> NumericEntry:
    """The quantity at a path of the complete `entries` of a scene.

    An `UnfitError` says why there is none, or why it cannot be uncertain.
    """
    kind, written = _kind_of(path), entry_at(entries, path)
    if isinstance(written, dict):  # temperature.bulk of pin and disk
        written = written["pin"]
    if written is None and path == RISE:
        written = 0.0
    if written is None:
        raise UnfitError(f"has no value; give {path}, too")
    listed = written if isinstance(written, list) else [written]
    values = tuple(float(kind.read(one, path, Faults())) for one in listed)
    if min(values) <= 0 and path != RISE:
        raise UnfitError(f"is {min(values):g}, which has no logarithm; give a value above 0")
    return NumericEntry(kind, values, isinstance(written, list))


def _kind_of(path: str) -> Quantity | Number:
    """Kind of the number at a path, which may be uncertain; an `UnfitError` says why not."""
    entry = find_entry(path)
    if entry is None:
        raise UnfitError(f"is no entry of a scene{did_you_mean(path, dict(all_keys()))}")
    kind = number_in(entry.kind)
    what = ""
    if any(is_in(path, one) for one in _CHOICES):
        what = "a choice, not a measured quantity"
    elif kind is None:
        what = "not a number"
    elif isinstance(kind, Whole):
        what = "a whole number"
    elif isinstance(kind, Share) and path not in AFTER:
        what = "a share"
    if what or kind is None:
        raise UnfitError(f'is {what}; give a measured quantity such as "pin.radius"')
    return kind


def _spread(path: str, text: str) -> float:
    """Standard uncertainty of ln(value), or of a temperature [K]."""
    if path in _KELVIN:
        also = f', or "{FROM_TESTS}"' * (path == CRITICAL)
        try:
            spread = difference_in_si(text, "1 K")
        except (InputError, ValueError):
            spread = 0.0
        if not 0 < spread <= 1000:
            raise UnfitError(f'"{text}" is no standard uncertainty; give kelvin, "8 K"{also}')
        return spread
    if (factor := _FACTOR.fullmatch(text)) and path != RISE:
        if not 1 < float(factor[1]) <= _MOST:
            raise UnfitError(f'"{text}" is out of range; give a factor above 1 and up to 10')
        return math.log(float(factor[1]))
    plain = text.strip().removeprefix("±").strip()
    share = share_of(plain) if re.fullmatch(r"[\d.]+ ?%", plain) else 0.0
    if not 0 < share <= 1:
        other = "" if path == RISE else ', or "factor 2"'
        raise UnfitError(f'"{text}" is no standard uncertainty; give "20 %"{other}')
    return share

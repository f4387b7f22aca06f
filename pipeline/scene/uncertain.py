"""The table ``[uncertainty]`` of a scene: standard uncertainties of entries, as in the GUM."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pipeline.scene.cases_of_tests import TestReader, attach_case, case_of, is_in
from pipeline.scene.faults import Faults, did_you_mean
from pipeline.scene.format import FROM_TESTS
from pipeline.scene.kinds import Kind, Quantity, Share, UnfitError, Whole
from pipeline.scene.reference import all_keys, find_entry, number_in
from pipeline.scene.units import difference_in_si, share_of, si_unit, typeset
from pipeline.sweep.case import Case
from pipeline.sweep.inputs import CRITICAL, RISE, Input
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.tables import entry_at
from pipeline.sweep.variants import Variants
from tribo import InputError

_KELVIN = ("temperature.bulk", CRITICAL)
_AFTER = {"friction.coefficient", *_KELVIN, RISE}
"""Entries that act after the simulation, so that no case is needed."""
_CHOICES = ("sweep", "window", "fidelity", "measured", "tested", "oil", "loading.reference_load")
"""Tables and entries that are chosen, or move nothing that is computed."""
_FACTOR = re.compile(r"\s*factor\s+([\d.]+)\s*")
_MOST = 10.0  # factor


@dataclass(frozen=True)
class InputReader:
    """Reads ``[uncertainty]``; `tests` reads the tests of a scene, and `base` is the scene."""

    tests: TestReader
    base: Case
    variants: Variants

    def inputs(self, tests: Sequence[Measurement], faults: Faults) -> Iterator[Input]:
        """Yield the uncertain inputs of a scene with these tests; faults are added to `faults`."""
        for path, text in (self.tests.parts.declared.uncertainty or {}).items():
            try:
                yield self._input(path, text, tests)
            except (UnfitError, InputError) as problem:
                faults.refuse(f'uncertainty."{path}"', str(problem))

    def _input(self, path: str, text: str, tests: Sequence[Measurement]) -> Input:
        kind, written = _kind_of(path), entry_at(self.tests.entries, path)
        if any(path in row.values for row in self.variants.rows):
            raise UnfitError("has several values in the sweep; leave out one of them")
        if isinstance(written, dict):  # temperature.bulk of pin and disk
            written = written["pin"]
        if written is None and path != RISE:
            begin = " from which to begin" if text == FROM_TESTS else ""
            raise UnfitError(f"has no value{begin}; give {path}, too")
        values = [
            float(kind.read(one, path, Faults())) if one is not None else 0.0
            for one in (written if isinstance(written, list) else [written])
        ]
        if min(values) <= 0 and path != RISE:
            raise UnfitError(f"is {min(values):g}, which has no logarithm; give a value above 0")
        unit = typeset(kind.unit) if isinstance(kind, Quantity) else ""
        spread = None if text == FROM_TESTS and path == CRITICAL else _spread(path, text)
        made = Input(path, text, values[0], unit, spread, is_kelvin=path in _KELVIN)
        if path in _AFTER or spread is None:
            return made
        larger = [_written(kind, value * math.exp(spread)) for value in values]
        return self._with_cases(made, larger if isinstance(written, list) else larger[0], tests)

    def _with_cases(self, made: Input, value: Any, tests: Sequence[Measurement]) -> Input:
        """The input with its cases; what a test states itself is exact for it."""
        own = {}
        for number, test in enumerate(tests):
            is_stated = any(is_in(path, made.path) for path in test.changes)
            if is_stated or (made.path == "loading.hold" and test.hold is not None):
                continue
            case = self._case({**test.changes, made.path: value})
            own[number] = attach_case(test, number, case, None).simulated
        return replace(made, case=self._case({made.path: value}), tests=own)

    def _case(self, changes: dict[str, Any]) -> Case:
        parts, found = self.tests.read_changed(json.dumps(changes))
        if parts is None or found:
            problem = found[0].problem if found else "it cannot be read"
            raise UnfitError(f"one standard uncertainty more is refused: {problem}")
        return case_of(parts, self.base)


def _kind_of(path: str) -> Kind:
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
    elif isinstance(kind, Share) and path not in _AFTER:
        what = "a share"
    if what:
        raise UnfitError(
            f'is {what}, and cannot be uncertain; give a quantity such as "pin.radius", or leave '
            "it out"
        )
    assert kind is not None
    return kind


def _spread(path: str, text: str) -> float:
    """Standard uncertainty of ln(value), or of a temperature [K]."""
    if path in _KELVIN:
        also = f', or "{FROM_TESTS}"' * (path == CRITICAL)
        try:
            spread = difference_in_si(text, "1 K")
        except InputError:
            spread = 0.0
        except ValueError:
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


def _written(kind: Kind, value: float) -> str | float:
    """A value in SI as a scene file has it."""
    return f"{value!r} {si_unit(kind.example)}" if isinstance(kind, Quantity) else value

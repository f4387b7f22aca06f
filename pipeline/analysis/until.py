"""What would change the verdict on a place: other conditions, another place, or another entry.

Conditions and places are judged exactly. An entry moves y by its derivative, which its uncertainty
or a simulation gives; the value found is then verified by a simulation there.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pipeline.analysis.judge import Judge
from pipeline.analysis.margin import verdict_between
from pipeline.analysis.tables import frame_of
from pipeline.constants import MOST_FACTOR
from pipeline.quantities import display
from pipeline.scene.kinds import UnfitError
from pipeline.scene.scenefile import run_point
from pipeline.scene.uncertain import AFTER, NumericEntry, numeric_entry
from pipeline.sweep.severity import worst_rises
from tribo import InputError, TriboError, WarningKind

_MOST_ROWS = 8
_PLACES, _HALVINGS = 16, 10
_STEP = 0.1  # of ln(value), by which an entry is changed to find its derivative
_MOST_POINTS = 3  # simulated to verify a value
_MOST_TIMES = 10.0  # of the rise over its limit, up to which a condition that changes it is sought
_COLDEST, _HOTTEST = 233.15, 773.15  # K, of bulk and critical temperatures that are sought
_FARTHEST = 3.0  # change of y up to which one is sought


@dataclass(frozen=True, slots=True)
class Change:
    """A change that gives the verdict wanted: what, from which value to which, and the basis."""

    name: str
    before: str
    after: str
    basis: str
    cost: float  # |ln(after/before)|, or the kelvin over those between critical and bulk


def changes_frame(changes: Sequence[Change]) -> pd.DataFrame:
    """Data frame of changes, with a row for each."""
    rows = [(one.name, one.before, one.after, one.basis) for one in changes]
    return frame_of(("change", "from", "to", "basis"), rows)


@dataclass(frozen=True)
class Until:
    """Seeks what makes the verdict on a place `wanted`, "mild" or "severe"."""

    judge: Judge
    load: float
    velocity: float
    wanted: str

    def judged_changes(self) -> list[Change]:
        """Changes of a condition, the load or the velocity, cheapest first; simulates nothing."""
        return sorted([*self._conditions(), *self._places()], key=lambda one: one.cost)[:_MOST_ROWS]

    def changes(self, entries: Sequence[str] = ()) -> tuple[list[Change], list[str]]:
        """Changes, cheapest first, and lines on entries that do not give the verdict.

        Entries with a simulated uncertainty are tried, and `entries` by their paths.
        """
        if self._gives(self.judge):
            return [], [f"the verdict is {self.wanted} already"]
        effects, place = self.judge.effects, (np.array([self.load]), np.array([self.velocity]))
        a = effects.at(self.judge.tested_conditions, *place)[0].tolist()
        slopes = {
            one.path: slope / (one.spread or 1.0)
            for one, slope in zip(effects.inputs, a, strict=True)
            if one.is_simulated
        }
        found = self.judged_changes()
        names, notes = [one.name for one in found], list[str]()
        if "critical temperature" not in names and self.judge.evidence.results:
            notes.append(f"no critical temperature gives {self.wanted}, as the tests move with it")
        for path in dict.fromkeys((*slopes, *entries)):
            change = self._entry(path, slopes.get(path))
            if isinstance(change, Change):
                found.append(change)
            else:
                notes.append(change)
        return sorted(found, key=lambda one: one.cost)[:_MOST_ROWS], notes

    @property
    def _is_mild(self) -> bool:
        return self.wanted == "mild"

    def _gives(
        self, judge: Judge, load: float | None = None, velocity: float | None = None
    ) -> bool:
        place = load or self.load, velocity or self.velocity
        return bool(judge.verdicts(*place)[0] == self.wanted)

    def _conditions(self) -> Iterator[Change]:
        """Yield the friction, bulk and critical temperature that give the verdict."""
        own = self.judge.conditions
        critical, bulk = own.critical_temperature or math.nan, own.coldest_bulk_temperature
        lowest = min(critical, self.judge.tested_conditions.critical_temperature or math.nan)
        least = (lowest - bulk) / _MOST_TIMES  # K between bulk and critical temperature
        friction = own.friction * (1 / _MOST_TIMES if self._is_mild else _MOST_TIMES)
        ends = {
            "friction": (own.friction, friction),
            "bulk_temperature": (bulk, _COLDEST if self._is_mild else lowest - least),
            "critical_temperature": (critical, _HOTTEST if self._is_mild else bulk + least),
        }
        for name, (begin, end) in ends.items():
            is_up = (name == "critical_temperature") == self._is_mild
            is_unequal = name == "bulk_temperature" and own.disk_temperature is not None
            if is_unequal or (end > begin) != is_up or not own.friction:
                continue
            x = _first(begin, end, functools.partial(self._gives_under, name), name != "friction")
            if x is not None:
                unit = "" if name == "friction" else "°C"
                cost = abs(x - begin) / (critical - bulk) if unit else _ratio(begin, x)
                yield _change(name.replace("_", " "), (begin, x), unit, "judged", cost)

    def _gives_under(self, name: str, value: float) -> bool:
        return self._gives(self.judge.judged_by({name: value}))

    def _places(self) -> Iterator[Change]:
        """Yield the load and the velocity of the sweep that give the verdict."""
        for name, unit in (("load", "N"), ("velocity", "m/s")):
            own, end = getattr(self, name), self.judge.rises.ends[name][not self._is_mild]
            x = _first(own, end, functools.partial(self._gives_at, name))
            if x is not None:
                yield _change(name, (own, x), unit, "judged", _ratio(own, x))

    def _gives_at(self, name: str, value: float) -> bool:
        return self._gives(self.judge, **{name: value})

    def _entry(self, path: str, slope: float | None) -> Change | str:
        """The value of an entry that gives the verdict, as simulated; or why none does."""
        try:
            entry = numeric_entry(path, self.judge.source.sweep.entries)
        except UnfitError as problem:
            raise InputError(f"--entries: {path} {problem}") from None
        if path in AFTER:
            raise InputError(f"--entries: {path} is a condition, tried in any case; leave it out")
        shift, (base, known) = self._shift, self._simulated(path, entry, 1.0)
        slope = slope or (self._simulated(path, entry, math.exp(_STEP))[0] - base) / _STEP
        way = shift / slope if shift and slope else math.inf
        for _ in range(_MOST_POINTS):
            if not abs(way) <= math.log(MOST_FACTOR):
                break
            value = _rounded(entry.values[0], entry.values[0] * math.exp(way))
            way = math.log(value / entry.values[0])
            rise, warnings = self._simulated(path, entry, math.exp(way))
            moved = rise - base
            if self._gives_with(moved):
                change = _change(
                    path, (entry.values[0], value), entry.unit, "simulated there", abs(way)
                )
                new = [words for kind, words in warnings.items() if kind not in known]
                if new:  # its numerical error is another one
                    return f"{path} {change.after} may not give {self.wanted}: {new[0]}"
                return change
            way *= 1.05 * shift / moved if moved * shift > 0 else math.inf
        return f"no change of {path} within a factor of {MOST_FACTOR:g} gives {self.wanted}"

    def _simulated(
        self, path: str, entry: NumericEntry, factor: float
    ) -> tuple[float, dict[WarningKind, str]]:
        """ln(rise) and warnings at the place, on the first surface with an entry times a factor."""
        sweep = self.judge.source.sweep._alone()
        sweep = replace(sweep, tests=(), inputs=())
        try:
            changed = sweep.changed(path, entry.scaled(factor)) if factor != 1 else sweep
            point = run_point(changed, self.load, self.velocity)
        except TriboError as error:
            raise InputError(
                f"{path} cannot be changed by a factor of {factor:.3g}: {error}"
            ) from error
        own = replace(self.judge.conditions, corrections=changed.conditions.corrections)
        rise = float(worst_rises(point.columns, np.array([self.load]), own))
        return math.log(rise), {one.kind: str(one) for one in point.warnings}

    @functools.cached_property
    def _shift(self) -> float:
        """Change of y by which the place gets the verdict; 0 if none does."""
        end = -_FARTHEST if self._is_mild else _FARTHEST
        return _first(0.0, end, self._gives_with, True) or 0.0

    def _gives_with(self, shift: float) -> bool:
        """True if y moved by `shift` gives the verdict; no test is alike another scene."""
        if self.judge.open_sides[not self._is_mild]:
            return False
        low, _, high = self.judge.chances(self.load, self.velocity, shift)
        return verdict_between(float(low[0]), float(high[0])) == self.wanted


def _first(
    begin: float, end: float, gives: Callable[[float], bool], is_linear: bool = False
) -> float | None:
    """First value from `begin` to `end` that gives the verdict; None without."""
    if begin == end:
        return None
    spaced = np.linspace if is_linear else np.geomspace
    places = spaced(begin, end, _PLACES + 1).tolist()
    # All places, as the end may be outside the model, where a film is thick.
    number = next((k for k, value in enumerate(places) if k and gives(value)), None)
    if number is None:
        return None
    low, high = places[number - 1 : number + 1]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2 if is_linear else math.sqrt(low * high)
        low, high = (low, middle) if gives(middle) else (middle, high)
    rounded = _rounded(begin, high)
    return rounded if gives(rounded) else high


def _rounded(begin: float, value: float) -> float:
    """The value, with two digits of its distance from where it begins, rounded away from there."""
    step = 10.0 ** (math.floor(math.log10(abs(value - begin))) - 1)
    steps = (value - begin) / step
    return begin + step * (math.ceil(steps - 1e-9) if steps > 0 else math.floor(steps + 1e-9))


def _change(name: str, ends: tuple[float, float], unit: str, basis: str, cost: float) -> Change:
    before, after = (display(one, unit, 4) if unit else f"{one:.4g}" for one in ends)
    return Change(name, before, after, basis, cost)


def _ratio(a: float, b: float) -> float:
    return abs(math.log(b / a))

"""The judge of one case: all that is said of a place, under one object of conditions.

y = ln(rise/limit) is computed, with its numerical error e. A further run is mild if it is severe
with a probability of at most 5 % at y + e, severe if with at least 95 % at y − e, else not decided.
No verdict stands against a test that dominates the place, or that has no result yet.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from enum import IntFlag
from typing import Any

import numpy as np

from pipeline.answers import words
from pipeline.answers.error import PARTS, rise_errors, total, velocity_errors
from pipeline.answers.field import Field, Lines, film_of
from pipeline.answers.preset_error import velocity_error
from pipeline.answers.results import CaseResults
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.answers.tests import Evidence, evidence_of, forbidden
from pipeline.answers.warnings import warning_flags
from pipeline.constants import DECIDED, FARTHEST
from pipeline.sweep.conditions import Conditions, known_critical_temperature, rise_limit
from tribo import WarningKind
from tribo.types import Array, Mask

MILD, SEVERE, NOT_DECIDED, OUTSIDE, UNKNOWN = (
    "mild",
    "severe",
    "not decided",
    "outside",
    "not known",
)
"""Verdicts on a further run."""


class Caveat(IntFlag):
    """What limits the answer on one place."""

    INTERPOLATED = 1
    EXTRAPOLATED = 2  # beyond the computed velocities
    RAMP_PASSES_SEVERE = 4  # wear is severe at lower loads, through which a ramp passes
    AT_EDGE = 8  # the contact touches the window's edge at the points around
    FILM_NOT_KNOWN = 16
    TESTS_FORBID = 32  # a test dominates the place, or has no result yet


class JudgedCase:
    """Specimens, films and evidence of one case, each made once for what it depends on."""

    def __init__(self, case: CaseResults) -> None:
        self.case, self.promised = case, velocity_error(case.sweep)
        self._flags = warning_flags(case)
        self._held = dict[Any, Any]()

    def _once(self, key: Any, make: Any) -> Any:
        if key not in self._held:
            self._held[key] = make()
        return self._held[key]

    def under(self, conditions: Conditions) -> Judge:
        """The judge under `conditions`."""
        known_critical_temperature(conditions)
        c = conditions
        specimen = self._once(
            ("specimen", c.critical_area_fraction, c.corrections),
            lambda: specimen_of(self.case, c, self._flags),
        )
        oil = (c.critical_temperature, c.unmodelled_rise, c.critical_area_fraction)
        evidence = self._once(
            ("evidence", *oil, c.corrections),
            lambda: evidence_of(self.case, specimen, c),
        )
        film = self._once(
            ("film", c.bulk_temperature), lambda: film_of(self.case, c.bulk_temperature)
        )
        return Judge(self.case, c, specimen, evidence, film, self.promised)


@dataclass(frozen=True, eq=False)
class Judge:
    """What is said of places of one case, under its conditions."""

    case: CaseResults
    conditions: Conditions
    specimen: Specimen
    evidence: Evidence
    film: Field | None  # None if no film is to be judged
    promised: float | None  # relative error of critical velocities due to the preset

    @property
    def field(self) -> Field:
        """ln(rise)."""
        return self.specimen.field

    @functools.cached_property
    def limit(self) -> float:
        """ln(limit of the rise)."""
        limit = rise_limit(self.conditions)
        return math.log(limit) if limit > 0 else -math.inf

    @functools.cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest load [N] and velocity [m/s] of the sweep, without 0."""
        found = {}
        for axis in ("load", "velocity"):
            here = getattr(self.case, f"{'loads' if axis == 'load' else 'velocities'}")
            scene = self.case.sweep.loads if axis == "load" else self.case.sweep.velocities
            values = [*here.tolist(), *(value for value in scene if value > 0)]
            found[axis] = min(values), max(values)
        return found

    def errors(self, loads: Array, velocities: Array) -> Array:
        """Relative errors of the rise by part (4, k)."""
        return rise_errors(self.specimen, self.promised, loads, velocities)

    def films(self, loads: Array, velocities: Array) -> tuple[Mask, Mask]:
        """Where a film carries more of the load than the model allows, and where none is known."""
        if self.film is None:
            return np.zeros(loads.shape, bool), np.zeros(loads.shape, bool)
        found = self.film(loads, velocities)
        return np.nan_to_num(found, nan=-1.0) > 0, np.isnan(found)

    def places(self, loads: Array, velocities: Array) -> dict[str, Any]:
        """Answers on k places by name, each (k,); without lines through them."""
        moving = np.where(velocities > 0, velocities, np.nan)
        rise, posterior = self.field(loads, moving), self.evidence.posterior
        reason = self._reasons(loads, velocities, rise)
        known = np.array([not one for one in reason], bool)
        y = np.where(known, rise - self.limit, np.nan)
        parts = np.where(known, self.errors(loads, moving), np.nan)
        width = total(parts)
        ends = np.where(np.isfinite(width), np.log1p(width), 0.0)
        low, middle, high = (posterior.probability(one) for one in (y - ends, y, y + ends))
        low = np.where(np.isnan(width) & known, 0.0, low)
        high = np.where(np.isnan(width) & known, 1.0, high)
        outside, no_film = self.films(loads, moving)
        told = forbidden(self.case, self.evidence, self.conditions, loads, velocities)
        open_mild, open_severe = self.evidence.open_sides
        kinds = ~known, outside, high <= DECIDED[0], low >= DECIDED[-1]
        verdict = np.select(kinds, (UNKNOWN, OUTSIDE, MILD, SEVERE), NOT_DECIDED)
        no_mild, no_severe = told.mild | open_mild, told.severe | open_severe
        against = ((verdict == MILD) & no_mild) | ((verdict == SEVERE) & no_severe)
        waiting = words.waiting(self.evidence)
        for k in np.flatnonzero(against).tolist():
            is_open = open_mild if verdict[k] == MILD else open_severe
            reason[k] = waiting if is_open else f"{told.names[k]} forbids it"
        verdict = np.where(against, NOT_DECIDED, verdict)
        conditions = self.conditions
        with np.errstate(invalid="ignore"):
            temperature = conditions.contact_temperature(np.exp(np.where(known, rise, np.nan)))
            heat = temperature - conditions.bulk_temperature
        computed = known & self.field.is_point(loads, velocities)
        continued = known & ~computed & self.field.is_continued(loads, moving)
        edge = (self.specimen.flags & int(WarningKind.CONTACT_AT_EDGE)) != 0
        caveats = (
            (known & ~computed & ~continued) * Caveat.INTERPOLATED
            + continued * Caveat.EXTRAPOLATED
            + (known & (self.field.bilinear(edge.astype(float), loads, moving) > 0))
            * Caveat.AT_EDGE
            + (known & no_film) * Caveat.FILM_NOT_KNOWN
            + against * Caveat.TESTS_FORBID
        )
        gone = outside | ~known
        answers = {
            "verdict": verdict.astype(object),
            "probability": np.where(gone, np.nan, middle),
            "probability_low": np.where(gone, np.nan, low),
            "probability_high": np.where(gone, np.nan, high),
            "log_severity": y,
            "temperature": temperature,
            "temperature_error": heat * width,
            "distance": known_critical_temperature(conditions) - temperature,
        }
        answers |= {f"error_{part}": heat * one for part, one in zip(PARTS, parts, strict=True)}
        above = known_critical_temperature(conditions) - conditions.bulk_temperature
        friction = above / (1 + conditions.unmodelled_rise) / np.exp(np.where(known, rise, np.nan))
        return answers | {"critical_friction": friction, "caveats": caveats, "reason": reason}

    def _reasons(self, loads: Array, velocities: Array, rise: Array) -> Any:
        """Why nothing is known of a place; empty if it is."""
        found = np.full(loads.shape, "", object)
        for name, values in (("load", loads), ("velocity", velocities)):
            low, high = self.ranges[name]
            if name == "velocity" and self.case.from_rest:
                low = 0.0
            for k in np.flatnonzero(~((low <= values) & (values <= high) & (values > 0))).tolist():
                found[k] = words.beyond(name, values[k], low, high)
        missing = np.isnan(rise) & (found == "")
        found[missing] = "too few points about it are done: run the sweep to its end"
        return found

    def critical(self, axis: str, places: Array) -> dict[str, Any]:
        """Where wear turns severe along `axis`, through k `places` on the other one."""
        each, back = np.unique(places, return_inverse=True)
        levels = np.full(each.shape, self.limit)
        if axis == "velocity":
            lines = self.field.along_velocity(each, levels)
        else:
            lines = self.field.along_load(each, levels)
        found, outside = self._inside(axis, each, lines)
        turns_back = axis == "velocity" and self.conditions.has_friction_curve
        codes = lines.outcomes(self.ranges[axis], turns_back)
        texts = words.outcomes(lines, codes, axis, outside)
        if len(self.field.velocities if axis == "velocity" else self.field.loads) == 1:
            texts[:] = ""  # there is no line
        whole = {
            f"critical_{axis}": found, "outcome": codes, "outcome_words": texts,
            "turns": lines.places, "begins_severe": lines.begins_severe,
        }  # fmt: skip
        return {name: one[back] for name, one in whole.items()}

    def _inside(self, axis: str, places: Array, lines: Lines) -> tuple[Array, Mask]:
        """Critical values, NaN where a film carries too much; and which lines are outside."""

        def outside(at: Array) -> Mask:
            known, found = np.isfinite(at), np.zeros(at.shape, bool)
            pair = (places, at) if axis == "velocity" else (at, places)
            found[known] = self.films(*(one[known] for one in pair))[0]
            return found

        critical = lines.critical
        gone = outside(critical)
        ends = outside(lines.low) & outside(lines.high)
        return np.where(gone, np.nan, critical), gone | (np.isnan(critical) & ends)

    def tested_velocity(self, loads: Array, share: float = 0.5) -> Array:
        """Velocities (k,) at which a further run is severe with a probability of `share` [m/s].

        It is the first such velocity, for a share above a half the last. NaN where there is none up
        to 3 times beyond the computed velocities, or where a film carries too much.
        """
        each, back = np.unique(loads, return_inverse=True)
        level = self.limit + self.evidence.posterior.level(share)
        lines = self.field.along_velocity(each, np.full(each.shape, level), FARTHEST)
        last = np.where(lines.ends_severe, np.fmax.reduce(lines.places, axis=1), np.nan)
        at = last if share > 0.5 else lines.critical
        known = np.isfinite(at)
        known[known] = ~self.films(each[known], at[known])[0]
        return np.where(known, at, np.nan)[back]

    def velocity_errors(self, loads: Array, velocities: Array) -> Array:
        """Relative errors of critical velocities by part (4, k)."""
        parts = self.errors(loads, velocities)
        return velocity_errors(self.field, parts, self.promised, loads, velocities)

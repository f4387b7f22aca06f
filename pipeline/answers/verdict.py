"""The judge of one case: all that is stated of operating points, under their conditions.

y = ln(rise ratio) is computed, with its numerical error e. The next specimen is mild if severe wear
has a probability of at most 5 % at y + e, severe if at least 95 % at y − e, else undecided. No
verdict stands against a test that rules it out, or that has no result yet.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntFlag
from typing import Any

import numpy as np

from pipeline.answers import words
from pipeline.answers.conditions import Operation, by_bulk, judged
from pipeline.answers.critical_temperature import critical_temperature_of
from pipeline.answers.discretization_error import velocity_error
from pipeline.answers.error import PARTS, rise_errors, total, velocity_errors
from pipeline.answers.field import Field, Lines, Outcome, film_of
from pipeline.answers.results import CaseResults
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.answers.tests import Evidence, evidence_of, ruled_out
from pipeline.constants import DECIDED, FARTHEST
from pipeline.sweep.conditions import Conditions, known_critical_temperature
from tribo import WarningKind
from tribo.types import Array, Mask

MILD, UNDECIDED, SEVERE, OUTSIDE, UNKNOWN = range(5)
"""Codes of verdicts on the next specimen."""
VERDICTS = "mild", "undecided", "severe", "outside_model", "unknown"
"""Names of these codes."""
SIMULATED, INTERPOLATED, EXTRAPOLATED = range(3)
ORIGINS = "simulated", "interpolated", "extrapolated"


class Flag(IntFlag):
    """What limits the answer on one operating point."""

    RAMP_PASSES_SEVERE = 1  # wear is severe at lower loads, through which a ramp passes
    CONTACT_AT_EDGE = 2  # the contact reaches the edge of the window at the points around
    FILM_UNKNOWN = 4
    RULED_OUT = 8  # a test rules the verdict out, or one without a result may


class JudgedCase:
    """Specimens, films and evidence of one case, each made once for what it depends on."""

    def __init__(self, case: CaseResults) -> None:
        self.case, self.promised = case, velocity_error(case.sweep)
        self._held = dict[Any, Any]()

    def _once(self, key: Any, make: Any) -> Any:
        if key not in self._held:
            self._held[key] = make()
        return self._held[key]

    def under(self, conditions: Conditions) -> VerdictModel:
        """The judge under `conditions`, of which points may have another friction and bulk."""
        c, from_tests = conditions, self.case.sweep.base.critical_from_tests
        if not from_tests:
            known_critical_temperature(c)
        specimen = self._once(
            ("specimen", c.critical_area_fraction, c.corrections),
            lambda: specimen_of(self.case, c),
        )
        if c.critical_temperature is None:
            others = "from tests", c.added_rise_fraction, c.critical_area_fraction, c.corrections
            found = self._once(others, lambda: critical_temperature_of(self.case, specimen, c))
            c = replace(c, critical_temperature=found.temperature)
            return VerdictModel(self, c, specimen, replace(found.evidence, critical=found))
        oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
        evidence = self._once(
            ("evidence", *oil, c.corrections), lambda: evidence_of(self.case, specimen, c)
        )
        return VerdictModel(self, c, specimen, evidence)

    def film_excess(self, at: Operation) -> Array | None:
        """Ln of the film's pressure over that which carries a fifth of the load (k,); NaN unknown.

        None if no film is to be judged.
        """
        if not at.load.size:
            return np.zeros(0)
        if self._film(self.case.conditions.bulk_temperature) is None:
            return None

        def excess(bulk: float, here: Mask) -> Array:
            return np.asarray(self._film(bulk)(at.load[here], at.velocity[here]))

        return by_bulk(at.bulk_temperature, excess)

    def _film(self, bulk: float) -> Any:
        return self._once(("film", bulk), lambda: film_of(self.case, bulk))


def conditions_of(case: CaseResults, given: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, some replaced, with a number for a critical temperature from tests."""
    own = judged(case.conditions, given)
    is_open = own.critical_temperature is None and case.sweep.base.critical_from_tests
    return JudgedCase(case).under(own).conditions if is_open else own


@dataclass(frozen=True, eq=False)
class VerdictModel:
    """What is stated of operating points of one case, under its conditions."""

    judged_case: JudgedCase
    conditions: Conditions
    specimen: Specimen
    evidence: Evidence

    @property
    def case(self) -> CaseResults:
        """The results."""
        return self.judged_case.case

    @property
    def promised(self) -> float | None:
        """Relative error of critical velocities due to the preset; None if unknown."""
        return self.judged_case.promised

    @property
    def field(self) -> Field:
        """ln(rise)."""
        return self.specimen.field

    @functools.cached_property
    def limit(self) -> float:
        """ln(allowable rise) at the friction and bulk temperature of the conditions."""
        one = np.ones(1)
        return float(self.limits(Operation.under(self.conditions, one, one))[0])

    def limits(self, at: Operation) -> Array:
        """ln(allowable rise) of points (k,)."""
        critical = known_critical_temperature(self.conditions)
        heating = at.friction * (1 + self.conditions.added_rise_fraction)
        with np.errstate(divide="ignore"):
            return np.asarray(np.log((critical - at.bulk_temperature) / heating))

    @functools.cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest load [N] and velocity [m/s] of the sweep, without 0."""
        case, sweep = self.case, self.case.sweep
        axes = {"load": (case.loads, sweep.loads), "velocity": (case.velocities, sweep.velocities)}
        values = {
            k: [*here.tolist(), *(x for x in all if x > 0)] for k, (here, all) in axes.items()
        }
        return {name: (min(one), max(one)) for name, one in values.items()}

    @property
    def lacks_film(self) -> bool:
        """True if a film is to be judged, but unknown at a point that is done."""
        field = self.field
        plane = np.meshgrid(field.loads, field.velocities, indexing="ij")
        at = Operation.under(self.conditions, *(one.ravel() for one in plane))
        return bool((self.films(at)[1] & field.is_known.ravel()).any())

    def films(self, at: Operation) -> tuple[Mask, Mask]:
        """Where a film carries more of the load than the model allows, and where it is unknown."""
        found = self.judged_case.film_excess(at)
        if found is None:
            return np.zeros(at.load.shape, bool), np.zeros(at.load.shape, bool)
        return np.nan_to_num(found, nan=-1.0) > 0, np.isnan(found)

    def points(self, at: Operation) -> dict[str, Any]:
        """Answers on points by name, each (k,); without lines through them."""
        within = (at.load > 0) & (at.velocity > 0) & np.isfinite(at.load) & np.isfinite(at.velocity)
        load, velocity = np.where(within, at.load, np.nan), np.where(within, at.velocity, np.nan)
        rise = self.field(load, velocity)
        reason = self._reasons(at, rise)
        known = np.array([not one for one in reason], bool)
        rise = np.where(known, rise, np.nan)
        y = rise - self.limits(at)
        parts = np.where(known, rise_errors(self.specimen, self.promised, load, velocity), np.nan)
        width = total(parts)
        ends = np.where(np.isfinite(width), np.log1p(width), 0.0)
        low, middle, high = self.evidence.probabilities(
            (y - ends, y, y + ends), at.bulk_temperature
        )
        low = np.where(np.isnan(width) & known, 0.0, low)
        high = np.where(np.isnan(width) & known, 1.0, high)
        outside, no_film = self.films(at._replace(load=load, velocity=velocity))
        verdict = np.select(
            (~known, outside, high <= DECIDED[0], low >= DECIDED[-1]),
            (UNKNOWN, OUTSIDE, MILD, SEVERE),
            UNDECIDED,
        )
        against = self._withhold(verdict, reason, at)
        verdict = np.where(against, UNDECIDED, verdict).astype(np.int8)
        heating = (1 + self.conditions.added_rise_fraction) * np.exp(rise)
        critical = known_critical_temperature(self.conditions)
        simulated = known & self.field.is_point(at.load, at.velocity)
        beyond = known & ~simulated & self.field.is_extrapolated(load, velocity)
        edge = (self.specimen.flags & int(WarningKind.CONTACT_AT_EDGE)) != 0
        edge = known & (self.field.bilinear(edge.astype(float), load, velocity) > 0)
        flags = edge * Flag.CONTACT_AT_EDGE + (known & no_film) * Flag.FILM_UNKNOWN
        gone = outside | ~known
        heat = at.friction * heating
        return {
            "verdict": verdict,
            "probability": np.where(gone, np.nan, middle),
            "probability_low": np.where(gone, np.nan, low),
            "probability_high": np.where(gone, np.nan, high),
            "log_rise_ratio": y,
            "governing_temperature": at.bulk_temperature + heat,
            "temperature_margin": critical - (at.bulk_temperature + heat),
            "temperature_error": heat * width,
            **{
                f"temperature_error_{part}": heat * one
                for part, one in zip(PARTS, parts, strict=True)
            },
            "critical_friction": (critical - at.bulk_temperature) / heating,
            "origin": np.select(
                (~known, simulated, beyond), (-1, SIMULATED, EXTRAPOLATED), INTERPOLATED
            ).astype(np.int8),
            "warning_flags": (flags + against * Flag.RULED_OUT).astype(np.int16),
            "reason": reason,
        }

    def _withhold(self, verdict: Array, reason: Any, at: Operation) -> Mask:
        """Points at which tests do not allow the verdict; `reason` gets why, in words."""
        rulings = ruled_out(self.case, self.evidence, self.conditions, at)
        open_mild, open_severe = self.evidence.withheld
        no_mild, no_severe = rulings.mild | bool(open_mild), rulings.severe | bool(open_severe)
        against = ((verdict == MILD) & no_mild) | ((verdict == SEVERE) & no_severe)
        for k in np.flatnonzero(against).tolist():
            why = open_mild if verdict[k] == MILD else open_severe
            reason[k] = why or f"{rulings.names[k]} rules it out"
        return np.asarray(against)

    def _reasons(self, at: Operation, rise: Array) -> Any:
        """Why nothing is known of a point; empty if it is."""
        found, ends = np.full(at.load.shape, "", object), self.ranges
        values = np.stack([at.load, at.velocity])
        low, high = np.transpose([ends["load"], ends["velocity"]])[..., None]
        inside = ((low <= values) & (values <= high) & (values > 0)).all(axis=0)
        for k in np.flatnonzero(~inside).tolist():
            load, velocity = values[:, k].tolist()
            found[k] = words.outside(ends, load=load, velocity=velocity)
        found[np.isnan(rise) & (found == "")] = words.TOO_FEW
        return found

    def critical(self, axis: str, at: Operation) -> dict[str, Any]:
        """Where wear becomes severe along `axis`, through points on the other one."""
        through = at.load if axis == "velocity" else at.velocity
        levels = self.limits(at)
        pairs = np.stack([through, levels, at.bulk_temperature])
        _, first, back = np.unique(pairs, axis=1, return_index=True, return_inverse=True)
        at, through, levels = at.take(first), through[first], levels[first]
        find = self.field.along_velocity if axis == "velocity" else self.field.along_load
        lines = find(through, levels)
        found, outside = self._inside(axis, at, lines)
        turns_back = axis == "velocity" and self.conditions.has_friction_curve
        codes = lines.outcomes(self.ranges[axis], turns_back)
        codes = np.where(outside, Outcome.OUTSIDE_MODEL, codes).astype(np.int8)
        if len(self.field.velocities if axis == "velocity" else self.field.loads) == 1:
            codes[:] = Outcome.NO_LINE
        whole = {
            f"critical_{axis}": found, f"outcome_along_{axis}": codes,
            "crossings": lines.places, "severe_at_start": lines.severe_at_start,
        }  # fmt: skip
        return {name: one[back.ravel()] for name, one in whole.items()}

    def _inside(self, axis: str, at: Operation, lines: Lines) -> tuple[Array, Mask]:
        """Critical values, NaN where a film carries too much; and which lines are outside."""

        def outside(values: Array) -> Mask:
            known, found = np.isfinite(values), np.zeros(values.shape, bool)
            found[known] = self.films(at._replace(**{axis: values}).take(known))[0]
            return found

        gone = outside(lines.critical)
        ends = outside(lines.low) & outside(lines.high)
        return (
            np.where(gone, np.nan, lines.critical), gone | (np.isnan(lines.critical) & ends),
        )  # fmt: skip

    def velocity_of_probability(self, at: Operation, probability: float = 0.5) -> Array:
        """Velocities (k,) at which severe wear has this probability, at the loads of points [m/s].

        It is the first such velocity, for a probability above a half the last. NaN where there is
        none among the velocities of the sweep, or where a film carries too much.
        """
        levels = self.limits(at) + self.evidence.log_rise_ratio_quantiles(
            probability, at.bulk_temperature
        )
        lines = self.field.along_velocity(at.load, levels, FARTHEST)
        last = np.where(lines.ends_severe, np.fmax.reduce(lines.places, axis=1), np.nan)
        found = last if probability > 0.5 else lines.critical
        low, high = self.ranges["velocity"]
        with np.errstate(invalid="ignore"):
            known = np.isfinite(found) & (low <= found) & (found <= high)
        known[known] = ~self.films(at._replace(velocity=found).take(known))[0]
        return np.where(known, found, np.nan)

    def velocity_errors(self, loads: Array, velocities: Array) -> Array:
        """Relative errors of critical velocities by part (4, k)."""
        parts = rise_errors(self.specimen, self.promised, loads, velocities)
        return velocity_errors(self.field, parts, self.promised, loads, velocities)

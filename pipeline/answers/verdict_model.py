"""Verdicts of one case: all answers on operating points, under given conditions.

y = ln(rise ratio) is computed, with its numerical error e. The next specimen is mild if severe wear
has a probability of at most 5 % at y + e, severe if at least 95 % at y − e, else undecided. No
verdict stands against a test that rules it out, or that has no result yet.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntFlag
from typing import Any, NamedTuple

import numpy as np

from pipeline.answers.case_results import CaseResults, outside_reason
from pipeline.answers.condition_values import QueryPoints, oil_of, override_conditions
from pipeline.answers.critical_temperature import evidence_with_critical_temperature
from pipeline.answers.error import (
    PARTS,
    preset_error_of,
    rise_errors,
    total,
    velocity_errors,
)
from pipeline.answers.evidence import Evidence, evidence_of
from pipeline.answers.field import Field, LineOutcome, film_field
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.constants import MAX_EXTRAPOLATION, VERDICT_PROBABILITIES
from pipeline.quantities import display
from pipeline.sweep.case import Conditions, known_critical_temperature
from pipeline.sweep.sweep import Sweep
from tribo import WarningKind
from tribo.thermal.quantiles import rise_exceeded
from tribo.types import Array, Indices, Mask

MILD, UNDECIDED, SEVERE, OUTSIDE, UNKNOWN = range(5)
"""Codes of verdicts on the next specimen."""
VERDICTS = "mild", "undecided", "severe", "outside_model", "unknown"
"""Names of these codes."""
ORIGINS = "simulated", "interpolated", "extrapolated"
_OTHER_OIL = "the tests are left out: they hold for the critical temperature of the scene, {}"
_INFERRED = (
    "the tests are left out: the scene infers its critical temperature from them, and another one "
    "is given"
)
_TOO_FEW = "too few points nearby are done; finish the run, or add points there"


class Flag(IntFlag):
    """Limitations of the answer on an operating point."""

    CONTACT_AT_EDGE = 1  # the contact reaches the edge of the window at neighbouring points
    FILM_UNKNOWN = 2
    RULED_OUT = 4  # a test rules the verdict out, or one without a result may


def verdict_model(case: CaseResults, conditions: Conditions) -> VerdictModel:
    """Verdict model of a case; points may replace friction and bulk temperature of `conditions`.

    A critical temperature that is missing in `conditions` is inferred from the tests, if the scene
    says so. The tests hold for the oil of the scene, and are left out under another one.
    """
    is_from_tests = conditions.critical_temperature is None
    if is_from_tests and not case.sweep.base.critical_from_tests:
        known_critical_temperature(conditions)  # raises
    rise_key = conditions.critical_area_fraction, conditions.corrections
    specimen = case.cached(("specimen", rise_key), lambda: specimen_of(case, conditions))
    infer = evidence_with_critical_temperature if is_from_tests else evidence_of
    tested = case.without_tests if omission_of_tests(case.sweep, conditions) else case
    evidence = case.cached(
        ("evidence", oil_of(conditions)), lambda: infer(tested, specimen, conditions)
    )
    if is_from_tests:
        conditions = replace(conditions, critical_temperature=evidence.critical.temperature)
    return VerdictModel(case, conditions, specimen, evidence)


def omission_of_tests(sweep: Sweep, conditions: Conditions) -> str:
    """Reason why the tests of a sweep do not count under `conditions`; empty if they count.

    They count at the critical temperature of the scene, which is that of their oil.
    """
    of_scene, critical = sweep.conditions.critical_temperature, conditions.critical_temperature
    if critical is None:
        return ""
    if of_scene is None:
        return _INFERRED if sweep.base.critical_from_tests else ""
    is_of_scene = math.isclose(of_scene, critical, rel_tol=1e-9)
    return "" if is_of_scene else _OTHER_OIL.format(display(of_scene, "°C"))


def conditions_of(case: CaseResults, overrides: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, some replaced, with a number for a critical temperature from tests."""
    conditions = override_conditions(case.conditions, overrides)
    if conditions.critical_temperature is None and case.sweep.base.critical_from_tests:
        return verdict_model(case, conditions).conditions
    return conditions


class Rises(NamedTuple):
    """Temperature rises at operating points (k,) at friction 1; NaN for invalid values."""

    load: Array
    velocity: Array
    log_rise: Array  # NaN if unknown
    errors: Array  # relative, by part (5, k)
    is_outside: Mask  # the film carries more load than the model allows
    is_film_unknown: Mask

    def take(self, index: Any) -> Rises:
        """Points selected by `index`, which may be a mask."""
        columns: Any = (column[..., index] for column in self)
        return Rises(*columns)


class Judgement(NamedTuple):
    """Verdicts on operating points (k,)."""

    verdict: Indices
    ruled_out: Indices  # code of the verdict that tests rule out or withhold; else −1
    probabilities: Array  # (3, k): lower bound, value, upper bound
    log_ratio: Array
    error: Array


@dataclass(frozen=True, eq=False)
class VerdictModel:
    """Answers on operating points of a case, under the conditions of one oil."""

    case: CaseResults
    conditions: Conditions
    specimen: Specimen
    evidence: Evidence

    @property
    def omitted_tests(self) -> str:
        """Reason why the tests of the scene are left out, as text; empty if they count."""
        if not self.case.sweep.tests or self.evidence.rows:
            return ""
        return omission_of_tests(self.case.sweep, self.conditions)

    @functools.cached_property
    def preset_error(self) -> float | None:
        """Relative error of critical velocities due to the preset; None if unknown."""
        return preset_error_of(self.case.sweep)

    @property
    def field(self) -> Field:
        """ln(rise)."""
        return self.specimen.field

    @functools.cached_property
    def limit(self) -> float:
        """ln(allowable rise) at the friction and bulk temperature of the conditions."""
        unit = np.ones(1)
        return float(self.limits(QueryPoints.under(self.conditions, unit, unit))[0])

    def limits(self, points: QueryPoints) -> Array:
        """ln(allowable rise) of points (k,)."""
        critical = known_critical_temperature(self.conditions)
        rise_factor = points.friction * self.conditions.outside_factor
        with np.errstate(divide="ignore"):
            return np.asarray(np.log((critical - points.bulk_temperature) / rise_factor))

    @functools.cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest load [N] and velocity [m/s] of the case, without 0."""
        case, sweep = self.case, self.case.sweep
        axes = {"load": (case.loads, sweep.loads), "velocity": (case.velocities, sweep.velocities)}
        values = {
            k: [*computed.tolist(), *(x for x in swept if x > 0 and not case.is_row)]
            for k, (computed, swept) in axes.items()
        }
        return {name: (min(axis_values), max(axis_values)) for name, axis_values in values.items()}

    @property
    def lacks_film(self) -> bool:
        """True if the case has a film that is unknown at a computed point."""
        field = self.field
        plane = np.meshgrid(field.loads, field.velocities, indexing="ij")
        points = QueryPoints.under(self.conditions, *(axis.ravel() for axis in plane))
        return bool((self.films(points)[1] & field.is_known.ravel()).any())

    def films(self, points: QueryPoints) -> tuple[Mask, Mask]:
        """Masks (k,): the film carries more load than the model allows; the film is unknown."""
        excess = np.full(points.load.shape, -1.0)  # ln(pressure over that of a fifth of the load)
        for bulk in np.unique(points.bulk_temperature).tolist():
            is_member = points.bulk_temperature == bulk
            film = self.case.cached(("film", bulk), functools.partial(film_field, self.case, bulk))
            if film is not None:
                excess[is_member] = film(points.load[is_member], points.velocity[is_member])
        return np.nan_to_num(excess, nan=-1.0) > 0, np.isnan(excess)

    def rises(self, points: QueryPoints) -> Rises:
        """Temperature rises at points (k,), at friction 1."""
        plane = np.stack([points.load, points.velocity])
        low, high = np.transpose([self.ranges["load"], self.ranges["velocity"]])[..., None]
        is_inside = ((low <= plane) & (plane <= high) & (plane > 0)).all(axis=0)
        is_valid = (np.isfinite(plane) & (plane > 0)).all(axis=0)
        load, velocity = np.where(is_valid, plane, np.nan)
        field_points = self.field.at(load, velocity)
        log_rise = field_points.values
        errors = rise_errors(self.specimen, self.preset_error, field_points)
        is_outside, is_film_unknown = self.films(points._replace(load=load, velocity=velocity))
        return Rises(
            load, velocity, np.where(is_inside, log_rise, np.nan),
            np.where(is_inside & ~np.isnan(log_rise), errors, np.nan), is_outside, is_film_unknown,
        )  # fmt: skip

    def judge(self, points: QueryPoints, rises: Rises) -> Judgement:
        """Verdicts on points (k,), which have these `rises`."""
        log_ratio = rises.log_rise - self.limits(points)
        error = total(rises.errors)
        log_error, bulks = np.log1p(np.nan_to_num(error)), points.bulk_temperature
        ratios = log_ratio - log_error, log_ratio, log_ratio + log_error
        probabilities = np.stack([self.evidence.probability(y, bulks) for y in ratios])
        # Where the error is unknown, the bounds are 0 and 1.
        probabilities[0, np.isnan(error)], probabilities[2, np.isnan(error)] = 0.0, 1.0
        verdict = np.select(
            (
                np.isnan(rises.log_rise),
                rises.is_outside,
                probabilities[2] <= VERDICT_PROBABILITIES[0],
                probabilities[0] >= VERDICT_PROBABILITIES[-1],
            ),
            (UNKNOWN, OUTSIDE, MILD, SEVERE),
            UNDECIDED,
        )
        ruled_out = np.full(verdict.shape, -1)
        for code in (MILD, SEVERE):
            judged = np.flatnonzero(verdict == code)
            is_ruled_out = self.evidence.rules_out(VERDICTS[code], points.take(judged))
            ruled_out[judged[is_ruled_out]] = code
        verdict = np.where(ruled_out >= 0, UNDECIDED, verdict)
        return Judgement(verdict, ruled_out, probabilities, log_ratio, error)

    def verdicts(self, points: QueryPoints) -> Indices:
        """Codes of the verdicts on points (k,)."""
        return self.judge(points, self.rises(points)).verdict

    def points(self, points: QueryPoints) -> dict[str, Any]:
        """Answers on points by name, each (k,), except those along lines through them."""
        rises = self.rises(points)
        load, velocity, log_rise, errors, is_outside, is_film_unknown = rises
        verdict, ruled_out, probabilities, log_ratio, error = self.judge(points, rises)
        is_known = ~np.isnan(log_rise)
        reasons = np.full(is_known.shape, "", object)
        for k in np.flatnonzero(~is_known).tolist():
            point = {"load": float(points.load[k]), "velocity": float(points.velocity[k])}
            reasons[k] = outside_reason(self.case, self.ranges, **point) or _TOO_FEW
        for code in (MILD, SEVERE):
            is_ruled_out = ruled_out == code
            objections = self.evidence.objections(VERDICTS[code], points.take(is_ruled_out))
            reasons[is_ruled_out] = objections
        warned = ((self.specimen.flags & int(WarningKind.CONTACT_AT_EDGE)) != 0).astype(float)
        field_points = self.field.at(load, velocity)
        is_at_edge = field_points.bilinear(warned) > 0
        flags = is_at_edge * int(Flag.CONTACT_AT_EDGE) + is_film_unknown * int(Flag.FILM_UNKNOWN)
        has_no_verdict = is_outside | ~is_known
        low, probability, high = np.where(has_no_verdict, np.nan, probabilities)
        rise_per_friction = self.conditions.outside_factor * np.exp(log_rise)
        temperature_rise = points.friction * rise_per_friction
        temperature = points.bulk_temperature + temperature_rise
        critical = known_critical_temperature(self.conditions)
        # As in `ORIGINS`: simulated, interpolated, extrapolated.
        origins = np.select((field_points.is_known, field_points.is_extrapolated), (0, 2), 1)
        parts = {
            f"temperature_error_{part}": temperature_rise * part_error
            for part, part_error in zip(PARTS, errors, strict=True)
        }
        return {
            "verdict": verdict.astype(np.int8),
            "probability": probability,
            "probability_low": low,
            "probability_high": high,
            "log_rise_ratio": log_ratio,
            "governing_temperature": temperature,
            "temperature_margin": critical - temperature,
            "temperature_error": temperature_rise * error,
            **parts,
            "critical_friction": (critical - points.bulk_temperature) / rise_per_friction,
            "origin": np.where(is_known, origins, -1).astype(np.int8),
            "warning_flags": (is_known * flags + (ruled_out >= 0) * Flag.RULED_OUT).astype(
                np.int16
            ),
            "reason": reasons,
        }

    def critical(self, axis: str, points: QueryPoints) -> dict[str, Any]:
        """Critical values along `axis`, on lines through the points' values on the other axis.

        A value is NaN where a film carries too much load.
        """
        line_values = points.load if axis == "velocity" else points.velocity
        levels = self.limits(points)
        first, inverse = _distinct(line_values, levels, points.bulk_temperature)
        points, line_values, levels = points.take(first), line_values[first], levels[first]
        if axis == "velocity":
            lines, nodes = self.field.along_velocity(line_values, levels), self.field.velocities
        else:
            lines, nodes = self.field.along_load(line_values, levels), self.field.loads
        is_outside, is_low_outside, is_high_outside = (
            self.films(points._replace(**{axis: values}))[0]
            for values in (lines.critical, lines.low, lines.high)
        )
        has_no_crossing = np.isnan(lines.critical)
        is_line_outside = is_outside | (has_no_crossing & is_low_outside & is_high_outside)
        outcomes = lines.outcomes(self.ranges[axis])
        outcomes = np.where(is_line_outside, LineOutcome.OUTSIDE_MODEL, outcomes)
        if len(nodes) == 1:
            outcomes[:] = LineOutcome.UNKNOWN
        columns = {
            f"critical_{axis}": np.where(is_outside, np.nan, lines.critical),
            f"outcome_along_{axis}": outcomes.astype(np.int8),
        }
        return {name: column[inverse] for name, column in columns.items()}

    def velocity_of_probability(self, points: QueryPoints, probability: float = 0.5) -> Array:
        """Velocities (k,) [m/s] at which severe wear has this probability, at the loads of points.

        NaN for none among the velocities of the sweep, or if a film carries too much load.
        """
        levels = self._levels(points, probability)
        first, inverse = _distinct(points.load, levels, points.bulk_temperature)
        points, levels = points.take(first), levels[first]
        velocities = self.field.along_velocity(points.load, levels, MAX_EXTRAPOLATION).critical
        low, high = self.ranges["velocity"]
        is_inside = (low <= velocities) & (velocities <= high)
        is_inside &= ~self.films(points._replace(velocity=velocities))[0]
        return np.where(is_inside, velocities, np.nan)[inverse]

    def _levels(self, points: QueryPoints, probability: float) -> Array:
        """ln(rise) at which severe wear has this probability, at the conditions of points (k,)."""
        bulks = points.bulk_temperature
        return self.limits(points) + self.evidence.log_rise_ratio_quantiles(probability, bulks)

    def end_temperatures(
        self, points: QueryPoints, temperatures: Array | None = None
    ) -> dict[str, Array]:
        """Temperature at the hottest end of the pin at points (k,) [K], if the pin has free ends.

        `temperatures` are the governing ones of the whole pin [K], by default the critical one.
        """
        case, bulks = self.case, points.bulk_temperature
        if "end_rise_ratio" not in case.ds:
            return {}
        if temperatures is None:
            temperatures = np.full(bulks.shape, known_critical_temperature(self.conditions))
        share, quantiles = self.conditions.critical_area_fraction, case.ds["area_fraction_below"]
        ratios = rise_exceeded(case.array("end_rise_ratio"), share, quantiles.values)
        is_known = case.done & (ratios > 0)
        count = is_known.sum(axis=0)
        means = np.where(is_known, ratios, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)
        ratio = self.field.at(points.load, points.velocity).bilinear(means)
        return {"end_temperature": bulks + ratio * (temperatures - bulks)}

    def velocity_errors(self, loads: Array, velocities: Array) -> Array:
        """Relative errors of critical velocities by part (5, k)."""
        field_points = self.field.at(loads, velocities)
        parts = rise_errors(self.specimen, self.preset_error, field_points)
        return velocity_errors(self.field, parts, loads, velocities)


def _distinct(*columns: Array) -> tuple[Indices, Indices]:
    """Indices of the distinct rows of columns (k,), and for each row its number among them."""
    _, first, inverse = np.unique(np.stack(columns), axis=1, return_index=True, return_inverse=True)
    return first, inverse.ravel()

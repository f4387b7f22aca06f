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
from typing import Any

import numpy as np

from pipeline.answers.condition_values import Operation, evaluate_by_bulk, override_conditions
from pipeline.answers.critical_temperature import critical_temperature_of
from pipeline.answers.discretization_error import velocity_error
from pipeline.answers.error import PARTS, rise_errors, total, velocity_errors
from pipeline.answers.evidence import Evidence, evidence_of
from pipeline.answers.field import Field, Lines, Outcome, film_field
from pipeline.answers.results import CaseResults
from pipeline.answers.rulings import Rulings
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.constants import DECIDED, FARTHEST
from pipeline.messages import join_notes
from pipeline.quantities import UNITS
from pipeline.sweep.condition_entries import Conditions, known_critical_temperature
from tribo import Stages, WarningKind
from tribo.types import Array, Mask

MILD, UNDECIDED, SEVERE, OUTSIDE, UNKNOWN = range(5)
"""Codes of verdicts on the next specimen."""
VERDICTS = "mild", "undecided", "severe", "outside_model", "unknown"
"""Names of these codes."""
SIMULATED, INTERPOLATED, EXTRAPOLATED = range(3)
ORIGINS = "simulated", "interpolated", "extrapolated"
_AXES = {"load": "loads", "velocity": "velocities"}
_TOO_FEW = "too few points nearby are done; finish the run, or add points there"


class Flag(IntFlag):
    """Limitations of the answer on an operating point."""

    CONTACT_AT_EDGE = 1  # the contact reaches the edge of the window at neighbouring points
    FILM_UNKNOWN = 2
    RULED_OUT = 4  # a test rules the verdict out, or one without a result may
    SHARP_ENDS = 8  # mild, but near the velocity that is critical for the pin's sharp ends


class JudgedCase:
    """Specimens, films and evidence of one case, cached by the conditions that they depend on."""

    def __init__(self, case: CaseResults) -> None:
        self.case, self.promised = case, velocity_error(case.sweep)
        self._cache = dict[Any, Any]()

    def _cached(self, key: Any, compute: Any) -> Any:
        if key not in self._cache:
            self._cache[key] = compute()
        return self._cache[key]

    def under(self, conditions: Conditions) -> VerdictModel:
        """Verdict model under `conditions`; points may replace friction and bulk temperature."""
        c, from_tests = conditions, self.case.sweep.base.critical_from_tests
        if not from_tests:
            known_critical_temperature(c)
        specimen = self._cached(
            ("specimen", c.critical_area_fraction, c.corrections),
            lambda: specimen_of(self.case, c),
        )
        if c.critical_temperature is None:
            critical_key = (
                "from tests",
                c.added_rise_fraction,
                c.critical_area_fraction,
                c.corrections,
            )
            critical, evidence = self._cached(
                critical_key, lambda: critical_temperature_of(self.case, specimen, c)
            )
            c = replace(c, critical_temperature=critical.temperature)
            return VerdictModel(self, c, specimen, evidence)
        oil_key = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
        evidence = self._cached(
            ("evidence", *oil_key, c.corrections), lambda: evidence_of(self.case, specimen, c)
        )
        return VerdictModel(self, c, specimen, evidence)

    def film_excess(self, points: Operation) -> Array | None:
        """Ln of the film pressure over that which carries a fifth of the load (k,); NaN if unknown.

        None if the case has no film.
        """
        if not points.load.size:
            return np.zeros(0)
        if self._film(self.case.conditions.bulk_temperature) is None:
            return None

        def excess(bulk: float, is_member: Mask) -> Array:
            return np.asarray(self._film(bulk)(points.load[is_member], points.velocity[is_member]))

        return evaluate_by_bulk(points.bulk_temperature, excess)

    def _film(self, bulk: float) -> Any:
        return self._cached(("film", bulk), lambda: film_field(self.case, bulk))


def conditions_of(case: CaseResults, overrides: Mapping[str, Any]) -> Conditions:
    """Conditions of a case, some replaced, with a number for a critical temperature from tests."""
    conditions = override_conditions(case.conditions, overrides)
    is_critical_unknown = (
        conditions.critical_temperature is None and case.sweep.base.critical_from_tests
    )
    return JudgedCase(case).under(conditions).conditions if is_critical_unknown else conditions


@dataclass(frozen=True, eq=False)
class VerdictModel:
    """Answers on operating points of one case, under its conditions."""

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
    def rulings(self) -> Rulings:
        """Verdicts that tests rule out."""
        return Rulings(self.case, self.evidence)

    @functools.cached_property
    def limit(self) -> float:
        """ln(allowable rise) at the friction and bulk temperature of the conditions."""
        unit = np.ones(1)
        return float(self.limits(Operation.under(self.conditions, unit, unit))[0])

    def limits(self, points: Operation) -> Array:
        """ln(allowable rise) of points (k,)."""
        critical = known_critical_temperature(self.conditions)
        rise_factor = points.friction * (1 + self.conditions.added_rise_fraction)
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
        points = Operation.under(self.conditions, *(axis.ravel() for axis in plane))
        return bool((self.films(points)[1] & field.is_known.ravel()).any())

    def films(self, points: Operation) -> tuple[Mask, Mask]:
        """Masks (k,): the film carries more load than the model allows; the film is unknown."""
        excess = self.judged_case.film_excess(points)
        if excess is None:
            return np.zeros(points.load.shape, bool), np.zeros(points.load.shape, bool)
        return np.nan_to_num(excess, nan=-1.0) > 0, np.isnan(excess)

    def points(self, points: Operation) -> dict[str, Any]:
        """Answers on points by name, each (k,), except those along lines through them."""
        is_valid = (
            (points.load > 0)
            & (points.velocity > 0)
            & np.isfinite(points.load)
            & np.isfinite(points.velocity)
        )
        load = np.where(is_valid, points.load, np.nan)
        velocity = np.where(is_valid, points.velocity, np.nan)
        rise = self.field(load, velocity)
        reasons = self._reasons(points, rise)
        is_known = np.array([not text for text in reasons], bool)
        rise = np.where(is_known, rise, np.nan)
        log_ratio = rise - self.limits(points)
        errors = np.where(
            is_known, rise_errors(self.specimen, self.promised, load, velocity), np.nan
        )
        total_error = total(errors)
        log_error = np.where(np.isfinite(total_error), np.log1p(total_error), 0.0)
        low, probability, high = self.evidence.probabilities(
            (log_ratio - log_error, log_ratio, log_ratio + log_error), points.bulk_temperature
        )
        low = np.where(np.isnan(total_error) & is_known, 0.0, low)
        high = np.where(np.isnan(total_error) & is_known, 1.0, high)
        is_outside, is_film_unknown = self.films(points._replace(load=load, velocity=velocity))
        verdict = np.select(
            (~is_known, is_outside, high <= DECIDED[0], low >= DECIDED[-1]),
            (UNKNOWN, OUTSIDE, MILD, SEVERE),
            UNDECIDED,
        )
        is_ruled_out = self._withhold(verdict, reasons, points)
        verdict = np.where(is_ruled_out, UNDECIDED, verdict).astype(np.int8)
        rise_per_friction = (1 + self.conditions.added_rise_fraction) * np.exp(rise)
        critical = known_critical_temperature(self.conditions)
        is_simulated = is_known & self.field.is_point(points.load, points.velocity)
        is_extrapolated = is_known & ~is_simulated & self.field.is_extrapolated(load, velocity)
        is_at_edge = (self.specimen.flags & int(WarningKind.CONTACT_AT_EDGE)) != 0
        is_at_edge = is_known & (self.field.bilinear(is_at_edge.astype(float), load, velocity) > 0)
        flags = is_at_edge * Flag.CONTACT_AT_EDGE + (is_known & is_film_unknown) * Flag.FILM_UNKNOWN
        has_no_verdict = is_outside | ~is_known
        temperature_rise = points.friction * rise_per_friction
        return {
            "verdict": verdict,
            "probability": np.where(has_no_verdict, np.nan, probability),
            "probability_low": np.where(has_no_verdict, np.nan, low),
            "probability_high": np.where(has_no_verdict, np.nan, high),
            "log_rise_ratio": log_ratio,
            "governing_temperature": points.bulk_temperature + temperature_rise,
            "temperature_margin": critical - (points.bulk_temperature + temperature_rise),
            "temperature_error": temperature_rise * total_error,
            **{
                f"temperature_error_{part}": temperature_rise * error
                for part, error in zip(PARTS, errors, strict=True)
            },
            "critical_friction": (critical - points.bulk_temperature) / rise_per_friction,
            "friction_safety_factor": np.where(has_no_verdict, np.nan, np.exp(-log_ratio)),
            "origin": np.select(
                (~is_known, is_simulated, is_extrapolated),
                (-1, SIMULATED, EXTRAPOLATED),
                INTERPOLATED,
            ).astype(np.int8),
            "warning_flags": (flags + is_ruled_out * Flag.RULED_OUT).astype(np.int16),
            "reason": reasons,
        }

    def _withhold(self, verdict: Array, reasons: Any, points: Operation) -> Mask:
        """Mask of points whose verdict contradicts tests; writes an explanation to `reasons`."""
        is_ruled_out = np.zeros(verdict.shape, bool)
        for code in (MILD, SEVERE):
            indices = np.flatnonzero(verdict == code)
            explanations = self.rulings.reasons(VERDICTS[code], points.take(indices))
            for k, explanation in zip(indices.tolist(), explanations, strict=True):
                if explanation:
                    reasons[k], is_ruled_out[k] = explanation, True
        return is_ruled_out

    def _reasons(self, points: Operation, rise: Array) -> Any:
        """Reasons for points without an answer; an empty text for points with one."""
        reasons, ranges = np.full(points.load.shape, "", object), self.ranges
        values = np.stack([points.load, points.velocity])
        low, high = np.transpose([ranges["load"], ranges["velocity"]])[..., None]
        is_inside = ((low <= values) & (values <= high) & (values > 0)).all(axis=0)
        for k in np.flatnonzero(~is_inside).tolist():
            load, velocity = values[:, k].tolist()
            reasons[k] = outside_reason(self.case, ranges, load=load, velocity=velocity)
        reasons[np.isnan(rise) & (reasons == "")] = _TOO_FEW
        return reasons

    def critical(self, axis: str, points: Operation) -> dict[str, Any]:
        """Critical values along `axis`, on lines through the points' values on the other axis."""
        line_values = points.load if axis == "velocity" else points.velocity
        levels = self.limits(points)
        pairs = np.stack([line_values, levels, points.bulk_temperature])
        _, first_indices, inverse = np.unique(pairs, axis=1, return_index=True, return_inverse=True)
        points = points.take(first_indices)
        line_values, levels = line_values[first_indices], levels[first_indices]
        find_lines = self.field.along_velocity if axis == "velocity" else self.field.along_load
        lines = find_lines(line_values, levels)
        critical, is_outside = self._inside(axis, points, lines)
        codes = lines.outcomes(self.ranges[axis])
        codes = np.where(is_outside, Outcome.OUTSIDE_MODEL, codes).astype(np.int8)
        if len(self.field.velocities if axis == "velocity" else self.field.loads) == 1:
            codes[:] = Outcome.NO_LINE
        columns = {f"critical_{axis}": critical, f"outcome_along_{axis}": codes}
        return {name: column[inverse.ravel()] for name, column in columns.items()}

    def _inside(self, axis: str, points: Operation, lines: Lines) -> tuple[Array, Mask]:
        """Critical values, NaN where a film carries too much load; mask of lines outside."""

        def is_outside_model(values: Array) -> Mask:
            is_known, is_outside = np.isfinite(values), np.zeros(values.shape, bool)
            is_outside[is_known] = self.films(points._replace(**{axis: values}).take(is_known))[0]
            return is_outside

        is_critical_outside = is_outside_model(lines.critical)
        are_ends_outside = is_outside_model(lines.low) & is_outside_model(lines.high)
        is_line_outside = is_critical_outside | (np.isnan(lines.critical) & are_ends_outside)
        return np.where(is_critical_outside, np.nan, lines.critical), is_line_outside

    def velocity_of_probability(self, points: Operation, probability: float = 0.5) -> Array:
        """Velocities (k,) [m/s] at which severe wear has this probability, at the loads of points.

        NaN for none among the velocities of the sweep, or if a film carries too much load.
        """
        levels = self.limits(points) + self.evidence.log_rise_ratio_quantiles(
            probability, points.bulk_temperature
        )
        velocities = self.field.along_velocity(points.load, levels, FARTHEST).critical
        low, high = self.ranges["velocity"]
        with np.errstate(invalid="ignore"):
            is_known = np.isfinite(velocities) & (low <= velocities) & (velocities <= high)
        is_known[is_known] = ~self.films(points._replace(velocity=velocities).take(is_known))[0]
        return np.where(is_known, velocities, np.nan)

    def decided_velocities(self, points: Operation) -> dict[str, Any]:
        """Velocities (k,) [m/s] at the loads of points, up to and from which a verdict is possible.

        ``critical_velocity_p05`` is lowered to a test that rules out mild wear, and ``_p95`` is
        raised to one that rules out severe wear. ``ruled_out_by`` names these tests. A velocity is
        NaN outside the sweep, or if the verdict is withheld at all velocities.
        """
        notes, columns = [list[str]() for _ in points.load], dict[str, Any]()
        for excluded, probability, template in (
            ("mild", DECIDED[0], "{} rules out mild wear from {:g} m/s"),
            ("severe", DECIDED[-1], "{} rules out severe wear up to {:g} m/s"),
        ):
            velocities = self.velocity_of_probability(points, probability)
            limits, names = self.rulings.velocity_limits(excluded, points)
            is_mild = excluded == "mild"
            level = self.limits(points) + self.evidence.log_rise_ratio_quantiles(
                probability, points.bulk_temperature
            )
            low, high = self.ranges["velocity"]
            log_rise = self.field(points.load, np.clip(limits, low, high))
            with np.errstate(invalid="ignore"):
                # At the limit, the probability alone would still give the verdict.
                is_limited = log_rise <= level if is_mild else log_rise >= level
                is_limited |= limits < velocities if is_mild else limits > velocities
            is_limited &= limits < math.inf if is_mild else limits > 0
            is_inside = (low <= limits) & (limits <= high)
            ruled = np.where(is_inside, limits, np.nan)
            columns[f"critical_velocity_p{100 * probability:02.0f}"] = np.where(
                is_limited, ruled, velocities
            )
            for k in np.flatnonzero(is_limited).tolist():
                if names[k]:
                    notes[k].append(template.format(names[k], limits[k]))
        return columns | {"ruled_out_by": np.array([*map(join_notes, notes)], object)}

    def velocity_errors(self, loads: Array, velocities: Array) -> Array:
        """Relative errors of critical velocities by part (4, k)."""
        parts = rise_errors(self.specimen, self.promised, loads, velocities)
        return velocity_errors(self.field, parts, loads, velocities)


def outside_reason(
    case: CaseResults, ranges: Mapping[str, tuple[float, float]], **point: float
) -> str:
    """Reason that a load and a velocity are unknown; empty if they lie within `ranges`."""
    outside = {
        name: value
        for name, value in point.items()
        if not (ranges[name][0] <= value <= ranges[name][1] and value > 0)
    }
    if not outside:
        return ""
    texts = []
    for name, value in outside.items():
        (low, high), unit = ranges[name], UNITS[name]
        texts.append(f"{name} {value:g} {unit} is outside the sweep ({low:g} to {high:g} {unit})")
    limits = ", ".join(texts)
    if not all(0 < value < math.inf for value in point.values()):
        return f"{limits}; give a value inside it"
    if case.is_row:
        requested = ", ".join(f"{name} {value:g} {UNITS[name]}" for name, value in point.items())
        return (
            f"{requested} is not a case of the sweep, in which each case has its own load and "
            "velocity; add it to sweep.along, and run the scene again"
        )
    if isinstance(case.sweep.scene.loading, Stages):  # which end at the highest load
        return f"{limits}; run the scene with it into another store"
    entries = " and ".join(f"sweep.{_AXES[name]}" for name in outside)
    return f"{limits}; add it to {entries}, and run the scene again"

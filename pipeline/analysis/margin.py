"""Verdict on an operating point: probability of severe wear, distance from it, and errors.

Three errors count. The numerical error (`pipeline.analysis.rise_error`) shifts all rises. Surfaces
have rises that differ. The model's own error
(`pipeline.analysis.model_error`) shifts the critical velocity of a further laboratory run. The
verdict is mild if this run is severe with a probability of at most 5 % at the worst numerical
error. It is severe if this probability is at least 95 %. Otherwise it is not decided.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pipeline.analysis.caveats import scene_caveats
from pipeline.analysis.field import Here, PointField, quantile
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.rise_error import RiseError, totals
from pipeline.sweep.shown import shown
from tribo.types import Array, Mask

NOT_DECIDED = "not decided"
"""Verdict if a further run is neither mild nor severe with 95 % probability."""
DECIDED = (0.05, 0.5, 0.95)
"""Probabilities of severe wear: up to the first the verdict is mild, from the last on severe."""
PASSED = "wear is severe at lower loads at this velocity, through which a ramp passes"
"""Caveat on an operating point where wear is mild, but severe at lower loads."""
_LEAST = 1e-4  # least probability that is stated as a number: the tails are not known better


@shown
@dataclass(frozen=True, slots=True)
class Margin:
    """The verdict on an operating point, and its distances from severe wear.

    The distances are the critical temperature minus the contact temperature that the criterion
    compares with it (``distance``), critical velocity over velocity (``velocity_factor``), and
    critical load over load (``load_factor``). With several surfaces,
    temperatures and critical values are medians, and ``intervals`` has their 5 and 95 % quantiles.
    Beyond the computed velocities the temperature rise is extrapolated as a power of the velocity.

    Examples
    --------
    >>> import pipeline
    >>> here = pipeline.margin("results/first_try.zarr", "400 N", "1.4 m/s")
    >>> here.verdict, here.probability < 0.01
    ('mild', True)
    """

    load: float  #: Normal load on the whole pin [N].
    velocity: float  #: Sliding velocity [m/s].
    probability: float  #: Probability that wear is severe in a further run.
    lowest: float  #: This probability if the numerical error makes contacts colder.
    highest: float  #: This probability if the numerical error makes contacts hotter.
    #: Contact temperature that the criterion compares with the critical temperature [K].
    decisive_temperature: float
    error: RiseError  #: Numerical error of `decisive_temperature` by its parts [K].
    critical_temperature: float  #: Temperature above which the lubricant fails [K].
    distance: float  #: Critical temperature minus `decisive_temperature` [K]; < 0 if severe.
    model_error: str  #: The model's own error and its basis, in words.
    #: Lowest velocity at this load at which wear turns severe [m/s]. NaN if the sweep has none, or
    #: if wear is severe at the lowest velocity.
    critical_velocity: float
    critical_load: float  #: Lowest load at this velocity at which wear turns severe [N], or NaN.
    velocity_outcome: str  #: Why there is no critical velocity, or ranges of severe wear.
    load_outcome: str  #: Why there is no critical load, or ranges of severe wear.
    is_computed: bool  #: True if the sweep has computed this point, so nothing is interpolated.
    is_continued: bool  #: True if the temperature is extrapolated beyond the computed points.
    members: int  #: Number of surfaces.
    #: 5 and 95 % quantiles over surfaces, by attribute such as ``distance``; empty for a
    #: single surface. A critical value is 0 where wear is severe throughout, infinite where mild.
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    tested: tuple[str, ...] = ()  #: Tests of the scene at or near the operating point, in words.
    caveats: tuple[str, ...] = ()  #: Limits of the verdict, one line each.
    #: Values of entries that vary in the sweep, by path [SI].
    entries: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        """Verdict on a further laboratory run: ``"mild"``, ``"severe"`` or ``"not decided"``."""
        return verdict_between(self.lowest, self.highest)

    @property
    def temperature_error(self) -> float | None:
        """Numerical error of `decisive_temperature` [K]; None if a part is unknown."""
        return self.error.total

    @property
    def velocity_factor(self) -> float:
        """Critical velocity at the point's load, divided by the velocity; NaN if unknown."""
        return self.critical_velocity / self.velocity

    @property
    def load_factor(self) -> float:
        """Critical load at the point's velocity, divided by the load; NaN if unknown."""
        return self.critical_load / self.load

    @property
    def decided_by(self) -> str | None:
        """What would decide an undecided verdict, such as "a test at this point"; else None."""
        if self.verdict != NOT_DECIDED:
            return None
        if verdict_between(*[self.probability] * 2) == NOT_DECIDED:  # at any error
            return "a test at this point"
        measured = "its numerical error, which is known for a preset"
        parts = {
            "more points near it": self.error.interpolation,
            measured if self.error.preset is None else "a finer preset": self.error.preset,
            "what its warnings ask for": self.error.warned,
        }
        sizes = {kind: math.inf if part is None else part for kind, part in parts.items()}
        return max(sizes, key=lambda kind: sizes[kind])

    @property
    def sentence(self) -> str:
        """Sentence that states the verdict and the probability of severe wear.

        The sentence also states the distance [K] from the critical temperature, and the tests near
        the operating point with their outcomes, if there are any.
        """
        side = "below" if self.distance >= 0 else "above"
        ends = percent(self.lowest), percent(self.highest)
        within = f" ({ends[0].removesuffix(' %')} to {ends[1]})" if ends[0] != ends[1] else ""
        within = ", numerical error not known" if self.error.total is None else within
        likely = f"severe wear is {percent(self.probability)} likely{within}"
        where = f"{abs(self.distance):.3g} K {side} the critical temperature"
        tests = f"; tested there: {', '.join(self.tested)}" if self.tested else ""
        return f"{self.verdict.capitalize()}: {likely}, {where}{tests}"


def verdict_between(lowest: float, highest: float) -> str:
    """Verdict from the lowest and highest probability of severe wear within numerical error."""
    if highest <= DECIDED[0]:
        return "mild"
    return "severe" if lowest >= DECIDED[-1] else NOT_DECIDED


def clipped(probability: float) -> float:
    """Clip a probability to [1e-4, 1 − 1e-4]: the tails of distributions are not known better."""
    return min(max(probability, _LEAST), 1 - _LEAST)


def percent(probability: float) -> str:
    """A probability in words: a percentage, or "less than 0.01 %"."""
    if probability < _LEAST:
        return f"less than {100 * _LEAST:g} %"
    if probability > 1 - _LEAST:
        return f"more than {100 * (1 - _LEAST):g} %"
    digits = 2 if probability < 0.995 else 4
    return f"{100 * probability:.{digits}g} %"


def answers(
    field: PointField,
    loads: Array,
    velocities: Array,
    scatter: ModelError,
    tested: Sequence[Sequence[str]],
) -> list[Margin | str]:
    """Margin at each of k pairs of load [N] and velocity [m/s], or why it is unknown.

    `scatter` is the model's own error. `tested` has descriptions of the tests near each point.
    """
    here = field.temperatures(loads, velocities)
    is_known = np.array([not reason for reason in here.reasons])
    if not is_known.any():
        return [*here.reasons]
    columns = _margin_columns(field, loads[is_known], velocities[is_known], scatter, here, is_known)
    columns["tested"] = [tuple(tests) for tests in itertools.compress(tested, is_known)]
    notes = scene_caveats(field.source, field.conditions)
    columns["caveats"] = [(*own, *notes) for own in columns["caveats"]]
    shared: dict[str, Any] = {
        "model_error": scatter.text,
        "members": len(field.weights),
        "entries": {path: field.source.rows[path].item() for path, _ in field.source.name},
    }
    rows = zip(*columns.values(), strict=True)
    margins = (Margin(**shared, **dict(zip(columns, row, strict=True))) for row in rows)
    return [reason or next(margins) for reason in here.reasons]


def _margin_columns(
    field: PointField,
    loads: Array,
    velocities: Array,
    scatter: ModelError,
    here: Here,
    is_known: Mask,
) -> dict[str, Sequence[Any]]:
    """Attributes of `Margin` by name, each with k values, for the points where `is_known` is True.

    `loads` and `velocities` are those of these k operating points. `here` has the temperatures at
    all operating points, known or not. `scatter` is the model's own error.
    """
    weights, errors = field.weights, field.errors(loads, velocities)
    values, critical = here.values[:, is_known], here.critical[:, is_known]
    chances = probabilities(field, loads, velocities, scatter, totals(errors))
    along = {axis: field.transitions(axis, loads, velocities) for axis in ("velocity", "load")}
    spread = {"decisive_temperature": values, "distance": critical - values}
    spread |= {f"critical_{axis}": one.first for axis, one in along.items()}
    low, middles, high = (
        {name: quantile(of_members, weights, share) for name, of_members in spread.items()}
        for share in DECIDED
    )
    for name in ("critical_velocity", "critical_load"):
        low[name], high[name] = (np.maximum(ends[name], 0.0) for ends in (low, high))
        is_place = (middles[name] > 0) & np.isfinite(middles[name])
        middles[name] = np.where(is_place, middles[name], math.nan)
    arrays = middles | dict(zip(("lowest", "probability", "highest"), chances, strict=True))
    arrays |= {"load": loads, "velocity": velocities}
    arrays |= {"critical_temperature": quantile(critical, weights, 0.5)}
    columns: dict[str, Any] = {name: numbers.tolist() for name, numbers in arrays.items()}
    columns["is_computed"] = here.is_computed[is_known].tolist()
    columns["is_continued"] = here.is_continued[is_known].tolist()
    scales = map(field.conditions.temperature_error, columns["decisive_temperature"])
    pairs = zip(errors.T, scales, strict=True)
    columns["error"] = [RiseError.of(parts).times(scale) for parts, scale in pairs]
    for axis, one in along.items():
        columns[f"{axis}_outcome"] = [*one.outcome_texts(axis)]
    is_passed = (quantile(along["load"].first, weights, 0.5) < loads) & (middles["distance"] >= 0)
    columns["caveats"] = [(PASSED,) * passed for passed in is_passed.tolist()]
    if len(weights) > 1:
        ends = (zip(low[name].tolist(), high[name].tolist(), strict=True) for name in low)
        columns["intervals"] = [dict(zip(low, row, strict=True)) for row in zip(*ends, strict=True)]
    return columns


def probabilities(
    field: PointField, loads: Array, velocities: Array, scatter: ModelError, errors: Array
) -> tuple[Array, Array, Array]:
    """Probabilities of severe wear (k,): lowest, as computed, and highest within numerical error.

    `scatter` is the model's own error. `errors` are relative numerical errors of the rise, one for
    each pair of load and velocity (k,) or one for all. Where an error is NaN (unknown), the lowest
    probability is 0 and the highest 1.
    """
    is_known = np.isfinite(errors)
    shift = np.where(is_known, np.log1p(errors), 0.0)
    shifts = np.stack([-shift, 0 * shift, shift])
    low, middle, high = field.probability(loads, velocities, scatter, shifts)
    return np.where(is_known, low, 0.0), middle, np.where(is_known, high, 1.0)


def verdict_plane(
    field: PointField, loads: Array, velocities: Array, scatter: ModelError
) -> tuple[Array, Array]:
    """Lowest and highest probability that a further run is severe, two arrays (load, velocity).

    The arrays differ because of the numerical error. They are 0 and 1 if the tests contradict the
    model. `scatter` is the model's own error. Loads and velocities may be outside the sweep.
    """
    rows, step = [], max(1, field.at_once // len(velocities))
    for begin in range(0, len(loads), step):
        grid = np.meshgrid(loads[begin : begin + step], velocities, indexing="ij")
        at_load, at_velocity = (axis.ravel() for axis in grid)
        errors = totals(field.errors(at_load, at_velocity))
        lowest, _, highest = probabilities(field, at_load, at_velocity, scatter, errors)
        rows.append(np.reshape([lowest, highest], (2, *grid[0].shape)))
    lowest, highest = np.concatenate(rows, axis=1)
    return lowest, highest


def error_band(field: PointField, loads: Array, velocities: Array, scatter: ModelError) -> Array:
    """Lower and upper end [m/s] of the velocities at which the verdict is not decided (k, 2).

    Below the lower end the verdict is mild, and above the upper end it is severe, at each of k
    `loads` [N]. `scatter` is the model's own error. `velocities` [m/s] are those tried, in
    ascending order. An end is NaN if it is outside these velocities. But if the verdict is mild at
    all of them, the lower end is infinite; if it is severe at all of them, the upper end is 0.
    The upper end is sought up to the last velocity whose numerical error is known.
    """
    ends = []
    for lowest, highest in zip(*verdict_plane(field, loads, velocities, scatter), strict=True):
        last = np.max(np.flatnonzero(highest - lowest < 1), initial=0)  # last with a known error
        severe_above = _first_exceeding(1 - lowest[last::-1], velocities[last::-1], 0.0)
        ends.append((_first_exceeding(highest, velocities, math.inf), severe_above))
    return np.array(ends)


def _first_exceeding(chances: Array, velocities: Array, never: float) -> float:
    """Velocity at which `chances`, probabilities at each of `velocities`, first exceed 5 %.

    The result is `never` if all are below, and NaN if already the first is above.
    """
    (above,) = np.nonzero(chances > DECIDED[0])
    if not above.size:
        return never
    part = [above[0] - 1, above[0]]
    return float(np.interp(DECIDED[0], chances[part], velocities[part])) if above[0] else math.nan

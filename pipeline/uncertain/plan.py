"""The next measurement: candidates, ranked by how much each is expected to narrow the boundary."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.uncertain.answers import STEPS, log_crossings
from pipeline.uncertain.ensemble import FRICTION, Ensemble
from pipeline.uncertain.inputs import Draws
from pipeline.uncertain.weigh import Posterior
from tribo.types import Array

WIDTH_SCATTER = 0.03
"""Relative standard deviation of a measured width."""
_SPAN = 1.05  # ratio of velocities between which a slope is taken
_KNOWN = 0.1  # of an input's spread: what a good measurement of it leaves


@dataclass(frozen=True, slots=True)
class Candidate:
    """A measurement that could be made next.

    Attributes
    ----------
    what : str
        What to measure.
    spread : float
        Spread of the boundary that is expected to be left by it: the standard deviation of the
        logarithm of the critical velocity, root mean square over the loads.
    before : float
        Spread of the boundary today, in the same measure.

    Examples
    --------
    >>> Candidate("the friction", spread=0.03, before=0.05).spread
    0.03
    """

    what: str
    spread: float
    before: float

    @property
    def narrows(self) -> float:
        """Share of today's spread that the measurement takes away."""
        return 1 - self.spread / self.before


def candidates(found: Posterior) -> tuple[Candidate, ...]:
    """Rank measurements by how much each is expected to narrow the boundary, the best first.

    Expected as if all were normal and linear: what is measured with some error takes away its
    share of the variance.

    Parameters
    ----------
    found : Posterior
        What is known today.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> best, *_ = pipeline.candidates(pipeline.posterior(ensemble))
    >>> best.spread < best.before
    True
    """
    ensemble, draws = found.ensemble, found.draws
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excesses(draws.inputs, ensemble.loads, velocities, with_error=False)
    boundary = log_crossings(velocities, excess.values)

    def centred(values: Array) -> Array:
        off: Array = values - draws.mean(values)
        return off

    y = centred(boundary)
    variance = draws.mean(y**2)
    before = math.sqrt(float(variance.mean()))

    def after(quantity: Array, error: float) -> float:
        q = centred(quantity)
        total = float(draws.mean(q**2)) + error**2
        left = variance - draws.mean(q[:, None] * y) ** 2 / max(total, 1e-300)
        return math.sqrt(max(float(left.mean()), 0.0))

    ranked = [
        Candidate(what, after(quantity, error), before)
        for what, quantity, error in _quantities(found, boundary)
    ]
    return tuple(sorted(ranked, key=lambda each: each.spread))


def _quantities(found: Posterior, boundary: Array) -> Iterator[tuple[str, Array, float]]:
    """Name of each quantity that could be measured, its value by draw, and its error."""
    ensemble, draws = found.ensemble, found.draws
    for load, column in zip(ensemble.loads.tolist(), boundary.T, strict=True):
        at = math.exp(draws.quantile(column, 0.5))
        velocity = float(np.clip(at, *ensemble.velocities))
        error = math.hypot(found.scatter, _velocity_error(ensemble, draws, load, velocity))
        yield f"a transition at {load:g} N, about {at:.3g} m/s", column, error
        width = ensemble.width(draws.inputs, load, velocity)
        error = math.hypot(WIDTH_SCATTER, float(draws.mean(width.error)[0]))
        yield f"the worn width at {load:g} N, {velocity:.3g} m/s", width.values[:, 0], error
    for each, column in zip(ensemble.unknown, draws.inputs.T, strict=True):
        values = np.log(column) if each.is_relative else column
        if each.kind == "list":
            yield f"{each.path} itself", _effect(values, boundary, draws), 0.0
            continue
        spread = math.sqrt(float(draws.mean((values - draws.mean(values)) ** 2)))
        name = "friction" if each.path == FRICTION else each.path
        yield f"{name}, to a tenth of its spread today", values, _KNOWN * spread


def _velocity_error(ensemble: Ensemble, draws: Draws, load: float, velocity: float) -> float:
    """Standard error of the emulated critical velocity against a simulation, relative."""
    ends = np.clip([velocity / _SPAN, velocity * _SPAN], *ensemble.velocities)
    excess = ensemble.excess(draws.inputs, load, ends)
    slope = draws.mean(np.diff(excess.values)[:, 0]) / math.log(ends[1] / ends[0])
    return float(np.sqrt(draws.mean(excess.error[:, 0] ** 2)) / max(slope, 0.05))


def _effect(values: Array, boundary: Array, draws: Draws) -> Array:
    """Mean of the boundary by value of an input that has no scale."""
    found = np.empty(len(values))
    each = boundary.mean(axis=1)
    for value in np.unique(values):
        at = values == value
        found[at] = np.average(each[at], weights=np.maximum(draws.weights[at], 1e-300))
    return found

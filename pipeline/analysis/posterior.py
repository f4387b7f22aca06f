"""What measured transitions say about inputs that are not known exactly, and what to measure next.

At a measured transition the decisive rise equals its limit. So each draw of the inputs is weighed
by how far its logarithm of rise over limit is from 0 there, beside the scatter of the measurement
and what the polynomial in place of the simulation errs by.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.analysis.ensemble import FRICTION, Ensemble
from pipeline.analysis.risk import Draws, prior
from pipeline.sweep.unknown import correlations
from tribo import InputError
from tribo.types import Array

SCATTER = 0.05
"""Relative standard deviation of measured velocities, where a scene does not give it."""
WIDTH_SCATTER = 0.03
"""Relative standard deviation of a measured width."""
_ENOUGH = 400  # draws of equal weight, that tell either end of 90 % to 6 % of the half-width
_MOST = 2**18
_SLOPE_SPAN = 1.05  # ratio of velocities and of loads between which a slope is taken
_HIDDEN = 0.5  # correlation from which two inputs are said to hide behind each other
_KNOWN = 0.1  # of an input's spread: what a good measurement of it leaves


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """Joint distribution of the unknown inputs, given measured transitions.

    Attributes
    ----------
    ensemble : Ensemble
        The samples that it rests on.
    prior, draws : Draws
        Values before and after they were weighed by the measurements.
    measured : tuple of dict
        Measured transitions, each with ``normal_load`` [N], ``velocity`` [m/s] and ``friction``.
    computed : tuple of tuple of float
        Critical velocity at each transition that 5, 50 and 95 % stay below, given all of them
        [m/s].
    scatter : float
        Relative standard deviation of measured velocities that do not give their own.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.posterior(ensemble)
    >>> len(found.measured)
    4
    """

    ensemble: Ensemble
    prior: Draws
    draws: Draws
    measured: tuple[dict[str, Any], ...]
    computed: tuple[tuple[float, float, float], ...]
    scatter: float

    def summary(self) -> Iterator[dict[str, Any]]:
        """Mean, spread and 90 % interval of each input, before and after [SI].

        Of an input that is one of a list, the probability of each of its values instead.
        """
        for number, each in enumerate(self.ensemble.unknown):
            found: dict[str, Any] = {"path": each.path, "unit": each.unit}
            for name, draws in (("prior", self.prior), ("posterior", self.draws)):
                column = draws.inputs[:, number]
                if each.kind == "list":
                    odds = {f"{v:g}": float(draws.mean(column == v)) for v in each.parameters}
                    found[name] = {"probability": odds}
                    continue
                mean = float(draws.mean(column))
                found[name] = {
                    "mean": mean,
                    "sd": math.sqrt(float(draws.mean((column - mean) ** 2))),
                    "interval": [draws.quantile(column, share) for share in (0.05, 0.95)],
                }
            yield found

    @property
    def is_thin(self) -> bool:
        """Whether so few draws decide that intervals are not to be relied on."""
        return self.draws.effective < _ENOUGH

    @property
    def correlations(self) -> Array:
        """Correlation of each two inputs, shape (n_unknown, n_unknown)."""
        values = self._scaled()
        values = values - self.draws.mean(values)
        covariance = values.T @ (self.draws.weights[:, None] * values)
        spread = np.sqrt(np.diag(covariance))
        found: Array = covariance / np.maximum(np.outer(spread, spread), 1e-300)
        return found

    def hidden(self) -> Iterator[tuple[str, str, float]]:
        """Pairs of inputs that the measurements cannot tell apart, and their correlation.

        Those that the scene correlates itself are not among them.
        """
        found, assumed = self.correlations, correlations(self.ensemble.unknown)
        paths = [each.path for each in self.ensemble.unknown]
        for i, j in zip(*np.triu_indices(len(paths), 1), strict=True):
            if abs(found[i, j]) >= _HIDDEN and assumed[i, j] == 0:
                yield paths[i], paths[j], float(found[i, j])

    def _scaled(self) -> Array:
        columns = zip(self.ensemble.unknown, self.draws.inputs.T, strict=True)
        return np.stack([np.log(c) if u.is_relative else c for u, c in columns], axis=1)

    def as_dict(self) -> dict[str, Any]:
        """Return all results as plain data."""
        return {
            "inputs": list(self.summary()),
            "correlations": self.correlations.tolist(),
            "hidden": [{"inputs": [a, b], "correlation": c} for a, b, c in self.hidden()],
            "transitions": [
                entry | {"computed": dict(zip(("5 %", "50 %", "95 %"), found, strict=True))}
                for entry, found in zip(self.measured, self.computed, strict=True)
            ],
            "scatter": self.scatter,
            "samples": len(self.ensemble.inputs),
            "draws": len(self.draws.weights),
            "effective_draws": self.draws.effective,
            "too_few_draws": self.is_thin,
        }


def posterior(ensemble: Ensemble, scatter: float = SCATTER) -> Posterior:
    """Weigh the unknown inputs by the scene's measured transitions.

    Without any, what the scene assumes of them comes back.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    scatter : float
        Relative standard deviation of measured velocities that do not give their own.

    Raises
    ------
    InputError
        If a transition lies outside the sweep, the samples are too few, or no draw comes near to
        what was measured.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.posterior(ensemble)
    >>> len(found.computed)
    4
    """
    if not 0 < scatter < 1:
        raise InputError(f"scatter is {scatter:g}; give a share between 0 and 1, such as 0.05")
    terms = [_Term.of(ensemble, entry, scatter) for entry in ensemble.measured]
    count = 2**13
    while True:
        before = prior(ensemble, count)
        misfit = sum((term.misfit(ensemble, before.inputs) for term in terms), np.zeros(count))
        weights = np.exp(-0.5 * (misfit - misfit.min()))
        draws = Draws(before.inputs, weights / weights.sum())
        if draws.effective >= _ENOUGH or count >= _MOST:
            break
        count *= 4
    if draws.effective < _ENOUGH / 10:
        raise InputError(
            f"hardly any of {count} draws comes near to what was measured, the best by "
            f"{math.sqrt(float(misfit.min()) / max(len(terms), 1)):.1f} standard deviations a "
            "transition; widen what [unknown] allows, or look at the measurements"
        )
    computed = tuple(term.computed(ensemble, draws) for term in terms)
    return Posterior(ensemble, before, draws, ensemble.measured, computed, scatter)


def posterior_if_given(
    ensemble: Ensemble, given_measured: bool, scatter: float | None = None
) -> Posterior | None:
    """What the measured transitions say, if they are to count; None if not.

    Raises
    ------
    InputError
        As `posterior` does, or if they are to count and there are none.
    """
    if not given_measured:
        if scatter is not None:
            raise InputError(
                f"scatter is {scatter:g}, that of measured velocities, which count only if the "
                "result is given by the measured transitions: ask for that, too "
                "(--given-measured, in Python given_measured=True), or leave it out"
            )
        return None
    if not ensemble.measured:
        raise InputError(
            "the scene has no measured transition; give it a [[measured]] with load and velocity"
        )
    return posterior(ensemble, SCATTER if scatter is None else scatter)


@dataclass(frozen=True, slots=True, eq=False)
class _Term:
    """One measured transition."""

    fit: Any
    load: float
    velocity: float
    friction: float | None
    variance: float

    @classmethod
    def of(cls, ensemble: Ensemble, entry: dict[str, Any], scatter: float) -> _Term:
        load, velocity = entry["normal_load"], entry["velocity"]
        try:
            fit = ensemble.surrogate(load, [velocity])
        except InputError as error:
            place = f"the transition measured at {load:g} N and {velocity:g} m/s"
            raise InputError(f"{place}: {error}") from error
        errors = [float(fit.error[0]), *_scatters(ensemble, entry, scatter)]
        return cls(fit, load, velocity, entry["friction"], sum(error**2 for error in errors))

    def misfit(self, ensemble: Ensemble, inputs: Array) -> Array:
        """Squares of the distances from the transition, over their variance."""
        found: Array = ensemble.excess(self.fit, inputs, self.friction)[:, 0] ** 2 / self.variance
        return found

    def computed(self, ensemble: Ensemble, draws: Draws) -> tuple[float, float, float]:
        """Critical velocity that 5, 50 and 95 % stay below [m/s]."""
        slope = _exponent(ensemble, self.load, self.velocity)
        excess = ensemble.excess(self.fit, draws.inputs, self.friction)[:, 0]
        at = self.velocity * np.exp(-excess / slope)
        low, middle, high = (draws.quantile(at, share) for share in (0.05, 0.5, 0.95))
        return low, middle, high


def _scatters(ensemble: Ensemble, entry: dict[str, Any], scatter: float) -> Iterator[float]:
    """What the scatter of a transition makes of the logarithm of rise over limit there.

    The rise is proportional to friction, and about a power of the velocity and of the load.
    """
    load, velocity, friction = (entry[name] for name in ("normal_load", "velocity", "friction"))
    known = {name: entry.get(f"{name}_scatter") for name in ("load", "velocity", "friction")}
    share = scatter if known["velocity"] is None else known["velocity"] / velocity
    yield _exponent(ensemble, load, velocity) * share
    if known["load"] is not None:
        yield _exponent_of_load(ensemble, load, velocity) * known["load"] / load
    if known["friction"] is not None:
        yield known["friction"] / friction


def _exponent_of_load(ensemble: Ensemble, load: float, velocity: float) -> float:
    """Exponent of the rise over the load, the mean over the samples."""
    ends = np.clip([load / _SLOPE_SPAN, load * _SLOPE_SPAN], *ensemble.loads[[0, -1]])
    if ends[0] == ends[1]:
        raise InputError(
            f"a load of {load:g} N is said to scatter, which takes samples at other loads to judge "
            "by; give more sweep.loads, or leave out load_scatter"
        )
    low, high = (ensemble.outputs(at, [velocity]).mean() for at in ends)
    return float((high - low) / math.log(ends[1] / ends[0]))


def _exponent(ensemble: Ensemble, load: float, velocity: float) -> float:
    """Exponent of the rise over the velocity, the mean over the samples."""
    ends = np.clip(
        [velocity / _SLOPE_SPAN, velocity * _SLOPE_SPAN],
        ensemble.velocities[0],
        ensemble.velocities[-1],
    )
    low, high = ensemble.outputs(load, ends).mean(axis=0)
    return float((high - low) / math.log(ends[1] / ends[0]))


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
    velocities = np.geomspace(ensemble.velocities[0], ensemble.velocities[-1], 41)
    loads = ensemble.loads.tolist()
    fits = [ensemble.surrogate(load, velocities) for load in loads]
    boundary = np.stack([ensemble.crossings(fit, velocities, draws.inputs) for fit in fits], axis=1)

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
    """What could be measured: its name, its value by draw, and the error of measuring it."""
    ensemble, draws = found.ensemble, found.draws
    for load, column in zip(ensemble.loads.tolist(), boundary.T, strict=True):
        at = math.exp(draws.quantile(column, 0.5))
        velocity = float(np.clip(at, ensemble.velocities[0], ensemble.velocities[-1]))
        missed = float(ensemble.surrogate(load, [velocity]).error[0])
        error = math.hypot(found.scatter, missed / _exponent(ensemble, load, velocity))
        yield f"a transition at {load:g} N, about {at:.3g} m/s", column, error
        width = ensemble.width_surrogate(load, [velocity])
        values = width(draws.inputs[:, list(ensemble.simulated)])[:, 0]
        error = math.hypot(WIDTH_SCATTER, float(width.error[0]))
        yield f"the worn width at {load:g} N, {velocity:.3g} m/s", values, error
    for each, column in zip(ensemble.unknown, draws.inputs.T, strict=True):
        values = np.log(column) if each.is_relative else column
        if each.kind == "list":
            yield f"{each.path} itself", _effect(values, boundary, draws), 0.0
            continue
        spread = math.sqrt(float(draws.mean((values - draws.mean(values)) ** 2)))
        name = "friction" if each.path == FRICTION else each.path
        yield f"{name}, to a tenth of its spread today", values, _KNOWN * spread


def _effect(values: Array, boundary: Array, draws: Draws) -> Array:
    """Mean of the boundary by value of an input that has no scale."""
    found = np.empty(len(values))
    each = boundary.mean(axis=1)
    for value in np.unique(values):
        at = values == value
        found[at] = np.average(each[at], weights=np.maximum(draws.weights[at], 1e-300))
    return found

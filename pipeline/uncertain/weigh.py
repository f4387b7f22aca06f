"""Inputs weighed by measured transitions.

At a measured transition the decisive rise equals its limit. So each draw of the inputs is weighed
by how far its logarithm of rise over limit is from 0 there, beside the scatter of the measurement
and the emulator's error.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.sweep.unknown import correlations
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import Draws, prior
from tribo import InputError
from tribo.types import Array

SCATTER = 0.05
"""Relative standard deviation of measured velocities, where a scene does not give it."""
_ENOUGH = 400  # draws of equal weight, that tell either end of 90 % to 6 % of the half-width
_FIRST, _MOST = 2**13, 2**15
_SLOPE_SPAN = 1.05  # ratio of velocities and of loads between which a slope is taken
_LEAST_SLOPE = 0.05
_HIDDEN = 0.5  # correlation from which two inputs cannot be told apart


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
    count = _FIRST
    while True:
        before = prior(ensemble.unknown, ensemble.design.seed + 1, count)
        parts = [term.parts(before.inputs) for term in terms]
        likelihood = np.zeros(count)
        for excess, deviation, _ in parts:
            likelihood -= 0.5 * (excess / deviation) ** 2 + np.log(deviation)
        weights = np.exp(likelihood - likelihood.max())
        draws = Draws(before.inputs, weights / weights.sum())
        if draws.effective >= _ENOUGH or count >= _MOST:
            break
        count *= 4
    if draws.effective < _ENOUGH / 10:
        best = int(np.argmax(likelihood))
        apart = math.sqrt(np.mean([(each[0][best] / each[1][best]) ** 2 for each in parts]))
        raise InputError(
            f"hardly any of {count} draws comes near to what was measured, the best by "
            f"{apart:.1f} standard deviations a transition; widen what [unknown] allows, or look "
            "at the measurements"
        )
    computed = tuple(
        _computed(draws, term.velocity * np.exp(-excess / slope))
        for term, (excess, _, slope) in zip(terms, parts, strict=True)
    )
    return Posterior(ensemble, before, draws, ensemble.measured, computed, scatter)


def posterior_if_given(
    ensemble: Ensemble, given_measured: bool, scatter: float | None = None
) -> Posterior | None:
    """Inputs weighed by the measured transitions, if they are to count; None if not.

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


def _computed(draws: Draws, velocities: Array) -> tuple[float, float, float]:
    """Critical velocities that 5, 50 and 95 % stay below [m/s]."""
    low, middle, high = (draws.quantile(velocities, share) for share in (0.05, 0.5, 0.95))
    return low, middle, high


@dataclass(frozen=True, slots=True, eq=False)
class _Term:
    """One measured transition, with its scatters: relative ones of load, velocity and friction."""

    ensemble: Ensemble
    load: float
    velocity: float
    conditions: dict[str, float]
    scatters: dict[str, float]

    @classmethod
    def of(cls, ensemble: Ensemble, entry: dict[str, Any], scatter: float) -> _Term:
        load, velocity = entry["normal_load"], entry["velocity"]
        try:
            ensemble.require_within([load], [velocity])
        except InputError as error:
            place = f"the transition measured at {load:g} N and {velocity:g} m/s"
            raise InputError(f"{place}: {error}") from error
        measured = {"load": load, "velocity": velocity, "friction": entry["friction"]}
        scatters = {
            name: entry[f"{name}_scatter"] / value
            for name, value in measured.items()
            if entry.get(f"{name}_scatter") is not None
        }
        friction = entry["friction"]
        conditions = {} if friction is None else {"friction": friction}
        if "load" in scatters and len(ensemble.loads) < 2:
            raise InputError(
                f"a load of {load:g} N is said to scatter, which takes samples at other loads to "
                "judge by; give more sweep.loads, or leave out load_scatter"
            )
        return cls(ensemble, load, velocity, conditions, {"velocity": scatter} | scatters)

    def parts(self, inputs: Array) -> tuple[Array, Array, Array]:
        """Excess, its standard deviation, and its slope over ln(velocity), by draw."""
        excess = self.ensemble.excess(inputs, self.load, self.velocity, self.conditions)
        slow = self.velocity / _SLOPE_SPAN >= self.ensemble.velocities[0]
        near = self.velocity / _SLOPE_SPAN if slow else self.velocity * _SLOPE_SPAN
        beside = self.ensemble.excesses(
            inputs, [self.load], [near], self.conditions, with_error=False
        ).values[:, 0, 0]
        slope = (beside - excess.values[:, 0]) / math.log(near / self.velocity)
        slope = np.maximum(slope, _LEAST_SLOPE)
        variance = excess.error[:, 0] ** 2 + (slope * self.scatters["velocity"]) ** 2
        if "load" in self.scatters:
            variance += (self._slope_over_load(inputs) * self.scatters["load"]) ** 2
        variance += self.scatters.get("friction", 0.0) ** 2
        return excess.values[:, 0], np.sqrt(variance), slope

    def _slope_over_load(self, inputs: Array) -> Array:
        ends = np.clip(
            [self.load / _SLOPE_SPAN, self.load * _SLOPE_SPAN], *self.ensemble.loads[[0, -1]]
        )
        excess = self.ensemble.excesses(
            inputs, ends, [self.velocity], self.conditions, with_error=False
        )
        low, high = excess.values[:, 0, 0], excess.values[:, 1, 0]
        slope: Array = (high - low) / math.log(ends[1] / ends[0])
        return slope

"""Which unknown input moves the boundary how much: Sobol' indices, by load.

The first index of an input is the share of the variance that would be gone if it alone were known;
the total index the share that would stay if all others were.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.analysis.ensemble import Ensemble
from pipeline.analysis.risk import Draws, prior, resampled
from pipeline.analysis.surrogate import Surrogate
from pipeline.sweep.correlation import OUTERMOST
from pipeline.sweep.unknown import Unknown
from tribo.types import Array

_POINTS = 2**12
_FEW = 2**10  # for each of many fits
_STEPS = 41  # velocities among which a boundary is found
_BINS = 24
GOOD = 0.9
"""Share of the variance that a polynomial must explain to be relied on."""


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Sobol' indices of the critical velocity.

    Attributes
    ----------
    unknown : tuple of Unknown
        The inputs.
    loads : tuple of float
        Normal loads on the whole pin [N].
    first, total : ndarray, shape (n_load, n_unknown)
        Indices; the total ones NaN where the inputs are not independent.
    first_interval, total_interval : ndarray, shape (2, n_load, n_unknown)
        Ends of their 90 % intervals, from what the number of samples leaves open.
    spread : tuple of float
        Standard deviation of the logarithm of the critical velocity, by load.
    surrogate_error, explained : tuple of float
        By load, what the polynomial in place of the simulation errs by: of the rise, relative; and
        the share of the rise's variance that it explains of samples that it leaves out.
    given_measured : bool
        Whether they are those of the boundary given measured transitions.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.sensitivity(ensemble)
    >>> [each.path for each in found.unknown]
    ['friction.coefficient', 'temperature.critical']
    """

    unknown: tuple[Unknown, ...]
    loads: tuple[float, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    spread: tuple[float, ...]
    surrogate_error: tuple[float, ...]
    explained: tuple[float, ...]
    given_measured: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data."""
        return {
            "inputs": [each.path for each in self.unknown],
            "loads": list(self.loads),
            "first": self.first.tolist(),
            "first_interval": np.moveaxis(self.first_interval, 0, -1).tolist(),
            "total": self.total.tolist(),
            "total_interval": np.moveaxis(self.total_interval, 0, -1).tolist(),
            "spread": list(self.spread),
            "surrogate_error": list(self.surrogate_error),
            "explained": list(self.explained),
            "given_measured": self.given_measured,
        }


def indices(
    function: Callable[[Array], Array], unknown: Sequence[Unknown], count: int, seed: int
) -> tuple[Array, Array]:
    """First and total Sobol' indices of functions of unknown inputs (`scipy.stats`).

    Parameters
    ----------
    function : callable
        Takes values of shape (n, n_unknown), gives those of the functions, (n, n_output).
    unknown : sequence of Unknown
        The inputs, which are independent.
    count : int
        Number of points, a power of 2; the function is called at n_unknown + 2 times as many.
    seed : int
        Seed of the points.

    Returns
    -------
    tuple of ndarray, shape (n_output, n_unknown)
        First and total indices.
    """
    from scipy.stats import sobol_indices, uniform  # takes 0.5 s

    def of_shares(shares: Array) -> Array:
        inside = np.clip(shares, OUTERMOST, 1 - OUTERMOST)
        values = np.stack([each.at(row) for each, row in zip(unknown, inside, strict=True)], axis=1)
        outputs: Array = function(values).T
        return outputs

    rng = np.random.default_rng(seed)
    found = sobol_indices(func=of_shares, n=count, dists=[uniform()] * len(unknown), rng=rng)
    return np.atleast_2d(found.first_order), np.atleast_2d(found.total_order)


def sensitivity(ensemble: Ensemble, posterior: Draws | None = None) -> Sensitivity:
    """Find which unknown input moves the critical velocity how much, at each load.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    posterior : Draws, optional
        What measurements leave open of the inputs, in place of what the scene assumes. The inputs
        depend on one another then, and there are no total indices; nor are there any where the
        scene correlates inputs.

    Raises
    ------
    InputError
        If the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.sensitivity(ensemble)
    >>> found.total.shape
    (4, 2)
    """
    velocities = np.geomspace(ensemble.velocities[0], ensemble.velocities[-1], _STEPS)
    fits = [ensemble.surrogate(load, velocities) for load in ensemble.loads.tolist()]
    shape = len(ensemble.loads), len(ensemble.unknown)
    dependent = posterior
    if posterior is None and any(each.correlated for each in ensemble.unknown):
        dependent = prior(ensemble)

    def logs(inputs: Array, each: Sequence[Surrogate]) -> Array:
        rows = [ensemble.crossings(fit, velocities, inputs) for fit in each]
        found: Array = np.stack(rows, axis=1)
        return found

    def both(each: Sequence[Surrogate], count: int) -> tuple[Array, Array]:
        if dependent is None:
            return indices(lambda at: logs(at, each), ensemble.unknown, count, ensemble.seed)
        return _first_of(dependent, logs(dependent.inputs, each)), np.full(shape, np.nan)

    outputs = [ensemble.outputs(load, velocities) for load in ensemble.loads.tolist()]
    others = zip(
        *(resampled(ensemble, fit, y) for fit, y in zip(fits, outputs, strict=True)), strict=True
    )
    first, total = both(fits, _POINTS)
    off = np.array([both(each, _FEW) for each in others]) - np.array(both(fits, _FEW))
    ends = np.maximum(np.array([first, total]) + np.quantile(off, (0.05, 0.95), axis=0), 0.0)
    draws = dependent or prior(ensemble)
    values = logs(draws.inputs, fits)
    variance = draws.mean((values - draws.mean(values)) ** 2)
    middle = [int(np.argmin(np.abs(np.log(velocities) - at))) for at in draws.mean(values)]
    return Sensitivity(
        unknown=ensemble.unknown,
        loads=tuple(ensemble.loads.tolist()),
        first=first,
        total=total,
        first_interval=ends[:, 0],
        total_interval=ends[:, 1],
        spread=tuple(np.sqrt(variance).tolist()),
        surrogate_error=tuple(float(f.error[at]) for f, at in zip(fits, middle, strict=True)),
        explained=tuple(float(f.explained[at]) for f, at in zip(fits, middle, strict=True)),
        given_measured=posterior is not None,
    )


def _first_of(draws: Draws, values: Array) -> Array:
    """First indices from weighted draws: the variance of the mean over parts of each input.

    The mean over a part scatters for want of draws, which would count as variance; as much as that
    is taken off.
    """
    weights = draws.weights
    y = values - draws.mean(values)
    by_chance = np.sum((weights[:, None] * y) ** 2, axis=0)  # variance of the mean of all
    found = []
    for column in draws.inputs.T:
        part = _parts(draws, column)

        def summed(each: Array, part: NDArray[np.intp] = part) -> Array:
            total: Array = np.stack([np.bincount(part, row, minlength=_BINS) for row in each.T], 1)
            return total

        weight = np.maximum(summed(weights[:, None]), 1e-150)
        means = summed(weights[:, None] * y) / weight
        scatter = summed((weights[:, None] * (y - means[part])) ** 2) / weight
        alone = 1 - summed(weights[:, None] ** 2) / weight**2  # 0 for a part with a single draw
        scatter = np.where(alone > 1e-9, scatter / np.maximum(alone, 1e-9), weight * means**2)
        found.append(np.sum(weight * means**2 - scatter, axis=0) + by_chance)
    first: Array = np.maximum(found, 0.0).T / (draws.mean(y**2) + by_chance)[:, None]
    return first


def _parts(draws: Draws, column: Array) -> NDArray[np.intp]:
    """Number of the part of its distribution in which each value of an input lies."""
    distinct = np.unique(column)
    if len(distinct) <= _BINS:
        return np.searchsorted(distinct, column)
    order = np.argsort(column, kind="stable")
    below = np.cumsum(draws.weights[order]) - 0.5 * draws.weights[order]
    part = np.empty(len(order), np.intp)
    part[order] = np.minimum((below * _BINS).astype(int), _BINS - 1)
    return part

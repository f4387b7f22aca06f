"""Share of the boundary's variance that each unknown input causes: Sobol' indices, by load.

The first index of an input is the share of the variance that would vanish if this input alone were
known. The total index is the share that would remain if all other inputs were known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pipeline.sweep.shown import shown
from pipeline.uncertain.answers import draws_of, log_boundary
from pipeline.uncertain.ensemble import Ensemble, Samples
from pipeline.uncertain.inputs import Draws
from pipeline.uncertain.unknown import OF_90, Unknown, score_values
from tribo.types import Array

_POINTS = 2**10  # Sobol' points in all
_SCRAMBLES = 4  # sets of points; the scatter between them gives the error
_BINS = 24  # parts of an input's distribution, for indices of correlated inputs


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Sobol' indices of the critical velocity, by load and input."""

    drawn_by: ClassVar = "pipeline.uncertain.figures:draw_sensitivity"
    unknown: tuple[Unknown, ...]  #: The unknown inputs.
    loads: tuple[float, ...]  #: Normal loads on the whole pin [N].
    first: Array  #: First indices, shape (n_load, n_unknown).
    first_interval: Array  #: Ends of their 90 % intervals, shape (2, n_load, n_unknown).
    total: Array  #: Total indices, (n_load, n_unknown); NaN for correlated inputs or a posterior.
    total_interval: Array  #: Ends of their 90 % intervals, shape (2, n_load, n_unknown).
    #: Standard deviation of the logarithm of the critical velocity, by load.
    spread: tuple[float, ...]
    #: Relative standard error of the emulated critical velocity against a simulation, by load.
    velocity_error: tuple[float, ...]
    #: True if the indices are for the posterior, given the tests.
    given_measured: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data; intervals have their two ends on the last axis."""
        data: dict[str, Any] = {"inputs": [quantity.path for quantity in self.unknown]}
        for one in fields(self)[1:]:
            values = np.asarray(getattr(self, one.name))
            is_pair = one.name.endswith("interval")
            data[one.name] = (np.moveaxis(values, 0, -1) if is_pair else values).tolist()
        return data


@np.errstate(under="ignore")
def sensitivity(ensemble: Samples, posterior: Draws | None = None) -> Sensitivity:
    """Find the share of the critical velocity's variance that each unknown input causes, by load.

    Parameters
    ----------
    ensemble : Ensemble, Dataset, str or path
        Samples of a sweep, its dataset or the path of its store.
    posterior : Draws, optional
        Draws of a posterior, which replace the scene's distributions. With a posterior, or if the
        scene correlates inputs, there are no total indices.

    Raises
    ------
    InputError
        If there are too few samples, or no input is unknown.

    Examples
    --------
    >>> import pipeline
    >>> indices = pipeline.sensitivity("results/unknown.zarr")
    >>> indices.total.shape
    (4, 2)
    """
    ensemble = Ensemble.of(ensemble)
    ensemble.require_unknown()
    draws = draws_of(ensemble, posterior)
    values, error = log_boundary(ensemble, draws.inputs, ensemble.loads)
    variance = draws.mean((values - draws.mean(values)) ** 2)
    missed = np.sqrt(draws.mean(error**2))
    is_dependent = posterior is not None or any(
        quantity.correlated for quantity in ensemble.unknown
    )
    if is_dependent:
        first = _first_order_indices(draws, values)
        both, by_points = np.array([first, np.full_like(first, np.nan)]), np.zeros(1)
    else:
        both, by_points = indices(
            lambda inputs: log_boundary(ensemble, inputs, ensemble.loads)[0],
            ensemble.unknown, _POINTS, ensemble.design.seed,
        )  # fmt: skip
    # An error of e × spread changes an index S by at most 2e√S + e².
    share = (OF_90 * missed / np.sqrt(np.maximum(variance, 1e-30)))[:, None]
    by_samples = np.minimum(2 * share * np.sqrt(np.maximum(both, 0.0)) + share**2, 1.0)
    off = np.hypot(by_points, by_samples)
    ends = np.clip([both - off, both + off], 0.0, 1.0)
    return Sensitivity(
        unknown=ensemble.unknown,
        loads=tuple(ensemble.loads.tolist()),
        first=both[0],
        total=both[1],
        first_interval=ends[:, 0],
        total_interval=ends[:, 1],
        spread=tuple(np.sqrt(variance).tolist()),
        velocity_error=tuple(missed.tolist()),
        given_measured=posterior is not None,
    )


def indices(
    function: Callable[[Array], Array], unknown: Sequence[Unknown], count: int, seed: int
) -> tuple[Array, Array]:
    """First-order and total Sobol' indices of independent inputs, with half-widths of 90 % bands.

    Both arrays are (2, n_output, n_unknown), first-order before total. `function` returns the
    outputs (n, n_output) of n draws. `count` is the size of the base sample, drawn with `seed`.
    """
    from scipy.stats import norm, sobol_indices  # takes 0.5 s

    estimates = [
        sobol_indices(
            func=lambda scores: function(score_values(unknown, scores.T)).T,
            n=count // _SCRAMBLES,
            dists=[norm()] * len(unknown),
            rng=np.random.default_rng([seed, number]),
        )
        for number in range(_SCRAMBLES)
    ]
    both = np.array([[one.first_order, one.total_order] for one in estimates])
    both = both.reshape(_SCRAMBLES, 2, -1, len(unknown))
    return both.mean(axis=0), OF_90 * both.std(axis=0, ddof=1) / math.sqrt(_SCRAMBLES)


def _first_order_indices(draws: Draws, values: Array) -> Array:
    """First-order Sobol' indices (n_output, n_unknown), also of correlated inputs.

    The outputs of the draws, `values` (n, n_output), are averaged in bins of an input. The index is
    the variance of these averages, minus what chance adds to it, divided by the output's variance.
    """
    weights = draws.weights
    y = values - draws.mean(values)
    by_chance = np.sum((weights[:, None] * y) ** 2, axis=0)  # variance of the overall mean
    orders = []
    for column in draws.inputs.T:
        part = _bin_numbers(draws, column)
        is_in = part == np.arange(_BINS)[:, None]
        weight = np.maximum(is_in @ weights[:, None], 1e-150)
        means = is_in @ (weights[:, None] * y) / weight
        scatter = is_in @ (weights[:, None] * (y - means[part])) ** 2 / weight
        alone = 1 - is_in @ weights[:, None] ** 2 / weight**2  # 0 if a part holds a single draw
        scatter = np.where(alone > 1e-9, scatter / np.maximum(alone, 1e-9), weight * means**2)
        orders.append(np.sum(weight * means**2 - scatter, axis=0) + by_chance)
    first: Array = np.maximum(orders, 0.0).T / (draws.mean(y**2) + by_chance)[:, None]
    return first


def _bin_numbers(draws: Draws, column: Array) -> NDArray[np.intp]:
    """Bin number (n,) of each draw of an input, given by `column`; bins are equally probable.

    An input of few values has a bin for each value.
    """
    distinct = np.unique(column)
    if len(distinct) <= _BINS:
        return np.searchsorted(distinct, column)
    order = np.argsort(column, kind="stable")
    below = np.cumsum(draws.weights[order]) - 0.5 * draws.weights[order]
    part = np.empty(len(order), np.intp)
    part[order] = np.minimum((below * _BINS).astype(int), _BINS - 1)
    return part

"""The probability of severe wear, where inputs are not known exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import ndtr

from pipeline.analysis.ensemble import Ensemble
from pipeline.analysis.surrogate import Surrogate, redrawn
from pipeline.sweep.unknown import drawn
from tribo.types import Array

_DRAWS = 2**13
_RESAMPLES = 60  # fits, to see what the number of samples leaves open
QUANTILES = (0.05, 0.5, 0.95)
"""Probabilities of severe wear of which the lines are drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Values of the unknown inputs, each with a weight.

    Attributes
    ----------
    inputs : ndarray, shape (n, n_unknown)
        Values [SI].
    weights : ndarray, shape (n,)
        Probabilities; their sum is 1.
    """

    inputs: Array
    weights: Array

    @property
    def effective(self) -> float:
        """Number of draws of equal weight that would tell as much."""
        return float(1 / np.sum(self.weights**2))

    def mean(self, values: Array) -> Any:
        """Weighted mean over the draws, the first axis."""
        return np.tensordot(self.weights, values, axes=1)

    def quantile(self, values: Array, share: float) -> float:
        """Value that a share of the probability stays below."""
        order = np.argsort(values)
        below = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return float(np.interp(share, below, values[order]))


def prior(ensemble: Ensemble, count: int = _DRAWS) -> Draws:
    """Draw from what is assumed of the unknown inputs; not the samples that were simulated."""
    inputs = drawn(ensemble.unknown, ensemble.seed + 1, count)
    return Draws(inputs, np.full(count, 1 / count))


@dataclass(frozen=True, slots=True)
class Risk:
    """Probability of severe wear at an operating point.

    Attributes
    ----------
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    probability : float
        Probability of severe wear.
    error : float
        Standard error of the probability, from the number of samples and draws.
    surrogate_error : float
        What the polynomial in place of the simulation errs by: of the rise, relative.
    samples : int
        Samples that were simulated.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.risk(ensemble, load=400.0, velocity=2.2)
    >>> 0.4 < found.probability < 0.7
    True
    """

    load: float
    velocity: float
    probability: float
    error: float
    surrogate_error: float
    samples: int

    def as_dict(self) -> dict[str, Any]:
        """Return all fields by name."""
        return asdict(self)


def risk(ensemble: Ensemble, load: float, velocity: float, draws: Draws | None = None) -> Risk:
    """Find the probability of severe wear at an operating point.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    draws : Draws, optional
        Draws of the unknown inputs; by what the scene assumes of them if not given.

    Raises
    ------
    InputError
        If the point lies outside the sweep, or the samples are too few.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> found = pipeline.risk(ensemble, load=400.0, velocity=2.5)
    >>> 0.7 < found.probability < 1.0
    True
    """
    draws = draws or prior(ensemble)
    fit = ensemble.surrogate(load, [velocity])
    each = _severe(ensemble, fit, draws)[:, 0]
    probability = float(np.clip(draws.mean(each), 0.0, 1.0))
    by_draws = math.sqrt(float(np.sum((draws.weights * (each - probability)) ** 2)))
    by_samples = float(np.std([
        draws.mean(_severe(ensemble, other, draws))[0]
        for other in resampled(ensemble, fit, ensemble.outputs(load, [velocity]))
    ]))  # fmt: skip
    return Risk(
        load=load,
        velocity=velocity,
        probability=probability,
        error=math.hypot(by_draws, by_samples),
        surrogate_error=float(fit.error[0]),
        samples=len(ensemble.inputs),
    )


def probabilities(
    ensemble: Ensemble,
    draws: Draws | None = None,
    loads: Sequence[float] | Array | None = None,
    velocities: Sequence[float] | Array | None = None,
) -> xr.DataArray:
    """Probability of severe wear over the plane, dims (load, velocity).

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    draws : Draws, optional
        See `risk`.
    loads, velocities : sequence of float, optional
        Where [N, m/s]; evenly between the ends of the sweep if not given.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> plane = pipeline.probabilities(ensemble)
    >>> bool(plane.sel(load=400, velocity=1.0) < 0.01)
    True
    """
    draws = draws or prior(ensemble)
    if loads is None:
        loads = np.linspace(ensemble.loads[0], ensemble.loads[-1], 45)
    if velocities is None:
        velocities = np.linspace(ensemble.velocities[0], ensemble.velocities[-1], 121)
    rows = []
    for load in loads:
        fit = ensemble.surrogate(float(load), np.asarray(velocities))
        # By rounding, weights may add up to a little more than 1.
        rows.append(np.clip(draws.mean(_severe(ensemble, fit, draws)), 0.0, 1.0))
    return xr.DataArray(
        np.array(rows),
        {
            "load": ("load", np.asarray(loads), {"units": "N"}),
            "velocity": ("velocity", np.asarray(velocities), {"units": "m/s"}),
        },
        ("load", "velocity"),
        "probability",
        {"units": "1", "long_name": "probability of severe wear"},
    )


def risk_lines(plane: xr.DataArray) -> tuple[tuple[float, ...], Array]:
    """Velocities at which wear is severe with some probabilities, by load.

    Parameters
    ----------
    plane : DataArray, dims (load, velocity)
        Result of `probabilities`.

    Returns
    -------
    tuple of float, ndarray, shape (n_load, n_share)
        The probabilities, and the velocities [m/s]; NaN where they lie beyond the plane.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> shares, lines = pipeline.risk_lines(pipeline.probabilities(ensemble))
    >>> shares, lines.shape
    ((0.05, 0.5, 0.95), (45, 3))
    """
    velocities = plane["velocity"].values
    rows = np.maximum.accumulate(plane.values, axis=1)
    found = [np.interp(QUANTILES, row, velocities, math.nan, math.nan) for row in rows]
    return QUANTILES, np.array(found)


def resampled(ensemble: Ensemble, fit: Surrogate, outputs: Array) -> list[Surrogate]:
    """Fits that as many other samples could have given."""
    _, inputs = ensemble.simulated_inputs()
    return redrawn(fit, inputs, outputs, _RESAMPLES, ensemble.seed)


def _severe(ensemble: Ensemble, fit: Surrogate, draws: Draws) -> Array:
    """Probability of severe wear of each draw, beside what the fit errs by."""
    excess = ensemble.excess(fit, draws.inputs)
    found: Array = ndtr(excess / np.maximum(fit.error, 1e-9))
    return found

"""Probability of severe wear over the plane, and the boundary of draws."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.tables import frame_of
from pipeline.uncertain.emulator import Groups
from pipeline.uncertain.ensemble import Axis, Ensemble, Excess
from pipeline.uncertain.inputs import QUANTILES, Draws, prior
from tribo.types import Array

MEAN_OF_RUNS = "a probability is that of the mean of runs; single runs scatter about it"
"""What the probabilities of samples mean."""
STEPS = 41
"""Velocities or loads among which a boundary is sought."""
LEAST_SLOPE = 0.05
"""Least slope of ln(rise) over ln(velocity or load), by which a boundary is extrapolated."""


def draws_of(ensemble: Ensemble, draws: Draws | None) -> Draws:
    """The draws given, without those of the rig, which stand last; else draws of the prior."""
    if draws is None:
        return prior(ensemble.unknown, ensemble.design.seed + 1)
    return Draws(draws.inputs[:, : len(ensemble.unknown)], draws.weights, draws.faults)


def probability_of(excess: Excess, draws: Draws) -> tuple[float, float]:
    """Probability that the excess of draws (n,) is above 0, and its standard error.

    What neighbours share is taken as shared by all draws, which errs to the safe side.
    """
    by_draw = excess.probability
    probability = float(np.clip(draws.mean(by_draw), 0.0, 1.0))
    by_draws = math.sqrt(float(np.sum((draws.weights * (by_draw - probability)) ** 2)))
    density = np.exp(-0.5 * (excess.values / excess.error) ** 2) / math.sqrt(2 * math.pi)
    by_samples = float(draws.mean(density * excess.shared / excess.error))
    return probability, math.hypot(by_draws, by_samples)


def probabilities(
    ensemble: Ensemble,
    draws: Draws | None = None,
    loads: Axis | None = None,
    velocities: Axis | None = None,
) -> xr.DataArray:
    """Probability of severe wear over the plane, dims (load, velocity).

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    draws : Draws, optional
        See `risk`.
    loads, velocities : sequence of float, optional
        Axes of the plane [N, m/s]; evenly between the ends of the sweep if not given.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> plane = pipeline.probabilities(ensemble, loads=[400.0])
    >>> bool(plane.sel(load=400, velocity=1.0) < 0.01)
    True
    """
    draws = draws_of(ensemble, draws)
    if loads is None:
        loads = np.linspace(ensemble.loads[0], ensemble.loads[-1], 45)
    if velocities is None:
        velocities = np.linspace(*ensemble.velocities, 121)
    plane = sum(
        part.mean(ensemble.excess(part.inputs, loads, velocities).probability)
        for part in draws.parts()
    )
    return xr.DataArray(
        np.clip(plane, 0.0, 1.0),
        {
            "load": ("load", np.asarray(loads), {"units": "N"}),
            "velocity": ("velocity", np.asarray(velocities), {"units": "m/s"}),
        },
        ("load", "velocity"),
        "probability",
        {"units": "1", "long_name": "probability of severe wear, mean of runs"},
    )


def risk_lines(plane: xr.DataArray) -> tuple[tuple[float, ...], Array]:
    """Probabilities, and velocities (n_load, n_share) of them [m/s]; 0 or infinite beyond."""
    velocities = plane["velocity"].values
    rows = np.maximum.accumulate(plane.values, axis=1)
    lines = [np.interp(QUANTILES, row, velocities, 0.0, math.inf) for row in rows]
    return QUANTILES, np.array(lines)


def frame_of_lines(ensemble: Ensemble, draws: Draws | None = None) -> pd.DataFrame:
    """Velocities of some probabilities at the loads of the sweep, infinite where beyond it."""
    velocities = np.geomspace(*ensemble.velocities, 4 * (STEPS - 1) + 1)
    shares, lines = risk_lines(probabilities(ensemble, draws, ensemble.loads, velocities))
    rows = np.column_stack([ensemble.loads, np.where(lines > 0, lines, -math.inf)]).tolist()
    return frame_of(["load [N]", *(f"velocity of {100 * q:g} % [m/s]" for q in shares)], rows)


def log_crossings(axis: Array, excess: Array) -> tuple[Array, Array, Groups]:
    """First place along an axis where an excess (..., m) rises through 0, each of shape (...).

    The axis (m,) are velocities [m/s] or loads [N], beyond which the excess goes on as a power.
    Returned are the logarithm of the place, the slope of the excess over the logarithm of the axis
    there, and the number of the value of the axis that follows.
    """
    x, rising = np.log(axis), np.maximum.accumulate(excess, axis=-1)
    right = np.clip(np.sum(rising < 0, axis=-1), 1, len(x) - 1)
    low, high = (
        np.take_along_axis(rising, number[..., None], axis=-1)[..., 0]
        for number in (right - 1, right)
    )
    slope = np.maximum((high - low) / (x[right] - x[right - 1]), LEAST_SLOPE)
    return x[right - 1] - low / slope, slope, right


def log_boundary(ensemble: Ensemble, inputs: Array, loads: Axis) -> tuple[Array, Array]:
    """Logarithm of the critical velocity by draw and load, and its standard error."""
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excess(inputs, loads, velocities)
    log_velocities, slope, right = log_crossings(velocities, excess.values)
    error = np.take_along_axis(excess.error, right[..., None], axis=-1)[..., 0]
    return log_velocities, error / slope

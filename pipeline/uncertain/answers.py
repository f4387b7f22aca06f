"""Probability of severe wear by draws, and their boundary."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from pipeline.analysis.model_error import Scatter
from pipeline.analysis.transition import LEAST_SLOPE
from pipeline.uncertain.emulator import Groups
from pipeline.uncertain.ensemble import Axis, Ensemble, Excess
from pipeline.uncertain.inputs import Draws, prior
from tribo.types import Array

STEPS = 41
"""Velocities or loads among which a boundary is sought."""


def draws_of(ensemble: Ensemble, draws: Draws | None) -> Draws:
    """The draws given, without those of the rig, which stand last; else draws of the prior."""
    if draws is None:
        return prior(ensemble.unknown, ensemble.design.seed + 1)
    return replace(draws, inputs=draws.inputs[:, : len(ensemble.unknown)])


_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
_APART = 0.01  # step of the excess over which the slope of a probability is taken
_NO_SCATTER = 1e-9  # in ln(velocity)
_SHARES = (np.arange(400) + 0.5) / 400
_DISTANCES = np.linspace(-3.0, 3.0, 6001)  # in ln(velocity)
_WIDER, _AT_ONCE = 0.8, 2**12


def probability_of(
    excess: Excess, draws: Draws, scatter: Scatter | None = None, slope: Array | float = 1.0
) -> tuple[float, float]:
    """Probability that the excess of draws (n,) is above 0, and its standard error.

    With a scatter of ln(velocity) it is the probability that the next run is severe; the slope is
    d ln(rise) over d ln(velocity) by draw (n,). What neighbours share is taken as shared by all
    draws, which errs to the safe side.
    """
    by_draw, density = run_probability(excess, scatter, slope)
    probability = float(np.clip(draws.mean(by_draw), 0.0, 1.0))
    by_draws = math.sqrt(float(np.sum((draws.weights * (by_draw - probability)) ** 2)))
    by_samples = float(draws.mean(density * excess.shared))
    return probability, math.hypot(by_draws, by_samples)


def run_probability(
    excess: Excess, scatter: Scatter | None, slope: Array | float
) -> tuple[Array, Array]:
    """Probability that the next run is severe by draw (n,), and its slope over the excess."""
    if scatter is None or scatter.below(np.array(_NO_SCATTER)) == 1:
        normal = np.exp(-0.5 * (excess.values / excess.error) ** 2) / math.sqrt(2 * math.pi)
        return excess.probability, normal / excess.error
    slopes = np.broadcast_to(slope, excess.values.shape)
    by_draw, density = np.empty((2, len(slopes)))
    quantiles = np.interp(_SHARES, scatter.below(_DISTANCES), _DISTANCES)
    # Where the error is the wider of the two, over runs; else over errors.
    is_wide = excess.error > _WIDER * slopes * quantiles[np.searchsorted(_SHARES, 0.84)]
    for rows in np.array_split(np.flatnonzero(is_wide), 1 + is_wide.sum() // _AT_ONCE):
        off = excess.values[rows, None] + slopes[rows, None] * quantiles
        z = off / excess.error[rows, None]
        by_draw[rows] = ndtr(z).mean(axis=1)
        normal = np.exp(-0.5 * z**2) / math.sqrt(2 * math.pi)
        density[rows] = normal.mean(axis=1) / excess.error[rows]
    rows = np.flatnonzero(~is_wide)
    off = excess.values[rows, None] + excess.error[rows, None] * _NODES
    apart = off[..., None] + np.array([-_APART, 0.0, _APART])
    shares = scatter.below(apart / slopes[rows, None, None])
    below, by_draw[rows], above = np.einsum("nkj,k->jn", shares, _WEIGHTS)
    density[rows] = (above - below) / (2 * _APART)
    return by_draw, density


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


def line_turns(x: Array, lines: Array) -> tuple[Array, Array]:
    """Signs of turns between values of an axis (+1 to severe wear), and places, each (n, m - 1)."""
    is_severe = lines > 0
    turns = is_severe[:, 1:].astype(int) - is_severe[:, :-1]
    rises = lines[:, 1:] - lines[:, :-1]
    share = -lines[:, :-1] / np.where(turns != 0, rises, 1.0)
    return turns, x[:-1] + np.clip(share, 0.0, 1.0) * np.diff(x)


def log_boundary(ensemble: Ensemble, inputs: Array, loads: Axis) -> tuple[Array, Array]:
    """Logarithm of the critical velocity by draw and load, and its standard error."""
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excess(inputs, loads, velocities)
    log_velocities, slope, right = log_crossings(velocities, excess.values)
    error = np.take_along_axis(excess.error, right[..., None], axis=-1)[..., 0]
    return log_velocities, error / slope

"""Critical velocities and loads of draws: where each draw's wear turns severe or mild."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.analysis.curve import LEAST_SLOPE
from pipeline.uncertain.emulator import Groups
from pipeline.uncertain.ensemble import Axis, Ensemble
from pipeline.uncertain.inputs import Draws, prior
from tribo.types import Array

STEPS = 41
"""Number of velocities or loads at which wear is judged to find a boundary."""


def draws_of(ensemble: Ensemble, draws: Draws | None) -> Draws:
    """Return `draws` without the columns of inputs that belong to the test rig.

    If `draws` is None, the result is draws of the ensemble's prior.
    """
    if draws is None:
        return prior(ensemble.unknown, ensemble.design.seed + 1)
    return replace(draws, inputs=draws.inputs[:, : len(ensemble.unknown)])


def log_crossings(axis: Array, excess: Array) -> tuple[Array, Array, Groups]:
    """Find where `excess`, ln(rise/limit) (..., m), first rises through 0 along an axis.

    The axis (m,) holds velocities [m/s] or loads [N]. Beyond the axis the excess is extrapolated as
    a power law. Returns ln(velocity or load) of the crossing, the slope of the excess over
    ln(axis), and the index of the next axis value, each of shape (...).
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
    """Find where wear changes along n lines of ln(rise/limit), straight between abscissae.

    `x` (m,) are the abscissae, such as ln(velocity), and `lines` (n, m) the values. Returns two
    arrays (n, m − 1) with a value for each interval between abscissae. The first array is 1 if wear
    turns severe, −1 if it turns mild, and 0 without a change. The second is the abscissa of the
    change; without a change its value has no meaning.
    """
    is_severe = lines > 0
    turns = is_severe[:, 1:].astype(int) - is_severe[:, :-1]
    rises = lines[:, 1:] - lines[:, :-1]
    share = -lines[:, :-1] / np.where(turns != 0, rises, 1.0)
    return turns, x[:-1] + np.clip(share, 0.0, 1.0) * np.diff(x)


def log_boundary(ensemble: Ensemble, inputs: Array, loads: Axis) -> tuple[Array, Array]:
    """Logarithm of the critical velocity [m/s] and its standard error, each (n, n_load).

    `inputs` are draws of the unknown inputs, (n, n_unknown).
    """
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excess(inputs, loads, velocities)
    log_velocities, slope, right = log_crossings(velocities, excess.values)
    error = np.take_along_axis(excess.error, right[..., None], axis=-1)[..., 0]
    return log_velocities, error / slope

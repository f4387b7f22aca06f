"""Critical velocities and loads: where wear turns severe or mild, for draws of unknown inputs."""

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
    """Return `draws` with the columns of the ensemble's unknown inputs only.

    Columns for other oils and for the friction of the test rig are removed. If `draws` is None, the
    result is draws of the ensemble's prior.
    """
    if draws is None:
        return prior(ensemble.unknown, ensemble.design.seed + 1)
    return replace(draws, inputs=draws.inputs[:, : len(ensemble.unknown)])


def log_crossings(axis: Array, excess: Array) -> tuple[Array, Array, Groups]:
    """Find where wear first turns severe along an axis: where `excess` (..., m) rises through 0.

    `excess` is ln(rise/limit); the limit is the temperature rise at which wear turns severe. The
    axis (m,) holds velocities [m/s] or loads [N]. Beyond the axis rise/limit is extrapolated as a
    power law. Returns ln(velocity or load) of the crossing, the slope of the excess over ln(axis),
    and the index of the first axis value after the crossing, each of shape (...).
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
    """Return ln(critical velocity [m/s]) and its standard error, by draw and load.

    Both have the shape (n, n_load). The error is that of the logarithm, due to the emulator.
    `inputs` (n, n_unknown) are draws of the unknown inputs [SI], and `loads` are in N.
    """
    velocities = np.geomspace(*ensemble.velocities, STEPS)
    excess = ensemble.excess(inputs, loads, velocities)
    log_velocities, slope, right = log_crossings(velocities, excess.values)
    error = np.take_along_axis(excess.error, right[..., None], axis=-1)[..., 0]
    return log_velocities, error / slope

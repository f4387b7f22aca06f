"""Outputs between the loads of the samples: a spline through those at each load."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import make_interp_spline

from tribo.types import Array

_BEND = 0.02  # of ln(rise), unknown between two loads alone: ten times that of the shipped scenes


def between_loads(loads: Array, rises: Array, load: float) -> tuple[Array, float]:
    """Weights of the outputs at each load by which to interpolate, and its error."""
    x, place = np.log(loads), math.log(load)
    if len(x) == 1:
        return np.ones(1), 0.0
    if len(x) == 2:
        weights = _spline(x, place, 1)
        return weights, _BEND * 4 * float(weights[0] * weights[1])
    weights, rough = _spline(x, place, min(3, len(x) - 1)), _spline(x, place, 1)
    if len(x) > 3:
        near = np.sort(np.argsort(np.abs(x - place))[:3])
        rough = np.zeros(len(x))
        rough[near] = _spline(x[near], place, 2)
    off = np.log(rises) @ (weights - rough)
    return weights, float(np.sqrt(np.mean(off**2)))


def _spline(x: Array, place: float, degree: int) -> Array:
    """Weights of values at nodes by which a spline through them is found at a place."""
    return np.asarray(make_interp_spline(x, np.eye(len(x)), k=degree)(place))

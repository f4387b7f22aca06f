"""Points about which the rise grows so slowly with the velocity that its errors count severalfold.

The error of a boundary velocity is that of the rise over the exponent n of rise ∝ Vⁿ. Presets were
tried down to n = 0.3. Below it, as under smooth and heavily worn balls, `standard` was 5 to 8 % off
in velocity, beyond its 3 %, and `draft` 11 to 21 %, beyond its 8 %.

One point is not enough to know n, since wear widens the contact at a higher velocity. So n follows
from its neighbours along the velocity, where a sweep is read.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import entry_dims
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.scenes import planes, stacked
from pipeline.sweep.conditions import Conditions
from tribo import CRITERIA
from tribo.types import Array

SLOWEST = 0.3
"""Exponent of the rise over the velocity down to which presets keep what they promise."""

WORDS = (
    "the rise grows more slowly than the velocity to the power of 0.3, so that the boundary "
    "velocity errs two to three times as much as the preset promises; ask for an accuracy"
)
_APART = 1.1  # least ratio of velocities over which an exponent is taken


def slow_rise(ds: xr.Dataset) -> xr.DataArray:
    """Points of a sweep whose rise grows slowly with the velocity; none where that is not known.

    It is the rise by friction, between bodies of equal temperature.
    """
    parts = [_of_one(scene) for scene in planes(ds)]
    axes = [ds[name] for name in entry_dims(ds)]
    return stacked(parts, axes) if parts else xr.zeros_like(ds["status"], bool)


def _of_one(ds: xr.Dataset) -> xr.DataArray:
    """Those of one scene."""
    stored = attributes_of(ds).get("conditions") or {}
    kind, share = stored.get("criterion", "share"), stored.get("failing_share") or 0.0
    plain = Conditions(1.0, 300.0, None, share, criterion=kind if kind in CRITERIA else "share")
    rise = decisive_rise(ds, plain)
    velocities = rise["velocity"].values
    slow = np.apply_along_axis(lambda row: exponents(velocities, row) < SLOWEST, -1, rise.values)
    return rise.copy(data=slow)


def exponents(x: Array, y: Array) -> Array:
    """Exponent d ln(y)/d ln(x) at each point, between neighbours that lie far enough apart.

    NaN where y is not known, or where there are no such neighbours.

    Examples
    --------
    >>> x = np.array([1.0, 2.0, 2.01, 4.0])
    >>> exponents(x, np.array([10.0, 20.0, np.nan, 20.0])).round(2)
    array([1. , 0.5, nan, 0. ])
    """
    result = np.full(x.shape, math.nan)
    (known,) = np.nonzero((x > 0) & np.isfinite(y) & (y > 0))
    log_x, log_y = np.log(x[known]), np.log(y[known])
    least = math.log(_APART)
    for place, here in zip(known, log_x, strict=True):
        low = max(int(np.searchsorted(log_x, here - least, "right")) - 1, 0)
        high = min(int(np.searchsorted(log_x, here + least)), len(known) - 1)
        if log_x[high] - log_x[low] >= least:
            result[place] = (log_y[high] - log_y[low]) / (log_x[high] - log_x[low])
    return result

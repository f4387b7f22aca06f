"""The band of a boundary over several random surfaces: quantiles, mean and spread.

Where a surface has no transition within the sweep, its transition lies above all of the sweep's
velocities (or loads) if wear is mild throughout, and below them if it is severe from the lowest.
Quantiles count it there, and are known as long as they fall within the sweep. A mean is given only
where every surface crosses: the mean of those that do would be biased towards the sweep's middle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from tribo.types import Array

CROSSES, MILD, SEVERE, UNKNOWN = range(4)
"""Values of the variables ``outcome_at_load`` and ``outcome_at_velocity``."""

OUTCOMES = {
    CROSSES: "crosses",
    MILD: "mild throughout",
    SEVERE: "severe from the lowest",
    UNKNOWN: "not known yet",
}
"""What they mean, in words."""

BAND = (0.1, 0.5, 0.9)
"""Shares of the surfaces whose transition lies lower: lower end, middle and upper end."""


def with_band(boundaries: xr.Dataset, variant: str) -> xr.Dataset:
    """Add quantiles, mean, spread and counts to the boundaries of several surfaces or samples.

    Parameters
    ----------
    boundaries : Dataset
        Boundaries with ``critical_velocity(realization, load)``,
        ``critical_load(realization, velocity)`` and the outcomes of each.
    variant : str
        Dimension of the surfaces or samples.
    """
    found = boundaries.assign_coords(
        quantile=("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
    )
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        outcome = boundaries[f"outcome_at_{axis}"].transpose(variant, axis).values
        values = boundaries[name].transpose(variant, axis).values
        unit, count = {"units": boundaries[name].attrs["units"]}, {"units": "1"}
        columns = [
            np.select([why == MILD, why == SEVERE, why == UNKNOWN], [np.inf, -np.inf, np.nan], at)
            for at, why in zip(values.T, outcome.T, strict=True)
        ]
        of_all = [np.mean(c) if np.isfinite(c).all() else math.nan for c in _known(columns)]
        spread = [
            np.std(c, ddof=1) if len(c) > 1 and np.isfinite(c).all() else math.nan
            for c in _known(columns)
        ]
        quantiles = [[quantile(c, share) for c in columns] for share in BAND]
        crossing, known = (outcome == CROSSES).sum(axis=0), (outcome != UNKNOWN).sum(axis=0)
        found = found.assign(
            {
                f"{name}_mean": (axis, of_all, unit | {"long_name": "mean over the surfaces"}),
                f"{name}_spread": (axis, spread, unit | {"long_name": "their standard deviation"}),
                f"{name}_quantile": (
                    ("quantile", axis),
                    quantiles,
                    unit | {"long_name": "that a share of the surfaces stays below"},
                ),
                f"crossing_at_{axis}": (
                    axis,
                    crossing,
                    count | {"long_name": "surfaces that cross"},
                ),
                f"known_at_{axis}": (
                    axis,
                    known,
                    count | {"long_name": "surfaces whose outcome is known"},
                ),
            }
        )
    return found


def _known(columns: Sequence[Array]) -> list[Array]:
    """Leave out unknown values from each column; NaN alone where all are unknown."""
    return [c[~np.isnan(c)] if not np.isnan(c).all() else np.array([math.nan]) for c in columns]


def quantile(values: Array, share: float) -> float:
    """Value that a share of all stays below, linear between them; infinite ones beyond the rest.

    Parameters
    ----------
    values : ndarray
        Values, also infinite ones; NaN is left out.
    share : float
        Share of the values that lie lower, from 0 to 1.

    Returns
    -------
    float
        The quantile; NaN where it does not lie between finite values.

    Examples
    --------
    >>> values = np.array([2.0, 1.0, np.inf, np.nan, -np.inf, 3.0])
    >>> quantile(values, 0.5), quantile(values, 0.375), quantile(values, 0.9)
    (2.0, 1.5, nan)
    """
    ranked = np.sort(values[~np.isnan(values)])
    if not ranked.size:
        return math.nan
    place = share * (len(ranked) - 1)
    low, high = ranked[math.floor(place)], ranked[math.ceil(place)]
    if not (np.isfinite(low) and np.isfinite(high)):
        return math.nan
    return float(low + (place - math.floor(place)) * (high - low))

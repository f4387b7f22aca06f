"""The band of a boundary over several random surfaces: quantiles, mean and spread.

Where a surface has no transition within the sweep, its transition lies above all of the sweep's
velocities (or loads) if wear is mild throughout, and below them if it is severe throughout.
Quantiles count it there, and are known as long as they fall within the sweep and do not depend on
where transitions beyond computed points lie. A mean is given only
where every surface crosses: the mean of those that do would be biased towards the sweep's middle.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from pipeline.analysis.transition import ABOVE, BELOW, CROSSES, MILD, SEVERE
from tribo.types import Array

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
    with_quantiles = boundaries.assign_coords(
        quantile=("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
    )
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        outcome = boundaries[f"outcome_at_{axis}"].transpose(variant, axis).values
        values = boundaries[name].transpose(variant, axis).values
        unit, count = {"units": boundaries[name].attrs["units"]}, {"units": "1"}
        computed = [
            boundaries[f"computed_{end}_at_{axis}"].transpose(variant, axis).values
            for end in ("from", "to")
        ]
        crossing = (outcome == CROSSES).sum(axis=0)
        counts = np.isin(outcome, (CROSSES, MILD, SEVERE)).sum(axis=0)
        rows = zip(values.T, outcome.T, *(bound.T for bound in computed), strict=True)
        ends = [_ends(*row) for row in rows]
        all_cross = [np.isfinite(low).all() and (low == high).all() for low, high in ends]
        several = list(zip(ends, all_cross, strict=True))
        of_all = [np.mean(low) if crosses else math.nan for (low, _), crosses in several]
        spread = [
            np.std(low, ddof=1) if crosses and len(low) > 1 else math.nan
            for (low, _), crosses in several
        ]
        quantiles = [[quantile(*bounds, share) for bounds in ends] for share in BAND]
        with_quantiles = with_quantiles.assign(
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
                    counts,
                    count | {"long_name": "surfaces whose outcome is known"},
                ),
            }
        )
    return with_quantiles


def _ends(at: Array, outcome: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Least and greatest place that each transition may have, of those of which any is known.

    One above what was computed may lie anywhere there, and one below likewise.
    """
    infinite = np.full(at.shape, np.inf)
    why = [outcome == kind for kind in (CROSSES, MILD, SEVERE, ABOVE, BELOW)]
    low = np.select(why, [at, infinite, -infinite, last, -infinite], math.nan)
    high = np.select(why, [at, infinite, -infinite, infinite, first], math.nan)
    is_finite = ~np.isnan(low)
    return (low[is_finite], high[is_finite]) if is_finite.any() else (np.array([math.nan]),) * 2


def quantile(low: Array, high: Array, share: float) -> float:
    """Value that a share of all stays below, linear between them.

    Parameters
    ----------
    low, high : ndarray
        Least and greatest that each value may be, infinite where beyond the rest.
    share : float
        Share of the values that lie lower, from 0 to 1.

    Returns
    -------
    float
        The quantile; NaN where it does not lie between finite values, or is not the same whatever
        the values are.

    Examples
    --------
    >>> values = np.array([2.0, 1.0, np.inf, -np.inf, 3.0])
    >>> quantile(values, values, 0.5), quantile(values, values, 0.375)
    (2.0, 1.5)
    >>> beyond = np.array([2.0, 1.0, 2.5, -np.inf, 3.0]), np.array([2.0, 1.0, np.inf, -np.inf, 3.0])
    >>> quantile(*beyond, 0.5), quantile(*beyond, 0.75)
    (2.0, nan)
    """
    place = share * (len(low) - 1)
    below, above = math.floor(place), math.ceil(place)
    ranked, greatest = np.sort(low), np.sort(high)
    ends = ranked[[below, above]]
    if not np.isfinite(ends).all() or (ends != greatest[[below, above]]).any():
        return math.nan
    return float(ends[0] + (place - below) * (ends[1] - ends[0]))

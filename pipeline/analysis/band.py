"""The band of a boundary over several random surfaces: quantiles, mean and spread.

A surface may have no transition within the sweep. If wear is mild throughout, its transition lies
above all velocities (or loads); if severe throughout, below. Quantiles count it there. They are
known where they fall within the sweep and do not depend on where such transitions lie. A mean is
given only if every surface has a transition: else it would be biased towards the sweep's middle.
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

    The variant is their dimension.
    """
    shares = ("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
    with_quantiles = boundaries.assign_coords(quantile=shares)
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        outcome, unit = boundaries[f"outcome_at_{axis}"], boundaries[name].attrs["units"]
        mean, spread, quantiles = xr.apply_ufunc(
            _band_of,
            boundaries[name],
            outcome,
            boundaries[f"computed_from_at_{axis}"],
            boundaries[f"computed_to_at_{axis}"],
            input_core_dims=[[variant]] * 4,
            output_core_dims=[[], [], ["quantile"]],
            vectorize=True,
        )
        crossing = (outcome == CROSSES).sum(variant)
        certain = outcome.isin((CROSSES, MILD, SEVERE)).sum(variant)
        columns = {
            f"{name}_mean": (mean, unit, "mean over the surfaces"),
            f"{name}_spread": (spread, unit, "their standard deviation"),
            f"{name}_quantile": (
                quantiles.transpose(..., "quantile", axis),
                unit,
                "that a share of the surfaces stays below",
            ),
            f"crossing_at_{axis}": (crossing, "1", "surfaces that cross"),
            f"known_at_{axis}": (certain, "1", "surfaces whose outcome is known"),
        }
        for column, (values, units, words) in columns.items():
            attrs = {"units": units, "long_name": words}
            with_quantiles[column] = values.dims, values.values, attrs
    return with_quantiles


def middle_of(boundaries: xr.Dataset, name: str) -> xr.DataArray:
    """A critical velocity or load: of several surfaces the one that half of them stay below."""
    several = f"{name}_quantile" in boundaries
    return boundaries[f"{name}_quantile"].sel(quantile=0.5) if several else boundaries[name]


def _band_of(
    places: Array, outcomes: Array, first: Array, last: Array
) -> tuple[float, float, Array]:
    """Mean, spread and quantiles of the transitions of several surfaces along one line."""
    low, high = _ends(places, outcomes, first, last)
    all_cross = np.isfinite(low).all() and (low == high).all()
    mean = float(np.mean(low)) if all_cross else math.nan
    spread = float(np.std(low, ddof=1)) if all_cross and len(low) > 1 else math.nan
    return mean, spread, np.array([quantile(low, high, share) for share in BAND])


def _ends(places: Array, outcomes: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Least and greatest place that each transition may have, of those of which any is known.

    One above what was computed may lie anywhere there, and one below likewise.
    """
    infinite = np.full(places.shape, np.inf)
    is_kind = [outcomes == kind for kind in (CROSSES, MILD, SEVERE, ABOVE, BELOW)]
    low = np.select(is_kind, [places, infinite, -infinite, last, -infinite], math.nan)
    high = np.select(is_kind, [places, infinite, -infinite, infinite, first], math.nan)
    is_finite = ~np.isnan(low)
    return (low[is_finite], high[is_finite]) if is_finite.any() else (np.array([math.nan]),) * 2


def quantile(low: Array, high: Array, share: float) -> float:
    """Value that a share of all stays below, linear between them.

    Each lies between its least and its greatest, infinite where beyond the rest. NaN where the
    quantile does not lie between finite values, or is not the same whatever the values are.

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

"""Quantiles of the temperature over the contact area, and how they differ between realizations.

Wear becomes severe where more than a given share of the real contact area is hotter than the
critical temperature. An equivalent condition, of a smooth quantity, is that the quantile of the
temperature that this share exceeds lies above the critical temperature.

In each realization of a rough surface, a few summits carry much of the load. The variation between
realizations is estimated from a single contact by a jackknife (Efron & Stein, Ann. Statist. 9,
1981): the area is divided into groups, and each value θ is recomputed without each group g in turn.
With n groups the variance of θ is (n − 1)/n Σ (θ_g − mean of θ_g)².
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tribo.errors import InputError, require_number
from tribo.types import Array, Indices, Mask

QUANTILES: tuple[float, ...] = (
    0.0, 0.01, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75,
    0.8, 0.825, 0.85, 0.875, 0.89, 0.9, 0.91, 0.925, 0.95, 0.975, 0.99, 0.999, 1.0,
)  # fmt: skip
"""Quantiles of the temperature that are stored: shares of the contact area that are cooler."""
GROUPS = 8
"""Number of groups of elements."""


def contact_quantiles(rise: Array, contact: Mask) -> Array:
    """Quantiles of the temperature rise over the contact area [K], one for each of `QUANTILES`.

    Raises an `InputError` if no element is in contact.

    Parameters
    ----------
    rise : ndarray, shape (nx, ny)
        Temperature rise [K].
    contact : ndarray of bool, shape (nx, ny)
        True where the pressure is positive. All elements are of equal area.

    Examples
    --------
    >>> rise = np.arange(11.0)[None, :]
    >>> contact_quantiles(rise, rise >= 0)[QUANTILES.index(0.9)]
    np.float64(9.0)
    """
    if not contact.any():
        raise InputError("no element is in contact; quantiles of the temperature need at least one")
    return sorted_quantiles(np.sort(rise[contact]))


def sorted_quantiles(ordered: Array) -> Array:
    """Quantiles of ascending values, one for each of `QUANTILES`; NaN without values."""
    if not ordered.size:
        return np.full(len(QUANTILES), np.nan)
    positions = np.asarray(QUANTILES) * (ordered.size - 1)
    # Equal to np.quantile, which takes several times as long for this many quantiles.
    quantiles: Array = np.interp(positions, np.arange(ordered.size), ordered)
    return quantiles


def require_share(share: float) -> None:
    """Raise `InputError` unless a share of the contact area is at least 0 and below 1."""
    require_number(critical_area_fraction=share)
    if not 0 <= share < 1:
        raise InputError(
            f"critical area fraction is {share!r}; it must be at least 0 (the maximum "
            "temperature) and below 1"
        )


def rise_exceeded(
    rise_quantiles: Array, share: float, quantiles: Array | tuple[float, ...] = QUANTILES
) -> Array:
    """Rise that exactly a `share` of the contact area exceeds [K]; the inverse of `failed_share`.

    The rise is linear between the quantiles, which are on the last axis of `rise_quantiles`. Raises
    an `InputError` for a share beyond the `quantiles`, the probabilities on that axis.

    Examples
    --------
    >>> rise = np.arange(101.0)[None, :]
    >>> f"{rise_exceeded(contact_quantiles(rise, rise >= 0), share=0.12):.3f}"
    '88.000'
    """
    require_share(share)
    if not quantiles[0] <= 1 - share <= quantiles[-1]:
        raise InputError(
            f"critical area fraction is {share!r}; the stored quantiles allow from "
            f"{1 - quantiles[-1]:g} to {1 - quantiles[0]:g}"
        )
    upper = int(np.clip(np.searchsorted(quantiles, 1 - share), 1, len(quantiles) - 1))
    low, high = quantiles[upper - 1], quantiles[upper]
    weight = (1 - share - low) / (high - low) if high > low else 1.0  # of a single quantile
    rise: Array = (1 - weight) * rise_quantiles[..., upper - 1] + (
        weight * rise_quantiles[..., upper]
    )
    return rise


def failed_share(rise_quantiles: Array, limit: float) -> float:
    """Share of the contact area whose rise exceeds `limit` [K], from quantiles of the rise [K].

    The share is linear between the quantiles.

    Examples
    --------
    >>> failed_share(np.linspace(0.0, 200.0, len(QUANTILES)), 300.0)
    0.0
    >>> rise = np.arange(101.0)[None, :]
    >>> f"{failed_share(contact_quantiles(rise, rise >= 0), limit=88.0):.3f}"
    '0.120'
    """
    return float(1 - np.interp(limit, rise_quantiles, QUANTILES, left=0.0, right=1.0))


class JackknifeQuality(NamedTuple):
    """How well the jackknife of one realization estimates the deviation of realizations.

    Without degrees of freedom it does not: the deviation is unknown.
    """

    freedom: float = GROUPS - 1.0  #: Degrees of freedom of the estimate.
    factor: float = 1.0  #: Standard deviation of realizations over the estimate.


def rises_without_groups(rise: Array, contact: Mask, groups: Indices) -> Array:
    """Quantiles of the rise over the contact without each group of elements in turn [K].

    They have the shape (GROUPS, len(QUANTILES)), and are NaN if a group has all of the contact.
    `groups`, of shape (nx, ny), has the number of each element's group, from 0.
    """
    contact_rise = rise[contact]
    order = np.argsort(contact_rise)
    sorted_rise, sorted_groups = contact_rise[order], groups[contact][order]
    return np.array(
        [sorted_quantiles(sorted_rise[sorted_groups != group]) for group in range(GROUPS)]
    )


def jackknife_error(leave_one_out: Array) -> Array:
    """Relative standard deviation of values, from the values without each group in turn.

    The groups are on the first axis of `leave_one_out`. The result is 0 where the values are 0.

    Examples
    --------
    The mean of eight independent numbers has the standard deviation s/√8:

    >>> numbers = np.array([9.0, 12.0, 8.0, 11.0, 10.0, 13.0, 7.0, 10.0])
    >>> leave_one_out = (numbers.sum() - numbers) / 7
    >>> f"{10 * jackknife_error(leave_one_out):.4f} {numbers.std(ddof=1) / np.sqrt(8):.4f}"
    '0.7071 0.7071'
    """
    count, mean = len(leave_one_out), leave_one_out.mean(axis=0)
    spread = np.sqrt((count - 1) / count * ((leave_one_out - mean) ** 2).sum(axis=0))
    relative: Array = spread / np.where(mean == 0, 1.0, mean)
    return relative

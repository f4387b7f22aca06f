"""Quantiles of the temperature over the contact area, which decide between mild and severe wear.

Wear turns severe where more than a given share of the real contact area is hotter than the
critical temperature. The same thing, but smooth: the quantile of the temperature that this share
exceeds lies above the critical temperature.
"""

from __future__ import annotations

import numpy as np

from tribo.errors import InputError
from tribo.types import Array, Mask

__all__ = ["QUANTILES", "contact_quantiles", "failed_share", "require_share", "rise_exceeded"]


QUANTILES: tuple[float, ...] = (
    0.0, 0.01, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75,
    0.8, 0.825, 0.85, 0.875, 0.89, 0.9, 0.91, 0.925, 0.95, 0.975, 0.99, 0.999, 1.0,
)  # fmt: skip
"""Shares of the contact area that are cooler, at which the temperature is kept."""


def contact_quantiles(rise: Array, contact: Mask) -> Array:
    """Temperature rise that each of `QUANTILES` of the contact area stays below [K].

    Parameters
    ----------
    rise : ndarray, shape (nx, ny)
        Temperature rise [K].
    contact : ndarray of bool, shape (nx, ny)
        Whether the pressure is positive. All elements are of equal area.

    Examples
    --------
    >>> rise = np.arange(11.0)[None, :]
    >>> contact_quantiles(rise, rise >= 0)[QUANTILES.index(0.9)]
    np.float64(9.0)
    """
    if not contact.any():
        raise InputError("nothing is in contact, so there is no temperature to take quantiles of")
    ordered = np.sort(rise[contact])
    places = np.asarray(QUANTILES) * (ordered.size - 1)
    # What np.quantile gives, which for so many quantiles takes several times as long.
    quantiles: Array = np.interp(places, np.arange(ordered.size), ordered)
    return quantiles


def require_share(share: float) -> None:
    """Refuse a share of the contact area that no temperature can be exceeded on."""
    if not 0 <= share < 1:
        raise InputError(
            f"share is {share!r}; it must be at least 0 (the maximum temperature) and below 1"
        )


def rise_exceeded(
    rise_quantiles: Array, share: float, quantiles: Array | tuple[float, ...] = QUANTILES
) -> Array:
    """Rise that just a share of the contact area exceeds [K]: the inverse of `failed_share`.

    Linear between the quantiles.

    Parameters
    ----------
    rise_quantiles : ndarray, shape (..., n_quantile)
        Rise that each quantile of the contact area stays below [K].
    share : float
        Share of the contact area, from 0 (the maximum) to below 1.
    quantiles : ndarray, shape (n_quantile,), optional
        Shares of the contact area that are cooler; `QUANTILES` if not given.

    Raises
    ------
    InputError
        If the share lies outside its range, or outside that of the quantiles.

    Examples
    --------
    >>> rise = np.arange(101.0)[None, :]
    >>> f"{rise_exceeded(contact_quantiles(rise, rise >= 0), share=0.12):.3f}"
    '88.000'
    """
    require_share(share)
    if not quantiles[0] <= 1 - share <= quantiles[-1]:
        raise InputError(
            f"share is {share!r}; the stored quantiles allow from {1 - quantiles[-1]:g} to "
            f"{1 - quantiles[0]:g}"
        )
    above = int(np.clip(np.searchsorted(quantiles, 1 - share), 1, len(quantiles) - 1))
    low, high = quantiles[above - 1], quantiles[above]
    weight = (1 - share - low) / (high - low)
    exceeded: Array = (1 - weight) * rise_quantiles[..., above - 1] + (
        weight * rise_quantiles[..., above]
    )
    return exceeded


def failed_share(rise_quantiles: Array, limit: float) -> float:
    """Share of the contact area whose rise exceeds `limit`, from its quantiles.

    Linear between the quantiles.

    Examples
    --------
    >>> failed_share(np.linspace(0.0, 200.0, len(QUANTILES)), 300.0)
    0.0
    >>> rise = np.arange(101.0)[None, :]
    >>> f"{failed_share(contact_quantiles(rise, rise >= 0), limit=88.0):.3f}"
    '0.120'
    """
    return float(1 - np.interp(limit, rise_quantiles, QUANTILES, left=0.0, right=1.0))

"""Sampling error of one contact: how much its temperatures differ between surface realizations.

In each realization of a rough surface, a few summits carry much of the load. The variation between
realizations is estimated from a single contact by a jackknife (Efron & Stein, Ann. Statist. 9,
1981): the area is divided into groups, and each value θ is recomputed without each group g in turn.
With n groups the variance of θ is (n − 1)/n Σ (θ_g − mean of θ_g)².
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tribo.thermal.quantiles import sorted_quantiles
from tribo.types import Array, Indices, Mask

GROUPS = 8
"""Number of groups of elements."""


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

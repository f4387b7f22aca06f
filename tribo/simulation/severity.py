"""The rise that decides at each point of many: the criterion's, at the worst step of the loading.

It is per unit friction coefficient.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tribo.simulation.conditions import Conditions
from tribo.simulation.corrections import NEEDED
from tribo.simulation.verdict import worst_moment
from tribo.types import Array


def worst_rises(columns: Mapping[str, Any], load: Array | float, conditions: Conditions) -> Array:
    """Temperature rise per unit friction coefficient at the worst step of each point [K], (...).

    It is the rise that the criterion compares with its limit, NaN for a point without a result.
    `columns` has the arrays that `corrected_columns` takes, with the axis of steps after the axes
    of points, ``normal_load`` (..., n_step) [N], and ``quantile`` unless the quantiles are
    `tribo.QUANTILES`. `load` [N] is the full load of each point, (..., 1).
    """
    rises = conditions.criterion.rise(corrected_columns(columns, conditions))
    worst = worst_moment(rises, columns["normal_load"], load)
    deciding: Array = np.take_along_axis(rises, worst[..., None], axis=-1)[..., 0]
    return deciding


def relative_sampling(
    columns: Mapping[str, Any], conditions: Conditions, shares: Array | None = None
) -> Array:
    """Relative deviation of the rise from patch to patch, as each point states it (...).

    It is that of the contact at the end: the criterion's rise with each rise of the contact lifted
    by its own deviation. `columns` has the rises at the steps, and ``rise_sampling`` and
    ``mean_rise_sampling``; `shares` of cooler area belong to the quantiles, if they are others than
    `tribo.QUANTILES`.
    """
    last = {
        "rise_quantile": columns["rise_quantile"][..., -1, :],
        "mean_rise": columns["mean_rise"][..., -1],
    }
    quantiles = last["rise_quantile"] * (1 + columns["rise_sampling"])
    lifted = {
        "rise_quantile": np.maximum.accumulate(quantiles, axis=-1),
        "mean_rise": last["mean_rise"] * (1 + columns["mean_rise_sampling"]),
    }
    named = {} if shares is None else {"quantile": shares}
    rise, above = (conditions.criterion.rise(one | named) for one in (last, lifted))
    return np.asarray(np.where(rise > 0, above / np.where(rise > 0, rise, 1.0) - 1, 0.0))


def columns_needed(conditions: Conditions) -> tuple[str, ...]:
    """Names of columns that `corrected_columns` needs in addition to the rises."""
    return NEEDED if conditions.corrections else ()


def corrected_columns(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Apply the corrections of `conditions` to rises per unit friction coefficient [K].

    `columns` has ``rise_quantile`` (..., n_quantile), ``mean_rise`` and ``max_rise`` (...), and the
    columns named by `columns_needed`.
    """
    return conditions.corrections.applied(columns) if conditions.corrections else columns

"""Governing rise of many points, each at the worst step of its loading.

Rises are per unit friction coefficient.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tribo.simulation.conditions import Conditions
from tribo.simulation.corrections import NEEDED
from tribo.simulation.verdict import hottest_step
from tribo.types import Array


def worst_rises(columns: Mapping[str, Any], load: Array | float, conditions: Conditions) -> Array:
    """Temperature rise per unit friction coefficient at the worst step of each point [K], (...).

    It is NaN for a point without a result.
    `columns` has the arrays that `corrected_columns` takes, with the axis of steps after the axes
    of points, ``normal_load`` (..., n_step) [N], and ``quantile`` unless the quantiles are
    `tribo.QUANTILES`. `load` [N] is the full load of each point, (..., 1).
    """
    rises = conditions.governing_rise(corrected_columns(columns, conditions))
    worst = hottest_step(rises, columns["normal_load"], load)
    worst_rise: Array = np.take_along_axis(rises, worst[..., None], axis=-1)[..., 0]
    return worst_rise


def relative_sampling(
    columns: Mapping[str, Any], conditions: Conditions, shares: Array | None = None
) -> Array:
    """Relative deviation of the governing rise between surface realizations (...).

    It is estimated at the last step: each quantile of the rise is increased by its own deviation,
    and the governing rise computed again. It is NaN where the deviations are infinite, which means
    that they are unknown. `columns` has the rises at the steps and ``rise_realization_std``;
    `shares` are the probabilities of the quantiles if these are not `tribo.QUANTILES`.
    """
    quantiles, deviations = columns["rise_quantile"][..., -1, :], columns["rise_realization_std"]
    deviations = np.where(np.isinf(deviations), np.nan, deviations)
    lifted = np.maximum.accumulate(quantiles * (1 + deviations), axis=-1)
    probabilities = {} if shares is None else {"quantile": shares}
    rise, lifted_rise = (
        conditions.governing_rise({"rise_quantile": rise_quantile} | probabilities)
        for rise_quantile in (quantiles, lifted)
    )
    return np.asarray(np.where(rise > 0, lifted_rise / np.where(rise > 0, rise, 1.0) - 1, 0.0))


def columns_needed(conditions: Conditions) -> tuple[str, ...]:
    """Names of columns that `corrected_columns` needs in addition to the rises."""
    return NEEDED if conditions.corrections else ()


def corrected_columns(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Apply the corrections of `conditions` to rises per unit friction coefficient [K].

    `columns` has ``rise_quantile`` (..., n_quantile), ``mean_rise`` and ``max_rise`` (...), and the
    columns named by `columns_needed`.
    """
    return conditions.corrections.apply(columns) if conditions.corrections else columns

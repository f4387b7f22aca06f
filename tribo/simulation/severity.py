"""The rise that decides at each point of many: the criterion's, at the worst step of the loading.

It is per unit friction coefficient. Where the disk's bulk is Δ warmer than the pin's, rises count
from the colder body, at the ratio Δ/µ, and are never negative.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

import numpy as np

from tribo.errors import InputError
from tribo.simulation import verdict as one_point
from tribo.simulation.conditions import Conditions
from tribo.simulation.corrections import NEEDED
from tribo.simulation.verdict import Verdict, above_colder, worst_moment
from tribo.types import Array


def worst_rises(columns: Mapping[str, Any], load: Array | float, conditions: Conditions) -> Array:
    """Temperature rise per unit friction coefficient at the worst step of each point [K], (...).

    It is the rise that the criterion compares with its limit, NaN for a point without a result.
    `columns` has the arrays that `rises_above_colder` takes, with the axis of steps after the axes
    of points, ``normal_load`` (..., n_step) [N], and ``quantile`` unless the quantiles are
    `tribo.QUANTILES`. `load` [N] is the full load of each point, (..., 1).
    """
    rises = conditions.criterion.rise(rises_above_colder(columns, conditions))
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


def verdict(columns: Mapping[str, Array], load: float, conditions: Conditions) -> Verdict:
    """Mild or severe wear at a point, from its values at each step and its full load [N].

    `columns` has the arrays that `worst_rises` takes, for one point.
    """
    if conditions.bulk_ratio:
        require_bulks(columns, conditions)
    return one_point.verdict(columns, load, conditions)


def rises_above_colder(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Apply corrections to rises, and convert them to rises above the colder body [K].

    `columns` has ``rise_quantile`` (..., n_quantile), ``mean_rise`` and ``max_rise`` (...), which
    are rises above the pin's bulk per unit friction coefficient [K], and the columns named by
    `columns_needed`. The result has the same columns; its rises are also per unit friction
    coefficient.
    """
    columns = corrected_columns(columns, conditions)
    if conditions.bulk_ratio:
        require_bulks(columns, conditions)
    return above_colder(columns, conditions.bulk_ratio)


def columns_needed(conditions: Conditions) -> tuple[str, ...]:
    """Names of columns that `rises_above_colder` needs in addition to the rises."""
    unequal = ("bulk_rise_quantile", "mean_bulk_response") if conditions.bulk_ratio else ()
    return unequal + (NEEDED if conditions.corrections else ())


def corrected_columns(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Apply the corrections of `conditions` to all rises in `columns`."""
    return conditions.corrections.applied(columns) if conditions.corrections else columns


def require_bulks(columns: Container[Any], conditions: Conditions) -> None:
    """Raise an `InputError` if the bodies' bulk temperatures differ, but were simulated as equal.

    `columns` are the stored variables. Only a simulation for unequal bulk temperatures has stored
    the response to their difference.
    """
    kept = "bulk_rise_quantile" in columns or "mean_bulk_response" in columns
    if conditions.disk_temperature is None or kept:
        return
    pin, disk = conditions.bulk_temperature, conditions.disk_temperature
    raise InputError(
        f"bulk_temperature is {pin - 273.15:.6g} °C of the pin and {disk - 273.15:.6g} °C of the "
        "disk; the sweep was computed for bodies of one bulk temperature: give one, or run the "
        "scene into another store with bulk = { pin = ..., disk = ... } under [temperature]"
    )

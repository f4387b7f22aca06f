"""The verdict on one point: wear is severe if the contact is too hot, bulk + µ r > critical.

r is the temperature rise that the critical area fraction of the contact exceeds, such as a tenth.
It is per unit friction coefficient, at the time at which it is highest; µ is the friction
coefficient.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tribo.errors import InputError
from tribo.simulation.conditions import Conditions
from tribo.simulation.corrections import NEEDED
from tribo.simulation.point_warnings import PointWarning
from tribo.thermal import failed_share
from tribo.types import Array, Indices


@dataclass(frozen=True, slots=True)
class Verdict:
    """Mild or severe wear at a point, at its worst time, when the contact is hottest.

    Attributes
    ----------
    is_severe : bool or None
        True if `governing_temperature` is above the critical temperature; None if the critical
        temperature is unknown.
    time : float
        Worst time, from the start of the loading [s].
    governing_temperature : float
        Temperature of the contact that is compared with the critical temperature, such as the
        temperature exceeded on a tenth of the contact [K].
    max_temperature : float
        Highest temperature of the contact [K].
    failed_area_fraction : float or None
        Share of the contact area above the critical temperature; None if that is unknown.
    bulk_temperature : float
        First part of `governing_temperature`: the bulk temperature [K].
    contact_rise : float
        Second part: the rise between two half-spaces, `Conditions.added_rise_fraction` included
        [K].
    added_rise : float
        Third part: the rise added by earlier revolutions [K].
    warnings : tuple of PointWarning
        Reasons for caution about the point, see `tribo.warnings`.

    Examples
    --------
    >>> Verdict(True, 4.0, 425.0, 460.0, 0.2, 298.0, 124.0, 3.0).governing_temperature
    425.0
    """

    is_severe: bool | None
    time: float
    governing_temperature: float
    max_temperature: float
    failed_area_fraction: float | None
    bulk_temperature: float
    contact_rise: float
    added_rise: float
    warnings: tuple[PointWarning, ...] = ()


def allowable_rise(conditions: Conditions) -> float:
    """Temperature rise per unit friction coefficient [K] above which wear is severe.

    It is infinite if the friction coefficient is 0. Raises an `InputError` if the critical
    temperature is not known.
    """
    if conditions.critical_temperature is None:
        raise InputError(
            "critical_temperature is None, and the allowable rise needs it; give one [K]"
        )
    return conditions.limit(conditions.critical_temperature)


def hottest_step(rise: Array, normal_load: Array, load: Array | float) -> Indices:
    """Index of the step with the highest rise among the steps at `load` or above, for each point.

    Without such a step it is the last step. `rise` and `normal_load` [N] have the steps on their
    last axis.
    """
    is_candidate = np.isfinite(rise) & (normal_load >= load)
    step: Indices = np.argmax(np.where(is_candidate, rise, -math.inf), axis=-1)
    return np.where(is_candidate.any(axis=-1), step, rise.shape[-1] - 1)


def verdict(columns: Mapping[str, Array], load: float, conditions: Conditions) -> Verdict:
    """Mild or severe wear at a point, from its columns and its load [N].

    `columns` has arrays by name, with a step on the first axis: ``time`` [s], ``normal_load`` [N],
    and the rises per unit friction coefficient [K] ``mean_rise`` and ``rise_quantile`` (n_step,
    n_quantile). Corrections also need the variables in `tribo.simulation.corrections.NEEDED`.
    """
    corrections = conditions.corrections
    corrected = corrections.apply(columns) if corrections else columns
    rises = conditions.governing_rise(corrected)
    worst = int(hottest_step(rises, corrected["normal_load"], load))
    rise, quantiles = float(rises[worst]), corrected["rise_quantile"][worst]
    contact_temperature = float(
        conditions.contact_temperature(conditions.governing_rise(columns)[worst])
    )
    has_critical = conditions.critical_temperature is not None
    governing_temperature = float(conditions.contact_temperature(rise))
    return Verdict(
        is_severe=rise > allowable_rise(conditions) if has_critical else None,
        time=float(corrected["time"][worst]),
        governing_temperature=governing_temperature,
        max_temperature=float(conditions.contact_temperature(quantiles[-1])),
        failed_area_fraction=failed_share(quantiles, allowable_rise(conditions))
        if has_critical
        else None,
        bulk_temperature=conditions.bulk_temperature,
        contact_rise=contact_temperature - conditions.bulk_temperature,
        added_rise=governing_temperature - contact_temperature,
    )


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

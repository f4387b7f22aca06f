"""The verdict on one point: wear is severe if the contact is too hot, bulk + µ r > critical.

r is the temperature rise that the critical area fraction of the contact exceeds, such as a tenth.
It is per unit friction coefficient, at the time at which it is highest; µ is the friction
coefficient.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tribo.errors import InputError
from tribo.simulation.conditions import Conditions
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
        Third part: the rise added by earlier turns [K].
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
        raise InputError("critical_temperature is None, and a limit needs it; give one [K]")
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

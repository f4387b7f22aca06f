"""The verdict on one point: wear is severe if the contact is too hot, bulk + µ r > critical.

r is the temperature rise of the contact that the criterion compares with its limit
(`tribo.Criterion`), such as the rise exceeded on a tenth of the contact. It is per unit friction
coefficient, at the time at which it is highest; µ is the friction coefficient. If the disk's bulk
is warmer than the pin's by Δ, rises are computed for the ratio Δ/µ. They count from the colder
body, so that they are never negative.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tribo.errors import InputError
from tribo.simulation.corrections import Corrections
from tribo.simulation.friction import Friction
from tribo.thermal import BULK_RATIOS, Criterion, add_bulk_ratio, failed_share
from tribo.types import Array, Indices

RISES = ("max_rise", "mean_rise", "rise_quantile")
"""Names of the rises that change if the bulk temperatures of pin and disk differ."""


@dataclass(frozen=True, slots=True)
class Judging(ABC):
    """Friction, temperatures and corrections, by which wear is judged mild or severe.

    This is a base class. Its subclasses define the property `decisive`, the criterion.
    """

    friction: float  # coefficient
    bulk_temperature: float  # [K], of the pin alone if `disk_temperature` is given
    critical_temperature: float | None = None  # [K]
    disk_temperature: float | None = field(default=None, kw_only=True)  # [K]
    unmodelled_rise: float = field(default=0.0, kw_only=True)  # as a part of the computed rise
    corrections: Corrections | None = field(default=None, kw_only=True)

    @property
    @abstractmethod
    def decisive(self) -> Criterion:
        """Criterion by which wear is judged severe."""

    @property
    def bulk_difference(self) -> float:
        """Bulk temperature of the disk minus that of the pin [K]."""
        disk = self.disk_temperature
        return 0.0 if disk is None else disk - self.bulk_temperature

    @property
    def coldest_bulk_temperature(self) -> float:
        """Bulk temperature of the colder body [K], above which rises are measured."""
        return self.bulk_temperature + min(0.0, self.bulk_difference)

    @property
    def mean_bulk_temperature(self) -> float:
        """Mean of both bodies' bulk temperatures [K], used as the temperature of the oil."""
        return self.bulk_temperature + self.bulk_difference / 2

    @property
    def rise_factor(self) -> float:
        """Factor by which a rise per unit friction is multiplied: µ (1 + `unmodelled_rise`).

        If the bulk temperatures differ, the factor is at least their absolute difference divided by
        the largest of `tribo.thermal.BULK_RATIOS` [K]. So the factor is above 0 even without
        friction, and `bulk_ratio`, the difference divided by the factor, is finite.
        """
        heating = self.friction * (1 + self.unmodelled_rise)
        return max(heating, abs(self.bulk_difference) / BULK_RATIOS[-1])

    @property
    def bulk_ratio(self) -> float:
        """Bulk temperature of the disk minus that of the pin, per unit friction [K].

        It is `bulk_difference` [K] divided by `rise_factor`; 0 if both bulk temperatures are equal.
        """
        difference = self.bulk_difference
        return difference / self.rise_factor if difference else 0.0

    @property
    def friction_law(self) -> Friction:
        """Coefficient of friction and its dependence on velocity."""
        present = self.corrections.friction if self.corrections else Friction()
        return replace(present, coefficient=self.rise_factor)

    def contact_temperature(self, rise: Any) -> Any:
        """Temperature of the contact [K], from one or more rises per unit friction [K]."""
        return self.coldest_bulk_temperature + self.rise_factor * rise

    def limit(self, temperature: float) -> float:
        """Rise per unit friction coefficient above which the contact exceeds a temperature [K]."""
        if self.rise_factor == 0:
            return math.inf
        return (temperature - self.coldest_bulk_temperature) / self.rise_factor

    def temperature_error(self, temperature: float) -> float:
        """Derivative dT/d ln(rise) [K] at a contact `temperature` T [K].

        This derivative times the relative error of the rise is the error of T.
        """
        return temperature - self.coldest_bulk_temperature

    def require_proportional(self) -> None:
        """Raise `InputError` if the rise is not in proportion to the coefficient of friction.

        It is not if the bulk temperatures of pin and disk differ, and friction depends on velocity.
        """
        if self.friction_law.by_velocity and self.bulk_difference:
            raise InputError(
                "friction.by_velocity: the bulk temperatures of pin and disk differ, and then the "
                "rise is not proportional to friction; give one bulk temperature, or one friction"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions(Judging):
    """Conditions that turn a rise per unit friction coefficient into mild or severe wear.

    Attributes
    ----------
    friction : float
        Friction coefficient, at least 0.
    bulk_temperature : float
        Temperature of both bodies far from the contact, or of the pin if they differ [K].
    critical_temperature : float or None
        Temperature above which the lubricant fails [K]; None if it is not known.
    disk_temperature : float or None
        Temperature of the disk far from the contact [K]; None if it equals the pin's.
    unmodelled_rise : float
        Rise that acts beside the model, as a part of the rise by friction that is computed: 0.06
        multiplies it by 1.06. It is above -1.
    corrections : Corrections or None
        Tracks that earlier turns have warmed, and friction that depends on velocity; None without
        corrections.
    criterion : Criterion
        Criterion of severe wear. By default wear is severe if more than a tenth of the contact is
        above the critical temperature.

    Examples
    --------
    >>> Conditions(friction=0.1, bulk_temperature=298.15, critical_temperature=418.15).rise_factor
    0.1
    """

    criterion: Criterion = field(default_factory=Criterion)

    def __post_init__(self) -> None:
        if not 0 <= self.friction < math.inf:
            raise InputError(f"friction is {self.friction!r}; it must be finite and ≥ 0")
        warmest = max(self.bulk_temperature, self.disk_temperature or 0.0)
        if not 0 < self.bulk_temperature < math.inf:
            raise InputError(f"bulk_temperature is {self.bulk_temperature!r} K; it must be above 0")
        if self.disk_temperature is not None and not 0 < self.disk_temperature < math.inf:
            raise InputError(f"disk_temperature is {self.disk_temperature!r} K; it must be above 0")
        if self.critical_temperature is not None and not self.critical_temperature > warmest:
            critical = self.critical_temperature
            raise InputError(
                f"critical_temperature is {critical:g} K ({critical - 273.15:.4g} °C); it must be "
                f"above the bulk temperature, {warmest:g} K ({warmest - 273.15:.4g} °C)"
            )
        if not -1 < self.unmodelled_rise < math.inf:
            raise InputError(
                f"unmodelled_rise is {self.unmodelled_rise!r}; give a share above -1, such as 0.06"
            )
        self.require_proportional()

    @property
    def decisive(self) -> Criterion:
        """Criterion by which wear is judged severe."""
        return self.criterion


@dataclass(frozen=True, slots=True)
class Verdict:
    """Mild or severe wear at a point, at its worst time, when the contact is hottest.

    Attributes
    ----------
    is_severe : bool or None
        True if `decisive_temperature` is above the critical temperature; None if the critical
        temperature is unknown.
    time : float
        Worst time, from the start of the loading [s].
    decisive_temperature : float
        Temperature of the contact that the criterion compares with the critical temperature, such
        as the temperature exceeded on a tenth of the contact [K].
    max_temperature : float
        Highest temperature of the contact [K].
    failed_fraction : float or None
        Share of the contact area above the critical temperature; None if that is unknown.
    bulk_temperature : float
        First part of `decisive_temperature`: the bulk temperature of the colder body [K].
    contact_rise : float
        Second part: the rise between two half-spaces, with its unmodelled part [K].
    added_rise : float
        Third part: the rise added by earlier turns, and by friction that depends on velocity [K].

    Examples
    --------
    >>> Verdict(True, 4.0, 425.0, 460.0, 0.2, 298.0, 124.0, 3.0).decisive_temperature
    425.0
    """

    is_severe: bool | None
    time: float
    decisive_temperature: float
    max_temperature: float
    failed_fraction: float | None
    bulk_temperature: float
    contact_rise: float
    added_rise: float


def rise_limit(conditions: Judging) -> float:
    """Temperature rise per unit friction coefficient [K] above which wear is severe.

    It is infinite if the friction coefficient is 0 and both bulk temperatures are equal. Raises an
    `InputError` if the critical temperature is not known.
    """
    if conditions.critical_temperature is None:
        raise InputError("critical_temperature is None, and a limit needs it; give one [K]")
    return conditions.limit(conditions.critical_temperature)


def worst_moment(rise: Array, normal_load: Array, load: Array | float) -> Indices:
    """Index of the step with the highest rise among the steps at `load` or above, for each point.

    Without such a step it is the last step. `rise` and `normal_load` [N] have the steps on their
    last axis.
    """
    counts = np.isfinite(rise) & (normal_load >= load)
    step: Indices = np.argmax(np.where(counts, rise, -math.inf), axis=-1)
    return np.where(counts.any(axis=-1), step, rise.shape[-1] - 1)


def above_colder(columns: Mapping[str, Any], bulk_ratio: float) -> Mapping[str, Any]:
    """Convert columns of rises above the pin's bulk to rises above the colder body's bulk [K].

    Rises are per unit friction, as is `bulk_ratio`: bulk temperature of disk minus pin [K].
    """
    if bulk_ratio == 0:
        return columns
    above_pin = add_bulk_ratio(columns, bulk_ratio)
    pin = max(0.0, -bulk_ratio)
    return {**above_pin, **{name: above_pin[name] + pin for name in RISES if name in above_pin}}


def verdict(columns: Mapping[str, Array], load: float, conditions: Judging) -> Verdict:
    """Mild or severe wear at a point, from its columns and its load [N].

    `columns` has arrays by name, with a step on the first axis: ``time`` [s], ``normal_load`` [N],
    and the rises above the pin's bulk per unit friction coefficient [K] ``mean_rise`` and
    ``rise_quantile`` (n_step, n_quantile). Corrections also need the variables in
    `tribo.simulation.corrections.NEEDED`. Unequal bulk temperatures also need
    ``mean_bulk_response`` and ``bulk_rise_quantile``.
    """
    ratio, bulk = conditions.bulk_ratio, conditions.coldest_bulk_temperature
    alone = above_colder(columns, ratio)
    parts = conditions.corrections
    together = above_colder(parts.applied(columns), ratio) if parts else alone
    rises = conditions.decisive.rise(together)
    worst = int(worst_moment(rises, together["normal_load"], load))
    rise, quantiles = float(rises[worst]), together["rise_quantile"][worst]
    of_contact = float(conditions.contact_temperature(conditions.decisive.rise(alone)[worst]))
    known = conditions.critical_temperature is not None
    decisive = float(conditions.contact_temperature(rise))
    return Verdict(
        is_severe=Criterion.is_severe(rise, rise_limit(conditions)) if known else None,
        time=float(together["time"][worst]),
        decisive_temperature=decisive,
        max_temperature=float(conditions.contact_temperature(quantiles[-1])),
        failed_fraction=failed_share(quantiles, rise_limit(conditions)) if known else None,
        bulk_temperature=bulk,
        contact_rise=of_contact - bulk,
        added_rise=decisive - of_contact,
    )

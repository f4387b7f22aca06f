"""The conditions by which wear is judged: friction, temperatures, corrections and a criterion."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from tribo.errors import InputError
from tribo.loading import MeasuredLoad, Ramp, Stages
from tribo.simulation.corrections import Corrections
from tribo.simulation.friction import Friction
from tribo.thermal import BULK_RATIOS, Criterion
from tribo.types import Array

_NUMBERS = (
    "friction", "bulk_temperature", "disk_temperature", "critical_temperature", "unmodelled_rise"
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Conditions:
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

    Raises
    ------
    InputError
        If a value is out of range, or if friction varies, but the bodies have unequal bulk
        temperatures.

    Examples
    --------
    >>> oil = Conditions(friction=0.1, bulk_temperature=298.15, critical_temperature=418.15)
    >>> replace(oil, friction=0.12, criterion=Criterion("mean")).rise_factor
    0.12
    """

    friction: float
    bulk_temperature: float
    critical_temperature: float | None = None
    disk_temperature: float | None = field(default=None, kw_only=True)
    unmodelled_rise: float = field(default=0.0, kw_only=True)
    corrections: Corrections | None = field(default=None, kw_only=True)
    criterion: Criterion = field(default_factory=Criterion, kw_only=True)

    def __post_init__(self) -> None:
        for name in _NUMBERS:
            value = getattr(self, name)
            if value is not None and (isinstance(value, Iterable) or not math.isfinite(value)):
                raise InputError(f"{name} is {value!r}; it must be one finite number here")
        if self.friction < 0:
            raise InputError(f"friction is {self.friction!r}; it must be finite and ≥ 0")
        warmest = max(self.bulk_temperature, self.disk_temperature or 0.0)
        if self.bulk_temperature <= 0:
            raise InputError(f"bulk_temperature is {self.bulk_temperature!r} K; it must be above 0")
        if self.disk_temperature is not None and self.disk_temperature <= 0:
            raise InputError(f"disk_temperature is {self.disk_temperature!r} K; it must be above 0")
        if self.critical_temperature is not None and self.critical_temperature <= warmest:
            critical = self.critical_temperature
            raise InputError(
                f"critical_temperature is {critical:g} K ({critical - 273.15:.4g} °C); it must be "
                f"above the bulk temperature, {warmest:g} K ({warmest - 273.15:.4g} °C)"
            )
        if self.unmodelled_rise <= -1:
            raise InputError(
                f"unmodelled_rise is {self.unmodelled_rise!r}; give a share above -1, such as 0.06"
            )
        if self.has_friction_curve and self.bulk_difference:
            raise InputError(
                "friction.by_velocity: the bulk temperatures of pin and disk differ, and then the "
                "rise is not proportional to friction; give one bulk temperature, or one friction"
            )

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
        """Dependence of friction on velocity, as factors on the coefficient `friction`."""
        return self.corrections.friction if self.corrections else Friction()

    @property
    def has_friction_curve(self) -> bool:
        """True if friction depends on the velocity."""
        return bool(self.friction_law.by_velocity)

    def friction_factor(self, velocity: Array | float) -> Array:
        """Factor by which to multiply the coefficient `friction`, at sliding velocities [m/s].

        It is 1 unless friction depends on velocity. The shape is that of `velocity`.
        """
        factor: Array = self.friction_law.at(velocity)
        return factor

    def friction_at(self, velocity: float) -> float:
        """Coefficient of friction at a sliding velocity [m/s]."""
        return self.friction * float(self.friction_factor(velocity))

    def contact_temperature(self, rise: Any) -> Any:
        """Temperature of the contact [K], from one or more rises per unit friction [K]."""
        return self.coldest_bulk_temperature + self.rise_factor * rise

    def limit(self, temperature: float) -> float:
        """Rise per unit friction coefficient above which the contact exceeds a temperature [K]."""
        if self.rise_factor == 0:
            return math.inf
        return (temperature - self.coldest_bulk_temperature) / self.rise_factor

    def replace_friction(self, friction: float | None) -> Conditions:
        """The conditions with a friction coefficient that was measured at one point.

        It also replaces a curve of friction over velocity. With None nothing changes.
        """
        if friction is None:
            return self
        corrections = self.corrections and replace(self.corrections, friction=Friction())
        return replace(self, friction=friction, corrections=corrections)

    def under(self, loading: Ramp | Stages | MeasuredLoad) -> Conditions:
        """The conditions with the load history of `loading` added to their corrections, if any."""
        corrections = self.corrections and self.corrections.under(loading)
        return self if corrections == self.corrections else replace(self, corrections=corrections)

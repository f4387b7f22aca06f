"""The conditions by which wear is judged: friction, temperatures and corrections."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from tribo.errors import InputError, require_instance, require_number
from tribo.loading import MeasuredLoad, Ramp, Stages
from tribo.simulation.corrections import Corrections
from tribo.thermal import QUANTILES, require_share, rise_exceeded

_NUMBERS = (
    "friction", "bulk_temperature", "critical_temperature", "added_rise_fraction",
    "critical_area_fraction",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions that turn a rise per unit friction coefficient into mild or severe wear.

    Attributes
    ----------
    friction : float
        Friction coefficient, at least 0.
    bulk_temperature : float
        Temperature of both bodies far from the contact [K].
    critical_temperature : float or None
        Temperature above which the lubricant fails [K]; None if it is not known.
    added_rise_fraction : float
        Rise due to effects outside the model, as a fraction of the computed rise by friction: 0.06
        multiplies this by 1.06. It is above -1.
    corrections : Corrections or None
        Warming of the tracks by earlier revolutions; None without any.
    critical_area_fraction : float
        Wear is severe if a larger share of the contact area than this one is above the critical
        temperature. It is at least 0 (the highest temperature decides) and below 1.

    Raises
    ------
    InputError
        If a value is out of range.

    Examples
    --------
    >>> oil = Conditions(friction=0.1, bulk_temperature=298.15, critical_temperature=418.15)
    >>> replace(oil, friction=0.12).rise_factor
    0.12
    """

    friction: float
    bulk_temperature: float
    critical_temperature: float | None = None
    added_rise_fraction: float = field(default=0.0, kw_only=True)
    corrections: Corrections | None = field(default=None, kw_only=True)
    critical_area_fraction: float = field(default=0.1, kw_only=True)

    def __post_init__(self) -> None:
        for name in _NUMBERS:
            value = getattr(self, name)
            if value is None and name == "critical_temperature":
                continue
            require_number(**{name: value})
            if not math.isfinite(value):
                raise InputError(f"{name} is {value!r}; it must be one finite number here")
        if self.corrections is not None:
            require_instance(Corrections, corrections=self.corrections)
        if self.friction < 0:
            raise InputError(f"friction is {self.friction!r}; it must be finite and ≥ 0")
        require_share(self.critical_area_fraction)
        bulk, critical = self.bulk_temperature, self.critical_temperature
        if bulk <= 0:
            raise InputError(f"bulk_temperature is {bulk!r} K; it must be above 0")
        if critical is not None and critical <= bulk:
            raise InputError(
                f"critical_temperature is {critical:g} K ({critical - 273.15:.4g} °C); it must be "
                f"above the bulk temperature, {bulk:g} K ({bulk - 273.15:.4g} °C)"
            )
        if self.added_rise_fraction <= -1:
            raise InputError(
                f"added_rise_fraction is {self.added_rise_fraction!r}; give a fraction above -1, "
                "such as 0.06"
            )

    @property
    def rise_factor(self) -> float:
        """Factor by which a rise per unit friction is multiplied: µ (1 + `added_rise_fraction`)."""
        return self.friction * self.outside_factor

    @property
    def outside_factor(self) -> float:
        """Factor by which effects outside the model multiply a rise."""
        return 1 + self.added_rise_fraction

    def governing_rise(self, columns: Mapping[str, Any]) -> Any:
        """Rise exceeded on the critical area fraction of the contact [K], (...).

        `columns` has ``rise_quantile`` (..., n_quantile) [K], and ``quantile``, their
        probabilities; `tribo.QUANTILES` if not given.
        """
        probabilities = columns.get("quantile", QUANTILES)
        return rise_exceeded(columns["rise_quantile"], self.critical_area_fraction, probabilities)

    def contact_temperature(self, rise: Any) -> Any:
        """Temperature of the contact [K], from one or more rises per unit friction [K]."""
        return self.bulk_temperature + self.rise_factor * rise

    def limit(self, temperature: float) -> float:
        """Rise per unit friction coefficient above which the contact exceeds a temperature [K]."""
        if self.rise_factor == 0:
            return math.inf
        return (temperature - self.bulk_temperature) / self.rise_factor

    def with_loading(self, loading: Ramp | Stages | MeasuredLoad) -> Conditions:
        """The conditions with the load history of `loading` added to their corrections, if any."""
        corrections = self.corrections and self.corrections.with_loading(loading)
        return self if corrections == self.corrections else replace(self, corrections=corrections)

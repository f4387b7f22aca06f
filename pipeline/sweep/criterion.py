"""The criterion of severe wear: too much of the contact is above the critical temperature.

The contact temperature is that of the bulk and a rise, which is proportional to friction and is
kept at friction 1. With r the rise that just the failing share of the contact area exceeds (the
decisive rise), wear is severe where

    bulk + µ r > critical,  that is  r > (critical − bulk)/µ.

A point counts by its worst moment: where the load is held, r is the highest one from when the
load is reached on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from tribo import InputError, failed_share
from tribo.thermal.quantiles import require_share, rise_exceeded
from tribo.types import Array, Indices

if TYPE_CHECKING:
    import xarray as xr

Rise = TypeVar("Rise", float, Array, "xr.DataArray")


@dataclass(frozen=True, slots=True)
class Conditions:
    """What turns a rise at friction 1 into mild or severe wear, after the simulation.

    Attributes
    ----------
    friction : float
        Friction coefficient, at least 0.
    bulk_temperature : float
        Temperature of both bodies far from the contact [K].
    critical_temperature : float or None
        Temperature above which the lubricant fails [K]; None where it is not known.
    failing_share : float
        Share of the contact area above the critical temperature beyond which wear is severe, from
        0 (Blok's criterion, the maximum temperature) to below 1.

    Raises
    ------
    InputError
        If one lies outside its range.
    """

    friction: float
    bulk_temperature: float
    critical_temperature: float | None
    failing_share: float = 0.1

    def __post_init__(self) -> None:
        for name in ("friction", "bulk_temperature", "critical_temperature", "failing_share"):
            value = getattr(self, name)
            if value is None and name == "critical_temperature":
                continue
            if isinstance(value, Iterable):
                raise InputError(f"{name} is {value!r}; it must be one number here")
            if not math.isfinite(value):
                raise InputError(f"{name} is {value!r}; it must be finite")
        if self.friction < 0:
            raise InputError(f"friction is {self.friction:g}; it must be at least 0")
        if self.bulk_temperature <= 0:
            raise InputError(
                f"bulk_temperature is {self.bulk_temperature:g} K; it must be above 0 K"
            )
        critical = self.critical_temperature
        if critical is not None and critical <= self.bulk_temperature:
            raise InputError(
                f"critical_temperature is {critical:g} K; it must lie above the "
                f"bulk temperature, {self.bulk_temperature:g} K"
            )
        require_share(self.failing_share)

    def known_critical_temperature(self) -> float:
        """Critical temperature [K].

        Raises
        ------
        InputError
            If it is not known.
        """
        if self.critical_temperature is None:
            raise InputError(
                "temperature.critical: the scene does not give it, and this needs it; add it to "
                'the scene, such as critical = "145 degC", or give it here, as '
                "--critical-temperature or critical_temperature"
            )
        return self.critical_temperature

    def changed(
        self,
        friction: float | None = None,
        bulk_temperature: float | None = None,
        critical_temperature: float | None = None,
        share: float | None = None,
    ) -> Conditions:
        """Return the conditions with those that are given in place of their own."""
        given = {
            "friction": friction,
            "bulk_temperature": bulk_temperature,
            "critical_temperature": critical_temperature,
            "failing_share": share,
        }
        return replace(self, **{name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether wear is severe at a point, and what is so at its worst moment.

    Attributes
    ----------
    is_severe : bool or None
        Whether more than the failing share of the contact area is above the critical temperature;
        None where that is not known.
    time : float
        The worst moment, from the start of the ramp [s].
    decisive_temperature : float
        Temperature that just the failing share of the contact area exceeds [K].
    max_temperature : float
        Highest temperature of the contact [K].
    failed_fraction : float or None
        Share of the contact area above the critical temperature; None where that is not known.
    """

    is_severe: bool | None
    time: float
    decisive_temperature: float
    max_temperature: float
    failed_fraction: float | None


def contact_temperature(rise: Rise, conditions: Conditions) -> Rise:
    """Temperature of the contact [K], from its rise at friction 1 [K].

    Examples
    --------
    >>> contact_temperature(1250.0, Conditions(0.1, 298.15, 418.15))
    423.15
    """
    return conditions.bulk_temperature + conditions.friction * rise


def rise_limit(conditions: Conditions) -> float:
    """Decisive rise at friction 1 above which wear is severe [K]; infinite without friction.

    Examples
    --------
    >>> rise_limit(Conditions(0.1, 298.15, 418.15)), rise_limit(Conditions(0.0, 298.15, 418.15))
    (1200.0, inf)
    """
    if conditions.friction == 0:
        return math.inf
    warming = conditions.known_critical_temperature() - conditions.bulk_temperature
    return warming / conditions.friction


def failed_fraction(rise_quantile: Array, conditions: Conditions) -> float:
    """Share of the contact area above the critical temperature.

    Parameters
    ----------
    rise_quantile : ndarray, shape (n_quantile,)
        Rise at friction 1 that each of `tribo.QUANTILES` of the contact area stays below [K].
    conditions : Conditions
        Friction, temperatures and failing share to judge by.
    """
    return failed_share(rise_quantile, rise_limit(conditions))


def decisive_rise(rise_quantile: Array, conditions: Conditions) -> float:
    """Rise at friction 1 that just the failing share of the contact area exceeds [K].

    Parameters are those of `failed_fraction`.
    """
    return float(rise_exceeded(rise_quantile, conditions.failing_share))


def worst_moment(rise: Array, normal_load: Array, load: Array | float) -> Indices:
    """Step at which the rise is highest, from when the load of the point is reached on.

    Parameters
    ----------
    rise : ndarray, shape (..., n_step)
        Rise at each step that just the failing share exceeds [K]; NaN where it is not known.
    normal_load : ndarray, shape (..., n_step)
        Normal load at each step [N].
    load : float or ndarray, shape (..., 1)
        The load that the point is named after [N].

    Returns
    -------
    ndarray of int, shape (...)
        The last step where the rise is not known at any that counts.

    Examples
    --------
    >>> rise = np.array([900.0, 700.0, 750.0, np.nan, 720.0])
    >>> int(worst_moment(rise, np.array([500.0, 600.0, 600.0, 600.0, 600.0]), 600.0))
    2
    """
    counts = np.isfinite(rise) & (normal_load >= load)
    at: Indices = np.argmax(np.where(counts, rise, -math.inf), axis=-1)
    return np.where(counts.any(axis=-1), at, rise.shape[-1] - 1)


def verdict(columns: Mapping[str, Array], load: float, conditions: Conditions) -> Verdict:
    """Tell whether wear is severe at a point.

    Parameters
    ----------
    columns : dict of ndarray
        ``normal_load`` [N], ``time`` [s] and ``rise_quantile`` [K] by step, as in
        `pipeline.sweep.plan.PointResult.columns`.
    load : float
        The load that the point is named after [N].
    conditions : Conditions
        Friction, temperatures and failing share to judge by.
    """
    rises = rise_exceeded(columns["rise_quantile"], conditions.failing_share)
    worst = int(worst_moment(rises, columns["normal_load"], load))
    rise, quantiles = float(rises[worst]), columns["rise_quantile"][worst]
    judged = conditions.critical_temperature is not None
    return Verdict(
        is_severe=rise > rise_limit(conditions) if judged else None,
        time=float(columns["time"][worst]),
        decisive_temperature=contact_temperature(rise, conditions),
        max_temperature=contact_temperature(float(quantiles[-1]), conditions),
        failed_fraction=failed_fraction(quantiles, conditions) if judged else None,
    )


def boundary_velocity_error(rise: float, expected: float, exponent: float) -> float:
    """Relative error of the velocity of the boundary, from that of the rise near it.

    A rise that is too high reaches the limit at too low a velocity.

    Parameters
    ----------
    rise, expected : float
        Rise found, and the one there should be [K].
    exponent : float
        d ln(rise)/d ln(velocity) there.

    Examples
    --------
    >>> f"{boundary_velocity_error(1100.0, 1000.0, exponent=0.5):.4f}"
    '-0.1736'
    """
    return math.expm1(-math.log(rise / expected) / exponent)

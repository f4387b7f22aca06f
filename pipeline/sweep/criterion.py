"""The conditions under which wear is judged: too hot a contact is severe.

The contact temperature is that of the bulk and a rise, which is proportional to friction and is
kept at friction 1. With r the rise that decides (`tribo.Criterion`), wear is severe where

    bulk + µ r > critical,  that is  r > (critical − bulk)/µ.

Where the disk's bulk is Δ warmer than the pin's, bulk is that of the colder body, and r the rise
above it at the ratio Δ/µ (`tribo.thermal.quantiles`), which is never negative: see `at_bulks`.

A point counts by its worst moment: where the load is held, r is the highest one from when the
load is reached on.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tribo import (
    BULK_RATIOS,
    Corrections,
    Criterion,
    InputError,
    Scene,
    State,
    failed_share,
)
from tribo.corrections import NEEDED, moment_of
from tribo.criterion import rises_at
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
        Temperature of both bodies far from the contact, or of the pin where they differ [K].
    critical_temperature : float or None
        Temperature above which the lubricant fails [K]; None where it is not known.
    failing_share : float
        Share of the contact area above the critical temperature beyond which wear is severe, from
        0 (Blok's criterion, the maximum temperature) to below 1.
    disk_temperature : float or None
        Temperature of the disk far from the contact [K]; None where it is that of the pin.
    criterion : str
        Kind of criterion, one of `tribo.CRITERIA`; the failing share belongs to "share" alone.
    corrections : Corrections or None
        Friction by velocity, earlier passes, stem and film; a mapping is read as what
        `as_dict` gives.

    Raises
    ------
    InputError
        If one lies outside its range, or friction varies with velocity between bodies of unequal
        bulk temperatures.

    Examples
    --------
    >>> from dataclasses import replace
    >>> white_oil = Conditions(0.1, bulk_temperature=298.15, critical_temperature=418.15)
    >>> replace(white_oil, friction=0.12).failing_share
    0.1
    >>> white_oil.changed(share=0.0).failing_share
    0.0
    """

    friction: float
    bulk_temperature: float
    critical_temperature: float | None
    failing_share: float = 0.1
    disk_temperature: float | None = None
    criterion: str = "share"
    corrections: Corrections | None = None

    def __post_init__(self) -> None:
        if isinstance(self.corrections, Mapping):
            object.__setattr__(self, "corrections", Corrections.of_plain(self.corrections))
        for name in self.__slots__:
            if name in ("criterion", "corrections"):
                continue
            value = getattr(self, name)
            if value is None and name in ("critical_temperature", "disk_temperature"):
                continue
            if isinstance(value, Iterable):
                raise InputError(f"{name} is {value!r}; it must be one number here")
            if not math.isfinite(value):
                raise InputError(f"{name} is {value!r}; it must be finite")
        if self.friction < 0:
            raise InputError(f"friction is {self.friction:g}; it must be at least 0")
        warmest = self.bulk_temperature + max(0.0, self.bulk_difference)
        for name in ("bulk_temperature", "disk_temperature"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise InputError(f"{name} is {_in_celsius(value)}; it must be above 0 K")
        critical = self.critical_temperature
        if critical is not None and critical <= warmest:
            raise InputError(
                f"critical_temperature is {_in_celsius(critical)}; it must lie above the bulk "
                f"temperature, {_in_celsius(warmest)}"
            )
        Criterion(self.criterion, self.failing_share)
        if self.corrections and self.corrections.friction and self.bulk_difference:
            raise InputError(
                "friction.by_velocity: the bulk temperatures of pin and disk differ, and then the "
                "rise is not proportional to friction; give one bulk temperature, or one friction"
            )

    @property
    def decisive(self) -> Criterion:
        """Criterion of severe wear."""
        return Criterion(self.criterion, self.failing_share)

    @property
    def bulk_difference(self) -> float:
        """Bulk temperature of the disk less that of the pin [K]."""
        disk = self.disk_temperature
        return 0.0 if disk is None else disk - self.bulk_temperature

    @property
    def coldest_bulk_temperature(self) -> float:
        """Bulk temperature of the colder body, from which rises count [K]."""
        return self.bulk_temperature + min(0.0, self.bulk_difference)

    @property
    def mean_bulk_temperature(self) -> float:
        """Mean of both bodies' bulk temperatures [K]: that of the oil between them."""
        return self.bulk_temperature + self.bulk_difference / 2

    @property
    def rise_factor(self) -> float:
        """What the rise at friction 1 is multiplied by: the friction.

        Without friction unequal bulk temperatures still warm one of the bodies. Then it is so small
        that their ratio to it is the largest one that is kept.
        """
        return max(self.friction, abs(self.bulk_difference) / BULK_RATIOS[-1])

    @property
    def bulk_ratio(self) -> float:
        """Difference of the bulk temperatures over what the rise is multiplied by [K]."""
        difference = self.bulk_difference
        return difference / self.rise_factor if difference else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data; disk's temperature and corrections where given."""
        plain = asdict(self)
        if self.disk_temperature is None:
            del plain["disk_temperature"]
        del plain["corrections"]
        return plain | ({"corrections": self.corrections.as_dict()} if self.corrections else {})

    def friction_at(self, velocity: float) -> float:
        """Coefficient of friction at a sliding velocity [m/s]."""
        if self.corrections is None:
            return self.friction
        return self.friction * float(self.corrections.friction_factor(np.array(velocity)))

    def at_friction(self, friction: float | None) -> Conditions:
        """The conditions with a friction measured at one point; as they are where there is none."""
        if friction is None:
            return self
        corrections = self.corrections and replace(self.corrections, friction=())
        return replace(self, friction=friction, corrections=corrections)

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
                'the scene, such as critical = "145 degC", or where options or arguments take '
                "it, give --critical-temperature or critical_temperature"
            )
        return self.critical_temperature

    def changed(
        self,
        friction: float | None = None,
        bulk_temperature: float | Mapping[str, float] | None = None,
        critical_temperature: float | None = None,
        share: float | None = None,
        criterion: str | None = None,
    ) -> Conditions:
        """Return the conditions with those that are given in place of their own.

        Parameters
        ----------
        friction, critical_temperature, share : float, optional
            Coefficient, temperature [K] and share in place of their own.
        bulk_temperature : float or mapping, optional
            Temperature of both bodies [K]; or one for each, by ``"pin"`` and ``"disk"``.
        criterion : str, optional
            Kind of criterion; "share" if a share alone is given.
        """
        given: dict[str, Any] = {
            "friction": friction,
            "critical_temperature": critical_temperature,
            "failing_share": share,
            "criterion": "share" if criterion is None and share is not None else criterion,
        }
        changes = {name: value for name, value in given.items() if value is not None}
        if bulk_temperature is not None:
            changes |= of_bulks(bulk_temperature)
        return replace(self, **changes)


def of_bulks(given: float | Mapping[str, float | None] | None) -> dict[str, Any]:
    """Entries of `Conditions` for one bulk temperature, or for one of each body [K].

    Raises
    ------
    InputError
        If it names other bodies than pin and disk.

    Examples
    --------
    >>> of_bulks({"pin": 333.15, "disk": 298.15})
    {'bulk_temperature': 333.15, 'disk_temperature': 298.15}
    >>> of_bulks(298.15)
    {'bulk_temperature': 298.15, 'disk_temperature': None}
    """
    if not isinstance(given, Mapping):
        return {"bulk_temperature": given, "disk_temperature": None}
    if set(given) != {"pin", "disk"}:
        raise InputError(
            f"bulk_temperature names {', '.join(map(str, given)) or 'no body'}; give one "
            "temperature for both bodies, or one for pin and one for disk"
        )
    disk = given["disk"] if given["disk"] != given["pin"] else None
    return {"bulk_temperature": given["pin"], "disk_temperature": disk}


def _in_celsius(temperature: float) -> str:
    """Write a temperature [K] in both of its usual units."""
    return f"{temperature - 273.15:.6g} °C ({temperature:.6g} K)"


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether wear is severe at a point, and what is so at its worst moment.

    Attributes
    ----------
    is_severe : bool or None
        Whether the deciding temperature is above the critical one; None where that is not known.
    time : float
        The worst moment, from the start of the ramp [s].
    decisive_temperature : float
        Temperature that decides [K].
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
    return conditions.coldest_bulk_temperature + conditions.rise_factor * rise


def rise_limit(conditions: Conditions) -> float:
    """Decisive rise at friction 1 above which wear is severe [K]; infinite without friction.

    Examples
    --------
    >>> rise_limit(Conditions(0.1, 298.15, 418.15)), rise_limit(Conditions(0.0, 298.15, 418.15))
    (1200.0, inf)
    """
    if conditions.rise_factor == 0:
        return math.inf
    warming = conditions.known_critical_temperature() - conditions.coldest_bulk_temperature
    return warming / conditions.rise_factor


RISES = ("max_rise", "mean_rise", "rise_quantile")
"""Columns that depend on the bulk temperatures where these differ."""


def at_bulks(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Rises of the contact above the colder body, for each unit of `Conditions.rise_factor` [K].

    Parameters
    ----------
    columns : mapping of ndarray
        ``rise_quantile`` (..., n_quantile), ``mean_rise`` and ``max_rise`` (...) above the pin's
        bulk at friction 1 [K], as far as they are needed; where the bulk temperatures differ what
        `tribo.criterion.rises_at` needs, and for corrections `tribo.corrections.NEEDED`.
    conditions : Conditions
        Conditions to judge by.

    Returns
    -------
    mapping of ndarray
        The columns, with those of `RISES` at the bulk temperatures and with the corrections of the
        conditions.

    Raises
    ------
    InputError
        If the bulk temperatures differ, and nothing is kept for that.
    """
    columns = corrected(columns, conditions)
    ratio = conditions.bulk_ratio
    if ratio == 0:
        return columns
    require_bulks(columns, conditions)
    return above_colder(columns, ratio)


def above_colder(columns: Mapping[str, Any], bulk_ratio: float) -> Mapping[str, Any]:
    """Rises at friction 1 above the colder body at a bulk ratio [K].

    Parameters
    ----------
    columns : mapping of ndarray
        See `at_bulks`.
    bulk_ratio : float
        Disk's less pin's bulk temperature, over friction [K].
    """
    above_pin = rises_at(columns, bulk_ratio)
    pin = max(0.0, -bulk_ratio)
    return {**above_pin, **{name: above_pin[name] + pin for name in RISES if name in above_pin}}


def columns_needed(conditions: Conditions) -> tuple[str, ...]:
    """Columns that `at_bulks` needs besides the deciding ones of some conditions."""
    unequal = ("bulk_rise_quantile", "mean_bulk_response") if conditions.bulk_ratio else ()
    return unequal + (NEEDED if conditions.corrections else ())


def corrected(columns: Mapping[str, Any], conditions: Conditions) -> Mapping[str, Any]:
    """Columns whose rises have the corrections of some conditions, at all bulk ratios.

    Parameters
    ----------
    columns : mapping of ndarray
        Rises by step [K], and `tribo.corrections.NEEDED`.
    conditions : Conditions
        Conditions with corrections; without any the columns are given back as they are.
    """
    return conditions.corrections.applied(columns) if conditions.corrections else columns


def require_bulks(columns: Container[Any] | xr.Dataset, conditions: Conditions) -> None:
    """Refuse unequal bulk temperatures where nothing is kept for them."""
    kept = "bulk_rise_quantile" in columns or "mean_bulk_response" in columns
    if conditions.disk_temperature is None or kept:
        return
    raise InputError(
        f"bulk_temperature is {_in_celsius(conditions.bulk_temperature)} of the pin and "
        f"{_in_celsius(conditions.disk_temperature)} of the disk; the sweep was computed for "
        "bodies of one bulk temperature: give one, or run the scene into another store with "
        "bulk = { pin = ..., disk = ... } under [temperature]"
    )


def failed_fraction(rise_quantile: Array, conditions: Conditions) -> float:
    """Share of the contact area above the critical temperature.

    Parameters
    ----------
    rise_quantile : ndarray, shape (n_quantile,)
        Rise that each of `tribo.QUANTILES` of the contact area stays below [K], of `at_bulks`.
    conditions : Conditions
        Friction and temperatures to judge by.
    """
    return failed_share(rise_quantile, rise_limit(conditions))


def rises_of(scene: Scene, state: State, conditions: Conditions) -> Mapping[str, Any]:
    """Rises at one moment of a simulation with temperature, as `at_bulks` gives them.

    Raises
    ------
    InputError
        If the state has no temperature.
    """
    plain = replace(conditions, corrections=None)
    return at_bulks(moment_of(scene, state, conditions.corrections), plain)


def decisive_rise(scene: Scene, state: State, conditions: Conditions) -> float:
    """Rise that decides at one moment of a simulation [K]."""
    return float(conditions.decisive.rise(rises_of(scene, state, conditions)))


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


def decisive_rises(
    columns: Mapping[str, Any], load: Array | float, conditions: Conditions
) -> Array:
    """Rise that decides at points, each at its worst moment [K].

    Parameters
    ----------
    columns : mapping of ndarray
        ``normal_load`` (..., n_step) [N] and those of `at_bulks` by step; ``quantile`` where they
        are not at all of `tribo.QUANTILES`.
    load : float or ndarray, shape (..., 1)
        Loads that the points are named after [N].
    conditions : Conditions
        Conditions to judge by.

    Returns
    -------
    ndarray, shape (...)
        NaN where the rise is not known.
    """
    rises = conditions.decisive.rise(at_bulks(columns, conditions))
    worst = worst_moment(rises, columns["normal_load"], load)
    found: Array = np.take_along_axis(rises, worst[..., None], axis=-1)[..., 0]
    return found


def verdict(columns: Mapping[str, Array], load: float, conditions: Conditions) -> Verdict:
    """Tell whether wear is severe at a point.

    Parameters
    ----------
    columns : dict of ndarray
        ``normal_load`` [N], ``time`` [s] and those of `at_bulks` by step, as in
        `pipeline.sweep.plan.PointResult.columns`.
    load : float
        The load that the point is named after [N].
    conditions : Conditions
        Conditions to judge by.
    """
    columns = at_bulks(columns, conditions)
    rises = conditions.decisive.rise(columns)
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

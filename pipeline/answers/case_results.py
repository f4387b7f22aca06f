"""Results of one case of a sweep, and of its tests, as arrays."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.constants import MIN_VELOCITY_RATIO
from pipeline.quantities import UNITS
from pipeline.store.schema import DONE, FAILED, PENDING, PLANE, VARIABLES
from pipeline.sweep.case import Conditions, Variant
from pipeline.sweep.case_table import CaseName, Label
from pipeline.sweep.stored_steps import least_load_evaluated
from pipeline.sweep.sweep import Sweep
from tribo import QUANTILES, InputError, Stages, WarningKind
from tribo.constants import SLOWEST
from tribo.simulation.verdict import (
    columns_needed,
    relative_sampling,
    worst_rises,
)
from tribo.types import Array, Indices, Mask

SPECIMEN_DIMS = ("realization", *PLANE)
"""Axes of the points of one case."""
ROUNDING = 1e-6
"""Relative difference of values that a user may have stored in 32 bits."""
NOT_SIMULATED = (
    "the dataset has values that xarray moved or computed from other points ({}); "
    "select stored points by sel or isel, change single variables by assign, and give other loads "
    "and velocities to pipeline.margin, which interpolates with an error"
)
"""Message for values that are no results of a simulation, with the sign of it."""


@dataclass(frozen=True, eq=False)
class TestPoint:
    """Result at one point of a test; a transition with a step has two, the milder one first."""

    load: float  # [N]
    velocity: float  # [m/s]
    least_load: float  # smallest load of a step that is compared with the limit [N]
    status: int  # as in the store
    message: str
    columns: Mapping[str, Array]

    def rise(self, conditions: Conditions) -> float:
        """Rise per unit friction coefficient at the worst step [K]."""
        return float(worst_rises(self.columns, np.array([self.least_load]), conditions))

    @property
    def missing_reason(self) -> str:
        """Reason for a missing result, to be printed after the test's name; empty if done."""
        if self.status == FAILED:
            return f"failed ({self.message}); to simulate it again: irg run SCENE --retry-failed"
        return "" if self.status == DONE else "has not been simulated yet: irg run SCENE"


@dataclass(frozen=True, eq=False)
class CaseResults:
    """Results of one case of a sweep.

    Arrays have the axes realization, load and velocity; those of stepped variables continue with
    step and others. Points at velocity 0, which have no heat, are excluded.
    """

    sweep: Sweep  #: The case and its realizations, as the scene states them.
    labels: Mapping[str, Label]  #: Values of varied entries, by dimension [SI].
    name: CaseName  #: The case, as the sweep names it.
    ds: xr.Dataset = field(repr=False)
    tests: tuple[tuple[TestPoint, ...], ...] = field(repr=False)  #: Points of each test.
    is_row: bool  #: True if each case of the sweep has its own load and velocity.
    #: Variants of its scene, each with its point.
    variants: tuple[tuple[Variant, TestPoint], ...] = field(repr=False)
    own_load: float | None  #: Load of a row at load factor 1 [N]; None without factors.
    load_factors: tuple[float, ...]  #: Ascending; empty without factors.
    is_changed: bool  #: True if rises are not those of the store, but a user's.
    _cache: dict[Any, Any] = field(default_factory=dict, repr=False)

    @property
    def conditions(self) -> Conditions:
        """Conditions of the case in its scene."""
        return self.sweep.conditions

    @functools.cached_property
    def loads(self) -> Array:
        """Ascending loads [N]."""
        return np.asarray(self.ds["load"].values, float)

    @functools.cached_property
    def velocities(self) -> Array:
        """Ascending velocities above 0 [m/s]."""
        return np.asarray(self.ds["velocity"].values, float)

    @property
    def without_tests(self) -> CaseResults:
        """The same results without the tests of the scene."""
        return replace(self, sweep=replace(self.sweep, tests=()), tests=())

    def cached(self, key: Any, compute: Callable[[], Any]) -> Any:
        """The result of `compute`, which is called once for each `key`."""
        if key not in self._cache:
            self._cache[key] = compute()
        return self._cache[key]

    def array(self, name: str) -> Array:
        """Array of a variable."""
        values: Array = self.cached(name, lambda: self._read(name))
        return values

    def _read(self, name: str) -> Array:
        if name not in self.ds:
            raise InputError(f"the dataset lacks {name}; keep all of its variables")
        require_unit(variable := self.ds[name])
        # Times are equal for all realizations.
        sizes = self.ds["status"].sizes.items()
        variable = variable.expand_dims({k: n for k, n in sizes if k not in variable.dims})
        values = variable.transpose(
            *SPECIMEN_DIMS, "step", "area_fraction_below", missing_dims="ignore"
        ).values
        return values.astype(float, copy=False) if values.dtype.kind == "f" else values

    @property
    def status(self) -> Indices:
        """Status of each point, as in the store."""
        return self.array("status").astype(int)

    @property
    def done(self) -> Mask:
        """True at points with a result."""
        return np.asarray(self.status == DONE)

    @property
    def missing(self) -> int:
        """Number of points that are pending or failed."""
        return int(np.count_nonzero(np.isin(self.status, (FAILED, PENDING))))

    @functools.cached_property
    def usable_realizations(self) -> Indices:
        """Indices of the realizations that share a done point with the first one."""
        indices = np.flatnonzero(self.done.any(axis=(1, 2)))
        if not indices.size:
            return np.array([0])
        shares_point = (self.done[indices] & self.done[indices[0]]).any(axis=(1, 2))
        return np.asarray(indices[shares_point])

    def log_rises(self, conditions: Conditions) -> Array:
        """ln(rise) at the worst step of each point, NaN if it is not done.

        The rise [K] is the governing one, per unit friction coefficient.
        """
        if conditions.friction and not self.sweep.scene.friction_heat:
            raise InputError(
                f"friction is {conditions.friction:g}, but the sweep was computed without "
                "friction and heat: run the scene with friction into another store"
            )
        least_loads = [least_load_evaluated(self.sweep.scene, load) for load in self.loads.tolist()]
        self._require_quantiles(1 - conditions.critical_area_fraction)
        columns = self._columns({"normal_load", "rise_quantile", *columns_needed(conditions)})
        self._require_values_of_labels()
        if (
            np.diff(columns["rise_quantile"]) < -ROUNDING * columns["rise_quantile"][..., 1:]
        ).any():
            raise InputError(NOT_SIMULATED.format("rise_quantile falls along area_fraction_below"))
        rises = worst_rises(columns, np.array(least_loads)[:, None, None], conditions)
        rises = np.where(self.done, rises, np.nan)
        return np.asarray(np.log(np.maximum(rises, 1e-9)))  # finite without heat

    def _require_quantiles(self, share: float) -> None:
        """Raise an `InputError` if quantiles next to a share were left out of the dataset.

        Between others, the governing rise would err by up to 2 %.
        """
        quantiles = self.ds["area_fraction_below"].values
        if np.isclose(quantiles, share, rtol=0, atol=ROUNDING).any():
            return
        nearest = [
            *[quantile for quantile in QUANTILES if quantile <= share + ROUNDING][-1:],
            *[quantile for quantile in QUANTILES if quantile >= share - ROUNDING][:1],
        ]
        for quantile in nearest:
            if not np.isclose(quantiles, quantile, rtol=0, atol=ROUNDING).any():
                raise InputError(
                    f"the dataset lacks area_fraction_below {quantile:g}, which a critical area "
                    f"fraction of {1 - share:g} needs; keep all of its values"
                )

    def _require_values_of_labels(self) -> None:
        """Raise an `InputError` for a point that has values of another load, velocity or step.

        Coordinates have those of their labels, as after a roll, while pressures carry another load.
        """
        end = self.ds["step"].values.tolist().index(0) if "step" in self.ds.coords else -1
        forces = self.array("normal_load")
        time, distance = (self.array(name)[..., end] for name in ("time", "sliding_distance"))
        velocity = distance / np.where(time > 0, time, np.nan)
        _require_label("load", self.loads[:, None], forces[..., end])
        _require_label("velocity", self.velocities, velocity)
        if {"contact_fraction", "mean_pressure"} <= self.ds.keys():
            area = self.sweep.scene.nominal_area * self.array("contact_fraction")
            _require_label("load", forces, area * self.array("mean_pressure"))
        if "wear_volume" in self.ds and not self.sweep.scene.wears_by_law:
            self._require_wear_by_velocity(self.array("wear_volume")[..., end])

    def _require_wear_by_velocity(self, volume: Array) -> None:
        """Raise an `InputError` unless worn volumes are in proportion to the velocity."""
        rate, is_worn = volume / self.velocities, self.done & (volume > 0)
        highest = np.max(rate, axis=-1, where=is_worn, initial=0)
        lowest = np.min(rate, axis=-1, where=is_worn, initial=np.inf)
        is_other = (highest > (1 + 1e3 * ROUNDING) * lowest).any(axis=0)
        if is_other.any():
            reason = (
                f"worn volumes at load {self.loads[is_other][0]:g} N are not in proportion to the "
                "velocity"
            )
            raise InputError(NOT_SIMULATED.format(reason))

    def sampling(self, conditions: Conditions) -> Array:
        """Standard deviation of ln(rise) between surface realizations, by each point; or NaN."""
        columns = self._columns(("rise_quantile", "rise_realization_std"))
        deviations = relative_sampling(columns, conditions, columns["quantile"])
        return np.where(self.done, deviations, np.nan)

    @property
    def sampling_freedom(self) -> Array:
        """Degrees of freedom of `sampling` at each point; infinite where the point is not done."""
        return np.where(self.done, self.array("rise_realization_freedom"), np.inf)

    def _columns(self, names: Iterable[str]) -> dict[str, Any]:
        """Arrays by name, and the probabilities of the quantiles."""
        shares = self.ds["area_fraction_below"].values
        return {"quantile": shares} | {name: self.array(name) for name in names}

    @functools.cached_property
    def warning_flags(self) -> Indices:
        """Sums of `WarningKind` codes of each point: the stored ones, and ``SLOW_RISE``.

        The relative error of a critical velocity is that of the rise over the exponent n of
        rise ∝ Vⁿ. Below n = 0.3 this error was 5 to 8 % with preset `standard`.
        """
        flags = np.where(self.done, self.array("warning_flags"), 0).astype(int)
        if not self.sweep.scene.friction_heat:
            return flags
        share = self.sweep.conditions.critical_area_fraction
        rises = self.log_rises(Conditions(1.0, 300.0, critical_area_fraction=share))
        x = np.log(self.velocities)
        slow = np.apply_along_axis(lambda y: _exponents(x, y) < SLOWEST, -1, rises)
        return np.asarray(flags | slow * int(WarningKind.SLOW_RISE))

    @property
    def durations(self) -> Array:
        """Time of loading of each point [s]."""
        return np.asarray(np.nan_to_num(self.array("time"), nan=-np.inf).max(axis=-1))


def outside_reason(
    case: CaseResults, ranges: Mapping[str, tuple[float, float]], **point: float
) -> str:
    """Reason that a load and a velocity are unknown; empty if they lie within `ranges`."""
    outside = {
        name: value
        for name, value in point.items()
        if not (ranges[name][0] <= value <= ranges[name][1] and value > 0)
    }
    if not outside:
        return ""
    texts = []
    for name, value in outside.items():
        (low, high), unit = ranges[name], UNITS[name]
        texts.append(f"{name} {value:g} {unit} is outside the sweep ({low:g} to {high:g} {unit})")
    limits = ", ".join(texts)
    if not all(0 < value < math.inf for value in point.values()):
        return f"{limits}; give a value inside it"
    if case.own_load is not None and "velocity" not in outside:
        return f"{limits}; add a factor to sweep.load_factors, and run the scene again"
    if case.is_row:
        requested = ", ".join(f"{name} {value:g} {UNITS[name]}" for name, value in point.items())
        return (
            f"{requested} is not a case of the sweep, in which each case has its own load and "
            "velocity; add it to sweep.along, and run the scene again"
        )
    if isinstance(case.sweep.scene.loading, Stages):  # which end at the highest load
        return f"{limits}; run the scene with it into another store"
    names = {"load": "sweep.loads", "velocity": "sweep.velocities"}
    entries = " and ".join(names[name] for name in outside)
    return f"{limits}; add it to {entries}, and run the scene again"


def _require_label(name: str, labels: Array, values: Array) -> None:
    """Raise an `InputError` for a point that has `values` of another load or velocity."""
    labels = np.broadcast_to(labels, values.shape)
    is_other = np.abs(values - labels) > 1e3 * ROUNDING * labels
    if is_other.any():
        label, value = labels[is_other][0], values[is_other][0]
        unit = UNITS[name]
        reason = f"the values stored at {name} {label:g} {unit} belong to {value:g} {unit}"
        raise InputError(NOT_SIMULATED.format(reason))


def _exponents(x: Array, y: Array) -> Array:
    """Slope at each point of a curve y(x) from its neighbours; NaN without neighbours."""
    slopes, known = np.full(x.shape, np.nan), np.flatnonzero(np.isfinite(y))
    x, y, min_distance = x[known], y[known], math.log(MIN_VELOCITY_RATIO)
    low = np.maximum(np.searchsorted(x, x - min_distance, "right") - 1, 0)
    high = np.minimum(np.searchsorted(x, x + min_distance), len(known) - 1)
    is_apart = x[high] - x[low] >= min_distance
    differences = np.where(is_apart, x[high] - x[low], 1)
    slopes[known[is_apart]] = ((y[high] - y[low]) / differences)[is_apart]
    return slopes


def require_unit(variable: xr.DataArray) -> None:
    """Raise an `InputError` for a variable that is not in the unit of the store."""
    expected, unit = VARIABLES.get(str(variable.name)), variable.attrs.get("units")
    if expected and expected.units and unit not in (None, expected.units):
        raise InputError(
            f"{variable.name} of the dataset is in {unit}; it must be in {expected.units}"
        )

"""A sweep's dataset, or its store, as arrays: the results of each of its cases.

A case is one combination of varied entries. Its random surfaces are realizations of one specimen.
"""

from __future__ import annotations

import functools
import json
import math
import os
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.scene_wording import value_words
from pipeline.constants import APART_FOR_EXPONENT
from pipeline.paths import found_store
from pipeline.store.dataset import completed, open_store
from pipeline.store.place import PathLike
from pipeline.store.schema import (
    AT_TESTS,
    COLUMNS,
    COORDINATES,
    DONE,
    FAILED,
    FIELDS,
    INPUTS,
    NOT_NEEDED,
    PENDING,
    PLANE,
    PROGRESS,
    SAMPLING,
    TEST_STEP,
    VARIABLES,
    split_arrays,
    variable_of_tests,
)
from pipeline.sweep.case_table import CaseName, Label
from pipeline.sweep.codec import CodecError
from pipeline.sweep.condition_entries import Conditions
from pipeline.sweep.points_of_tests import SCENE_HASH, TEST_POINT, list_points_of_tests
from pipeline.sweep.stored import sweep_of_plain
from pipeline.sweep.stored_steps import least_load_evaluated
from pipeline.sweep.sweep import Sweep
from pipeline.units import to_si
from tribo import InputError, WarningKind
from tribo.constants import SLOWEST
from tribo.simulation.severity import (
    columns_needed,
    relative_sampling,
    worst_rises,
)
from tribo.types import Array, Indices, Mask

_SPECIMEN = ("realization", *PLANE)
_BATCH_SIZE = 16  # realizations whose steps are read at once
_INNER = ("step", "area_fraction_below")
_ROUNDING = 1e-6  # relative difference of a coordinate, which a user may have stored in 32 bits
_NOT_SIMULATED = (
    "the dataset has values that xarray computed from other points ({}), without their error; "
    "select stored points by sel or isel, and give other loads and velocities to pipeline.margin, "
    "which interpolates with an error"
)


def open_sweep(path: PathLike) -> xr.Dataset:
    """Open a stored sweep.

    Parameters
    ----------
    path : str or path
        Path or URL of a store made by `pipeline.run_sweep`, which may still be running; or the
        name of a scene, whose store is in ``results``.

    Returns
    -------
    Dataset
        The stored variables, with ascending loads, velocities and seeds of surfaces. ``step`` 0 is
        the end of each point, −1 the step before. Values are NaN at steps that a point does not
        have, and at points that are not done. Data are read when they are used.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> ds["load"].values.tolist()
    [200.0, 400.0, 600.0, 750.0]
    """
    ds = open_store(found_store(path)).drop_vars("message", errors="ignore")
    return ascending(ds)


def dataset_of(source: xr.Dataset | PathLike) -> xr.Dataset:
    """Dataset of the store at a path; a dataset is returned unchanged."""
    if isinstance(source, xr.Dataset):
        return source
    if isinstance(source, str | os.PathLike):
        return open_sweep(source)
    raise InputError(
        "expected a dataset from pipeline.open_sweep or the path of a store, not a "
        f"{type(source).__name__}"
    )


def ascending(ds: xr.Dataset) -> xr.Dataset:
    """The dataset of a store with ascending numbers along each axis."""
    axes = [str(name) for name in ds["status"].dims if ds[name].dtype.kind in "if"]
    falling = [name for name in axes if (np.diff(ds[name]) < 0).any()]
    return ds.sortby(falling) if falling else ds  # with an empty list it would copy `ds`


def end_of_point(ds: xr.Dataset | PathLike) -> xr.Dataset:
    """Select the end of each point: the step at the point's nominal load.

    Examples
    --------
    >>> import pipeline
    >>> end = pipeline.end_of_point("results/first_try.zarr")
    >>> bool((end["normal_load"] == end["load"]).all())
    True
    """
    return dataset_of(ds).sel(step=0, drop=True)


def sweep_of(ds: xr.Dataset) -> Sweep:
    """Sweep of a dataset."""
    ds = completed(ds)
    if "sweep" not in ds.attrs:
        raise InputError(
            "the dataset has no attribute sweep, which describes its scene; use one from "
            "pipeline.open_sweep, or keep attributes with xarray.set_options(keep_attrs=True)"
        )
    return _decoded(str(ds.attrs["sweep"]), _Arrays(ds.variables.get(INPUTS)))


class _Arrays:
    """Input arrays of a scene, equal if their digests are."""

    def __init__(self, data: xr.Variable | None) -> None:
        self.data, self.digests = data, "" if data is None else str(data.attrs["digests"])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Arrays) and self.digests == other.digests

    def __hash__(self) -> int:
        return hash(self.digests)


@functools.lru_cache(maxsize=64)
def _decoded(text: str, arrays: _Arrays) -> Sweep:
    data = arrays.data
    try:
        plain = json.loads(text)
    except ValueError as error:
        raise InputError(f"the attribute sweep of the dataset is no JSON: {error}") from error
    try:
        return sweep_of_plain(plain, {} if data is None else split_arrays(data.values, data.attrs))
    except CodecError as error:
        raise InputError(
            f"the dataset was written by another version of this program: {error}; open its store "
            "with pipeline.open_sweep"
        ) from error


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
    is_row: bool = False  #: True if each case of the sweep has its own load and velocity.
    _arrays: dict[str, Array] = field(default_factory=dict, repr=False)

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

    def array(self, name: str) -> Array:
        """Array of a variable."""
        if name not in self._arrays:
            if name not in self.ds:
                raise InputError(f"the dataset lacks {name}; keep all of its variables")
            _require_unit(variable := self.ds[name])
            # Times are equal for all realizations.
            sizes = self.ds["status"].sizes.items()
            variable = variable.expand_dims({k: n for k, n in sizes if k not in variable.dims})
            values = variable.transpose(*_SPECIMEN, *_INNER, missing_dims="ignore").values
            self._arrays[name] = (
                values.astype(float, copy=False) if values.dtype.kind == "f" else values
            )
        return self._arrays[name]

    @property
    def status(self) -> Indices:
        """Status of each point, as in the store."""
        return np.nan_to_num(self.array("status"), nan=NOT_NEEDED).astype(int)

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
        names = {"normal_load", "rise_quantile", *columns_needed(conditions)}
        least_loads = [least_load_evaluated(self.sweep.scene, load) for load in self.loads.tolist()]
        thresholds = np.array(least_loads)[:, None, None]
        parts = list[Array]()
        for columns in self._parts(names | {"time", "sliding_distance"}):
            self._require_simulated(columns)
            parts.append(worst_rises(columns, thresholds, conditions))
        rises = np.concatenate(parts)
        rises = np.where(self.done, rises, np.nan)
        return np.asarray(np.log(np.maximum(rises, 1e-9)))  # finite without heat

    def _require_simulated(self, columns: Mapping[str, Array]) -> None:
        """Raise an `InputError` for a point that has the results of another load or velocity."""
        end = self.ds["step"].values.tolist().index(0) if "step" in self.ds.coords else -1
        force, time, distance = (
            columns[name][..., end] for name in ("normal_load", "time", "sliding_distance")
        )
        for name, labels, values in (
            ("load", self.loads[:, None], force),
            ("velocity", self.velocities, distance / np.where(time > 0, time, np.nan)),
        ):
            is_other = np.abs(values - labels) > 1e3 * _ROUNDING * labels
            if is_other.any():
                value = np.broadcast_to(labels, values.shape)[is_other][0]
                unit = COORDINATES[name].units
                reason = f"those at {name} {value:g} {unit} are of {values[is_other][0]:g} {unit}"
                raise InputError(_NOT_SIMULATED.format(reason))

    def sampling(self, conditions: Conditions) -> Array:
        """Standard deviation of ln(rise) between surface realizations, estimated at each point."""
        parts = self._parts(("rise_quantile", *SAMPLING))
        shares = self.ds["area_fraction_below"].values
        deviations = [relative_sampling(columns, conditions, shares) for columns in parts]
        return np.where(self.done, np.concatenate(deviations), np.nan)

    def _parts(self, names: Iterable[str]) -> Iterator[dict[str, Any]]:
        """Yield arrays by name for `_BATCH_SIZE` realizations at a time, to bound memory."""
        names, shares = [*names], {"quantile": self.ds["area_fraction_below"].values}
        count = self.ds.sizes["realization"]
        if count <= _BATCH_SIZE:
            yield shares | {name: self.array(name) for name in names}
            return
        # An accuracy goal has up to 256 realizations, of a few points each.
        for first in range(0, count, _BATCH_SIZE):
            subset = self.ds.isel(realization=slice(first, first + _BATCH_SIZE))
            part = replace(self, ds=subset, _arrays={})
            yield shares | {name: part.array(name) for name in names}

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


def _exponents(x: Array, y: Array) -> Array:
    """Slope at each point of a curve y(x) from its neighbours; NaN without neighbours."""
    slopes, known = np.full(x.shape, np.nan), np.flatnonzero(np.isfinite(y))
    x, y, min_distance = x[known], y[known], math.log(APART_FOR_EXPONENT)
    low = np.maximum(np.searchsorted(x, x - min_distance, "right") - 1, 0)
    high = np.minimum(np.searchsorted(x, x + min_distance), len(known) - 1)
    is_apart = x[high] - x[low] >= min_distance
    differences = np.where(is_apart, x[high] - x[low], 1)
    slopes[known[is_apart]] = ((y[high] - y[low]) / differences)[is_apart]
    return slopes


def cases_of(source: xr.Dataset | PathLike) -> list[CaseResults]:
    """Results of each case of a sweep, in the order of the dimensions of its varied entries.

    Parameters
    ----------
    source : Dataset, str or path
        Dataset of `open_sweep`, of which some loads, velocities, surfaces or values of entries may
        be selected; or path of a store.
    """
    ds = completed(dataset_of(source))
    sweep = sweep_of(ds)
    if ds.attrs.get("without_tests"):
        sweep = replace(sweep, tests=())
    _require_sweep(ds, sweep)
    tests, dims = _test_points(ds, sweep), case_dims(ds)
    sizes = [ds.sizes[dim] for dim in dims]
    parts = (ds.isel(dict(zip(dims, index, strict=True))) for index in np.ndindex(*sizes))
    return [_case(part, sweep, tests) for part in parts]


def case_dims(ds: xr.Dataset) -> list[str]:
    """Names of the dimensions of varied entries, and of rows of a table."""
    return [str(dim) for dim in ds["status"].dims if dim not in _SPECIMEN]


def refuse_cases(ds: xr.Dataset) -> None:
    """Raise an `InputError` for a dataset of several cases."""
    if several := case_dims(ds):
        first = value_words(ds[several[0]], ds[several[0]].values[0].item())
        raise InputError(
            f"the sweep has several cases; select one by {', '.join(several)}, such as --at "
            f'"{several[0]}={first}"'
        )


def sweeps_of(ds: xr.Dataset) -> Iterator[tuple[Sweep, xr.Dataset]]:
    """Yield each case of a dataset, and the part of the dataset that belongs to it."""
    sweep, dims = sweep_of(ds), case_dims(ds)
    for index in np.ndindex(*(ds.sizes[dim] for dim in dims)):
        part = ds.isel({dim: [label] for dim, label in zip(dims, index, strict=True)})
        yield _identify_case(part.squeeze(dims), sweep)[0], part


def _identify_case(ds: xr.Dataset, sweep: Sweep) -> tuple[Sweep, CaseName]:
    """The case of a sweep to which a dataset without varied entries belongs, and its name."""
    table, name = sweep.case_table, []
    for column in table.chosen:
        if column.name not in ds.coords:
            raise InputError(f"the coordinate {column.name} is missing from the dataset; keep it")
        name.append((column.name, _label(table.axes[column.name], ds[column.name].item())))
    if not name:
        return sweep, ()
    words = ", ".join(f"{key} {text}" for key, text in table.to_text(tuple(name)).items())
    return replace(sweep._select_case(tuple(name)), title=f"{sweep.title}, {words}"), tuple(name)


def _case(ds: xr.Dataset, sweep: Sweep, tests: tuple[tuple[TestPoint, ...], ...]) -> CaseResults:
    case, name = _identify_case(ds, sweep)
    labels = {
        str(key): coordinate.item()
        for key, coordinate in ds.coords.items()
        if not coordinate.ndim and key not in (*COORDINATES, "realization")
    }
    ds = ds.reset_coords([key for key in PROGRESS if key in ds.coords])
    # `expand_dims` reads all values, but fields are large, and no answer needs them.
    ds = ds.drop_vars(FIELDS, errors="ignore")
    ds = ds.expand_dims([dim for dim in _SPECIMEN if dim not in ds["status"].dims])
    is_moving = ds["velocity"] > 0
    if is_moving.any() and not is_moving.all():
        ds = ds.isel(velocity=np.flatnonzero(is_moving))
    is_row = any(sweep.case_table.column(axis) is not None for axis in PLANE)
    return CaseResults(case, labels, name, ds, tests, is_row)


def _label(labels: tuple[Label, ...], value: Any) -> Label:
    """Label nearest to a coordinate's value, which may be rounded."""
    if isinstance(labels[0], str):
        return str(value)
    label = min(labels, key=lambda label: abs(float(label) - value))
    if abs(float(label) - value) > _ROUNDING * abs(value):
        raise InputError(_NOT_SIMULATED.format(f"no case has {value:g}; the next is {label:g}"))
    return label


def _require_sweep(ds: xr.Dataset, sweep: Sweep) -> None:
    """Raise an `InputError` for a dataset whose axes are not those of its sweep."""
    if "status" not in ds:
        raise InputError("the dataset has no status; use it as pipeline.open_sweep returns it")
    if "step" in ds.coords and 0 not in ds["step"].values:
        raise InputError("the dataset lacks step 0, the end of each point, which decides")
    if "step" not in ds.dims and any(name in ds for name in COLUMNS):
        raise InputError("step is a single value; select a list instead: ds.sel(step=[0])")
    for name in PLANE:
        values = ds[name].values if name in ds.coords else np.array([])
        if values.dtype.kind not in "fiu" or not values.size or not np.isfinite(values).all():
            raise InputError(f"the dataset has no finite {name}; keep its coordinates")
        unit, stated = COORDINATES[name].units, ds[name].attrs.get("units")
        if stated and stated != unit and to_si(f"1 {stated}", like=f"1 {unit}") != 1:
            raise InputError(f"{name} of the dataset is in {stated}; it must be in {unit}")
        if name in ds.dims and (np.diff(values) <= 0).any():
            raise InputError(f"{name} of the dataset does not ascend; sort it, and keep each once")
        stored = np.array({"load": sweep.loads, "velocity": sweep.velocities}[name])
        if name in ds.dims:
            distances = np.abs(values[:, None] - stored).min(axis=1)
            if (is_other := distances > _ROUNDING * np.abs(values)).any():
                reason = f"{name} {values[is_other][0]:g} {unit} is not in its sweep"
                raise InputError(_NOT_SIMULATED.format(reason))
    if ds["status"].dtype == np.float64:  # selections and masks keep 8 bits, or make 32
        raise InputError(_NOT_SIMULATED.format("its status is no integer"))


def _require_unit(variable: xr.DataArray) -> None:
    """Raise an `InputError` for a variable that is not in the unit of the store."""
    expected, unit = VARIABLES.get(str(variable.name)), variable.attrs.get("units")
    if expected and expected.units and unit not in (None, expected.units):
        raise InputError(
            f"{variable.name} of the dataset is in {unit}; it must be in {expected.units}"
        )


def _test_points(ds: xr.Dataset, sweep: Sweep) -> tuple[tuple[TestPoint, ...], ...]:
    """The points of each test of a sweep."""
    inner, arrays = (TEST_POINT, TEST_STEP, "area_fraction_below"), dict[str, Any]()
    for name in AT_TESTS:
        if variable_of_tests(name) in ds.variables:
            variable = ds[variable_of_tests(name)]
            _require_unit(variable)
            # `xarray.concat` of surfaces repeats variables that do not depend on them.
            variable = variable.isel({dim: 0 for dim in variable.dims if dim not in inner})
            arrays[name] = variable.transpose(*inner, missing_dims="ignore").values
    rows = defaultdict[tuple[Any, ...], deque[int]](deque)
    keys = (arrays[name].tolist() for name in (SCENE_HASH, *PLANE)) if arrays else ()
    for row, key in enumerate(zip(*keys, strict=True)):
        rows[key].append(row)
    test_points = [list[TestPoint]() for _ in sweep.tests]
    for point in list_points_of_tests(sweep):
        state, columns = (PENDING, ""), dict[str, Any]()
        if matching_rows := rows[point[:3]]:
            row = matching_rows.popleft()
            state = int(arrays["status"][row]), str(arrays["message"][row])
            names = (k for k, array in arrays.items() if array.dtype.kind == "f" and k not in PLANE)
            columns = {name: arrays[name][row].astype(float) for name in names}
            columns["quantile"] = ds["area_fraction_below"].values
        least_load = least_load_evaluated(sweep.tests[point.test].case.scene, point.load)
        test_points[point.test].append(
            TestPoint(point.load, point.velocity, least_load, *state, columns)
        )
    return tuple(map(tuple, test_points))

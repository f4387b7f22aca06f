"""Datasets of sweeps, their sweep, and the results of each of its cases.

A case is one combination of varied entries. Its random surfaces are realizations of one specimen.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.case_results import (
    NOT_SIMULATED,
    ROUNDING,
    SPECIMEN_DIMS,
    CaseResults,
    TestPoint,
    require_unit,
)
from pipeline.answers.scene_wording import value_words
from pipeline.paths import store_path_of
from pipeline.store.dataset import open_store, with_sweep_and_tests
from pipeline.store.location import PathLike
from pipeline.store.schema import (
    AT_TESTS,
    COLUMNS,
    COORDINATES,
    DATA,
    FIELDS,
    INPUTS,
    PENDING,
    PLANE,
    RECORDS,
    TEST_STEP,
    split_arrays,
    variable_of_tests,
)
from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import LEAST_DISTANCE, LOAD_FACTOR, CaseName, Label
from pipeline.sweep.codec import CodecError
from pipeline.sweep.plan import TEST_POINT
from pipeline.sweep.stored import sweep_of_plain
from pipeline.sweep.stored_steps import least_load_evaluated
from pipeline.sweep.sweep import Sweep
from tribo import InputError

_RISES = "rise_quantile", "mean_rise", "max_rise"
_MAX_SWEEPS = 64  # kept in memory
_decoded_sweeps = dict[tuple[str, str], Sweep]()
"""Sweeps by their text and the digests of their arrays."""


def open_sweep(path: PathLike) -> xr.Dataset:
    """Open a stored sweep.

    Parameters
    ----------
    path : str or path
        Path of a store made by `pipeline.run_sweep`, which may still be running; or the
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
    ds = open_store(store_path_of(path)).drop_vars("message", errors="ignore")
    return ascending(ds)


def dataset_of(source: xr.Dataset | PathLike, without_tests: bool = False) -> xr.Dataset:
    """Dataset of the store at a path; a dataset is returned unchanged.

    Answers leave the tests of the scene out if `without_tests` is True.
    """
    if not isinstance(source, xr.Dataset | str | os.PathLike):
        raise InputError(
            f"ds is of type {type(source).__name__}; give a Dataset of pipeline.open_sweep, or the "
            "path of a store"
        )
    ds = source if isinstance(source, xr.Dataset) else open_sweep(source)
    return ds.assign_attrs(without_tests="yes") if without_tests else ds


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
    ds = with_sweep_and_tests(ds)
    if "sweep" not in ds.attrs:
        raise InputError(
            "the dataset has no attribute sweep, which describes its scene and tests; use one from "
            "pipeline.open_sweep, also to write a netCDF file, and keep its attributes with "
            "xarray.set_options(keep_attrs=True)"
        )
    text, data = str(ds.attrs["sweep"]), ds.variables.get(INPUTS)
    key = text, "" if data is None else str(data.attrs["digests"])
    if key not in _decoded_sweeps:
        if len(_decoded_sweeps) > _MAX_SWEEPS:
            _decoded_sweeps.clear()
        _decoded_sweeps[key] = _decode_sweep(text, data)
    return _decoded_sweeps[key]


def _decode_sweep(text: str, data: xr.Variable | None) -> Sweep:
    try:
        plain = json.loads(text)
    except ValueError as error:
        raise InputError(
            f"the attribute sweep of the dataset is not valid JSON: {error}"
        ) from error
    try:
        return sweep_of_plain(plain, {} if data is None else split_arrays(data.values, data.attrs))
    except CodecError as error:
        raise InputError(
            f"the dataset was written by another version of this program: {error}; open its store "
            "with pipeline.open_sweep"
        ) from error


def cases_of(source: xr.Dataset | PathLike) -> list[CaseResults]:
    """Results of each case of a sweep, in the order of the dimensions of its varied entries.

    Parameters
    ----------
    source : Dataset, str or path
        Dataset of `open_sweep`, of which some loads, velocities, surfaces or values of entries may
        be selected; or path of a store.
    """
    ds = with_sweep_and_tests(dataset_of(source))
    sweep = sweep_of(ds)
    _require_sweep(ds, sweep)
    tests, dims = _test_points(ds, sweep), case_dims(ds)
    if ds.attrs.get("without_tests"):
        sweep, tests = replace(sweep, tests=()), tests[len(sweep.tests) :]
    sizes = [ds.sizes[dim] for dim in dims]
    ds = ds.drop_vars(FIELDS, errors="ignore")  # they are large, and no answer needs them
    if dims:
        ds = ds.compute()  # each variable once, and not once for each case
    parts = (ds.isel(dict(zip(dims, index, strict=True))) for index in np.ndindex(*sizes))
    is_changed = any(_is_computed(ds, name) for name in _RISES)
    return [_results_of_case(part, sweep, tests, is_changed) for part in parts]


def case_dims(ds: xr.Dataset) -> list[str]:
    """Names of the dimensions of varied entries, and of rows of a table."""
    return [str(dim) for dim in ds["status"].dims if dim not in (*SPECIMEN_DIMS, LOAD_FACTOR)]


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
    for column in table.chosen_columns:
        if column.name not in ds.coords:
            raise InputError(f"the coordinate {column.name} is missing from the dataset; keep it")
        name.append((column.name, _nearest_label(table.axes[column.name], ds[column.name].item())))
    if not name:
        return sweep, ()
    words = ", ".join(f"{key} {text}" for key, text in table.to_text(tuple(name)).items())
    return replace(sweep.select_case(tuple(name)), title=f"{sweep.title}, {words}"), tuple(name)


def _results_of_case(
    ds: xr.Dataset, sweep: Sweep, tests: tuple[tuple[TestPoint, ...], ...], is_changed: bool
) -> CaseResults:
    case, name = _identify_case(ds, sweep)
    own_load, factors = None, ()
    if LOAD_FACTOR in ds["status"].dims:
        factors = tuple(ds[LOAD_FACTOR].values.tolist())
        ds = ds.swap_dims({LOAD_FACTOR: "load"}).drop_vars(LOAD_FACTOR)
        row = next(row for label, row in sweep.case_table.by_name.items() if {*name} <= {*label})
        own_load = float(row["load"])
    labels = {
        str(key): coordinate.item()
        for key, coordinate in ds.coords.items()
        if not coordinate.ndim and key not in (*COORDINATES, "realization")
    }
    ds = ds.reset_coords([key for key in DATA | RECORDS if key in ds.coords])
    ds = ds.expand_dims([dim for dim in SPECIMEN_DIMS if dim not in ds["status"].dims])
    is_moving = ds["velocity"] > 0
    if is_moving.any() and not is_moving.all():
        ds = ds.isel(velocity=np.flatnonzero(is_moving))
    is_row = any(sweep.case_table.column(axis) is not None for axis in PLANE)
    count = len(sweep.tests)
    variants = tuple(
        (variant, point)
        for variant, (point,) in zip(sweep.variants, tests[count:], strict=True)
        if is_row or variant.of_case == name
    )
    return CaseResults(
        case, labels, name, ds, tests[:count], is_row, variants, own_load, factors, is_changed
    )


def _nearest_label(labels: tuple[Label, ...], value: Any) -> Label:
    """Label nearest to a coordinate's value, which may be rounded."""
    if isinstance(labels[0], str):
        return str(value)
    label = min(labels, key=lambda label: abs(float(label) - value))
    if abs(float(label) - value) > ROUNDING * abs(value):
        raise InputError(NOT_SIMULATED.format(f"no case has {value:g}; the nearest is {label:g}"))
    return label


def _require_sweep(ds: xr.Dataset, sweep: Sweep) -> None:
    """Raise an `InputError` for a dataset that is not a selection of the points of its sweep."""
    if "status" not in ds:
        raise InputError("the dataset has no status; use it as pipeline.open_sweep returns it")
    if ds["status"].dtype.kind not in "iu":  # as after where, shift, interp, reindex, coarsen
        raise InputError(NOT_SIMULATED.format("its status is not an integer"))
    if _is_computed(ds, "wall_time"):  # as after round
        raise InputError(NOT_SIMULATED.format("all of its variables are computed"))
    if joined := [name for name, index in ds.indexes.items() if index.nlevels > 1]:
        raise InputError(f"{joined[0]} joins dimensions of the dataset; call ds.unstack() first")
    if "step" in ds.coords and 0 not in ds["step"].values:
        raise InputError("the dataset lacks step 0, the end of each point, which decides")
    if "step" not in ds.dims and any(name in ds for name in COLUMNS):
        raise InputError("step is a single value; select a list instead: ds.sel(step=[0])")
    if "area_fraction_below" in ds.coords and "area_fraction_below" not in ds.dims:
        raise InputError(
            "area_fraction_below is a single value; select a list instead: "
            f"ds.sel(area_fraction_below=[{ds['area_fraction_below'].item():g}])"
        )
    for name, swept in (("load", sweep.loads), ("velocity", sweep.velocities)):
        values = ds[name].values if name in ds.coords else np.array([])
        if values.dtype.kind not in "fiu" or not values.size or not np.isfinite(values).all():
            raise InputError(
                f'the coordinate "{name}" is missing or not finite; keep it in the dataset'
            )
        if name not in ds.dims:
            if rest := {*ds[name].dims} - {*sweep.case_table.axes, LOAD_FACTOR}:
                raise InputError(
                    f"{name} is no dimension of the dataset; call "
                    f'ds.swap_dims({min(map(str, rest))}="{name}") first'
                )
            continue
        if (np.diff(values) <= LEAST_DISTANCE * values[1:]).any():
            raise InputError(
                f"{name} of the dataset does not ascend by 0.01 % or more; sort it, and keep one "
                "of values that are nearly equal"
            )
        distances = np.abs(values[:, None] - np.array(swept)).min(axis=1)
        if (is_other := distances > ROUNDING * np.abs(values)).any():
            reason = f"{name} {values[is_other][0]:g} is not in its sweep"
            raise InputError(NOT_SIMULATED.format(reason))


def _is_computed(ds: xr.Dataset, name: str) -> bool:
    """True if xarray computed a variable of a store, which then has lost its encoding."""
    encodings = [ds.variables[k].encoding for k in (name, "normal_load") if k in ds.variables]
    return len(encodings) == 2 and not encodings[0] and bool(encodings[1])


def _test_points(ds: xr.Dataset, sweep: Sweep) -> tuple[tuple[TestPoint, ...], ...]:
    """The points of each test of a sweep, then of each variant."""
    inner, arrays = (TEST_POINT, TEST_STEP, "area_fraction_below"), dict[str, Any]()
    for name in (TEST, *AT_TESTS):
        if variable_of_tests(name) in ds.variables:
            variable = ds[variable_of_tests(name)]
            require_unit(variable)
            # `xarray.concat` of surfaces repeats variables that do not depend on them.
            variable = variable.isel({dim: 0 for dim in variable.dims if dim not in inner})
            arrays[name] = variable.transpose(*inner, missing_dims="ignore").values
    keys = (arrays[name].tolist() for name in (TEST, *PLANE)) if arrays else ()
    rows = {key: row for row, key in enumerate(zip(*keys, strict=True))}
    test_points = list[tuple[TestPoint, ...]]()
    for number, test in enumerate(sweep.tests_and_variants):
        points = list[TestPoint]()
        for load, velocity in test.points:
            state, columns = (PENDING, ""), dict[str, Any]()
            if (row := rows.get((number, load, velocity))) is not None:
                state = int(arrays["status"][row]), str(arrays["message"][row])
                names = (k for k, x in arrays.items() if x.dtype.kind == "f" and k not in PLANE)
                columns = {name: arrays[name][row].astype(float) for name in names}
                columns["quantile"] = ds["area_fraction_below"].values
            least_load = least_load_evaluated(test.case.scene, load)
            points.append(TestPoint(load, velocity, least_load, *state, columns))
        test_points.append(tuple(points))
    return tuple(test_points)

"""Results, read once from a path or a dataset, for several answers.

They do not follow later changes of the dataset. Some of its points may not have been computed:
`interp` and `coarsen` of xarray put points at other loads and velocities. `rolling` leaves them
where they are, but there the mean pressure times the contact area is no longer the load, as the
mean of a product is not the product of the means.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.columns import Columns
from pipeline.analysis.dataset import (
    Origin,
    dataset_of,
    entry_dims,
    judged_values,
    restore_step,
    scene_sweep,
    sweep_kind,
)
from pipeline.analysis.results import Results
from pipeline.analysis.results_of_tests import read_test_results
from pipeline.store.place import PathLike
from pipeline.store.schema import FILM, MADE, PLANE, SAMPLING, STEPPED, VARIABLES
from tribo import InputError
from tribo.simulation.corrections import NEEDED
from tribo.types import Array

_INNER = ("step", "bulk_ratio", "cooler_share")
_MARKS = ("status", "warning_flags", "message")
_RISES = ("max_rise", "mean_rise", "rise_quantile", "bulk_rise_quantile", "mean_bulk_response")
ResultsLike = xr.Dataset | PathLike | Results
"""A dataset, the path of a store, or results that were read from either."""


def results(ds: ResultsLike) -> Results:
    """Read the results of a sweep once, for several answers.

    Functions take the returned object instead of a dataset. It does not follow later changes of the
    dataset.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of the store.

    Returns
    -------
    Results
        The sweep under the conditions of `pipeline.at`, with its axes and columns.

    Raises
    ------
    InputError
        If the dataset has lost the attributes that describe its sweep.

    Examples
    --------
    >>> import pipeline
    >>> data = pipeline.results("results/first_try.zarr")
    >>> data.columns["mean_rise"].shape, data.loads.tolist()
    ((4, 6, 8), [200.0, 400.0, 600.0, 750.0])
    >>> pipeline.margin(data, "400 N", "1.4 m/s").verdict
    'mild'
    """
    if isinstance(ds, Results):
        return ds
    ds = _with_both_axes(restore_step(dataset_of(ds), "status"))
    if "rise_quantile" in ds and "cooler_share" not in ds.indexes:
        raise InputError("the dataset has no axis cooler_share; keep it, with all of its values")
    kind, status = sweep_kind(ds), ds["status"]
    front = (*entry_dims(ds), *(name for name in ("realization",) if name in status.dims))
    # In the order of the dataset, so that labels keep their order.
    labels = (name for name, one in ds.coords.items() if {*one.dims} <= {*front})
    rows = dict.fromkeys((*labels, *front))
    plane = {name: ds.sizes[name] if name in status.dims else 1 for name in PLANE}
    sizes = {name: status.sizes[name] for name in front} | plane
    wanted = {*_RISES, *NEEDED}
    names = [
        *_MARKS,
        *SAMPLING,
        *FILM,
        *dict.fromkeys((*MADE, *(name for name in STEPPED if name in wanted))),
    ]
    # Copies of what is in memory; data of a store are still read when they are used.
    found = {name: _checked(ds, name) for name in names if name in ds.variables}
    columns = Columns({name: partial(_values, name, one, sizes) for name, one in found.items()})
    stored = scene_sweep(ds)
    return Results(
        stored=stored,
        judged=judged_values(ds),
        kind=kind,
        front=front,
        rows=xr.Dataset(coords={name: ds[name].variable.copy() for name in rows}),
        loads=np.array(ds["load"].values, ndmin=1),
        velocities=np.array(ds["velocity"].values, ndmin=1),
        cut=tuple(name for name in PLANE if not ds[name].ndim),
        columns=columns,
        shares=np.array(ds["cooler_share"].values) if "cooler_share" in ds.coords else np.empty(0),
        tests=read_test_results(ds, stored),
        rest=ds.drop_vars([name for name in names if name in ds.data_vars]),
        store=status.encoding.get("store"),
        origin=Origin.of(ds),
    )


def _with_both_axes(ds: xr.Dataset) -> xr.Dataset:
    """Dataset with a load or velocity that was selected alone as an axis of size 1."""
    for name, other in (PLANE, PLANE[::-1]):
        if not ds[name].ndim and other in ds["status"].dims:
            spread = {k: one.expand_dims(name) for k, one in ds.items() if other in one.dims}
            return ds.drop_vars([name, *map(str, spread)]).assign(spread)
    return ds


def _checked(ds: xr.Dataset, name: str) -> xr.Variable:
    """Variable `name` of a dataset; `InputError` if it has lost an axis, or its numbers."""
    given = ds.variables[name]
    axes = ({*ds["status"].dims} - {*_INNER}) | {*VARIABLES[name].dims}
    wanted = {*VARIABLES[name].dims} & {*ds.dims}
    for words, dims in (("lost its axis", wanted - {*given.dims}), ("also", {*given.dims} - axes)):
        if dims:
            raise InputError(
                f"{name} of the dataset has {words} {min(map(str, dims))}; take it as "
                "pipeline.open_sweep gives it"
            )
    if given.dtype.kind == "c":
        raise InputError(f"{name} of the dataset is complex; take its real part")
    if given.dtype.kind == "O" and name != "message":
        try:
            return given.astype(float)
        except (TypeError, ValueError) as error:
            raise InputError(f"{name} of the dataset is no number: {error}") from error
    return given.copy()


def _values(name: str, given: xr.Variable, sizes: Mapping[str, int]) -> Array:
    """Values of a variable, with a dimension for each of `sizes`, and those within a point."""
    inner = {dim: given.sizes[dim] for dim in _INNER if dim in given.dims}
    values = given.values
    if values.dtype.kind == "f":
        values = values.astype(float, copy=False)
        if name == "status":  # which interpolation may leave a little off
            values = values.round(6)
    own: Any = xr.Variable(given.dims, values)
    return np.asarray(own.set_dims({**sizes, **inner}).values)

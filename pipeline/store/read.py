"""A store as a dataset of xarray, with points that are not done as NaN."""

from __future__ import annotations

import itertools
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.layout import Axes, blocks, row_axes
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
    damaged,
    io_errors,
    place_of,
    read_errors,
)
from pipeline.store.root import Root
from pipeline.store.schema import (
    ABOUT,
    DONE,
    INPUTS,
    PENDING,
    PLANE,
    POINT,
    RECORDS,
    attributes_of,
    is_coordinate,
    is_of_points,
)
from pipeline.store.write import Store, opened
from pipeline.sweep.variants import in_order
from tribo.types import Indices


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store as a dataset of its present state; data are read when they are used.

    The store may still be in use by a run. A copy written by xarray is opened, too. Raises a
    `StoreError` if there is no readable store, or done points lack chunks.
    """
    place = place_of(path)
    if (copy := _open_copy(place)) is not None:
        words = [name for name, values in copy.coords.items() if values.dtype.kind == "T"]
        return copy.assign_coords({name: copy[name].astype(object) for name in words})
    return xr.open_dataset(str(place), engine=_Backend, chunks=None)


def _open_copy(place: StorePlace) -> xr.Dataset | None:
    """Open a copy of a sweep that xarray wrote as netCDF or Zarr; None for anything else."""
    with io_errors(place), suppress(ValueError, KeyError, TypeError, OSError, RecursionError):
        if isinstance(place, Folder) and place.path.is_file():
            copy = xr.open_dataset(place.path, chunks=None)
        elif place.read(f"{ABOUT}/{ROOT}") is None:
            copy = xr.open_zarr(place.zarr(), zarr_format=3, consolidated=False, chunks=None)
        else:
            return None
        if "sweep" in copy.attrs:
            return copy
    return None


class _Backend(BackendEntrypoint):
    """Backend by which xarray opens a store, with axes and metadata from its root document."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open a store for xarray; `drop_variables` is not supported."""
        store = opened(filename_or_obj)  # reads statuses first: data of done points are complete
        _require_chunks(store)
        root, rows = _plane_of_points(store.root)
        present = root.coordinates()
        coords = {*present, "own_grid"} - {INPUTS}
        marks = {"status": store.flags, "asked": store.asked}
        present |= {name: _grid_values(values, rows) for name, values in marks.items()}
        variables = {}
        for name, variable in root.variables.items():
            values = present.get(name)
            if values is None:
                values = indexing.LazilyIndexedArray(_Masked(store, name, rows))
            elif name in root.axes:
                values = np.array(values, object if variable.dtype == "str" else variable.dtype)
            shown = attributes_of(variable)
            shown.pop("coordinates", None)
            variables[name] = xr.Variable(variable.dims, values, shown)
        variables["status"].encoding["store"] = str(store.place)
        steps = np.isfinite(present["time"]).any(tuple(range(present["time"].ndim - 1)))
        ds = xr.Dataset(variables, attrs=root.attributes).set_coords(coords)
        return ds.isel(step=slice(int(steps.argmax()), None))  # without the spare room for steps


def _require_chunks(store: Store) -> None:
    """Raise a `StoreError` if a chunk of a done point is missing."""
    done = store.flags == DONE
    with io_errors(store.place):
        keys = store.place.keys()
    for name in itertools.filterfalse(is_coordinate, store.arrays):
        chunks = blocks(done, store.arrays[name].chunks[: done.ndim])
        if not all(store.key(name, chunk) in keys for chunk, _ in chunks):
            raise StoreError(damaged(store.place, name))


def _plane_of_points(root: Root) -> tuple[Root, Indices | None]:
    """Arrange on a grid the single points that a boundary search has stored.

    Returns a root document whose axes are all loads and velocities of these points, with the other
    loads of the sweep, and an array over these axes with the number of the stored point, or −1
    without a point. The root document of any other store is returned unchanged, with None.
    """
    if POINT not in root.axes:
        return root, None
    sweep, stored = replace(root.sweep, chosen=None), root.axes
    axes: Axes = {name: stored[name] for name in stored if not is_of_points(name)} | row_axes(sweep)
    axes["load"] = in_order([*sweep.plane.loads, *stored["load"]])
    axes["velocity"] = in_order(stored["velocity"])
    dims = [*sweep.variants.axes, *PLANE]
    where = [pd.Index(axes[dim]).get_indexer(stored[dim]) for dim in dims]
    rows = np.full([len(axes[dim]) for dim in dims], -1)
    rows[tuple(where)] = stored[POINT]
    return replace(root, sweep=sweep, axes={name: [*values] for name, values in axes.items()}), rows


class _Masked(BackendArray):
    """A stored variable, read when it is indexed, with fill values at points without data.

    For a store of single points, `rows` has the number of the stored point at each load and
    velocity, −1 without a point. It is None for a store that has a grid of points.
    """

    def __init__(self, store: Store, name: str, rows: Indices | None) -> None:
        self._place, self._name, self._rows = store.place, name, rows
        self._array = array = store.arrays[name]
        mask = store.flags != PENDING if name in RECORDS else store.flags == DONE
        self._mask = _grid_values(mask, rows)
        self._inner = array.shape[mask.ndim :]
        self.shape, self.dtype = (*self._mask.shape, *self._inner), array.dtype
        if self.dtype.kind == "T":  # xarray writes text to netCDF only as Python strings
            self.dtype = np.dtype(object)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def _read(self, key: tuple[Any, ...]) -> Any:
        """Read a part of the variable; `key` has an index for each dimension (outer indexing)."""
        count = self._mask.ndim
        mask = _select(self._mask, key[:count])
        with read_errors(self._place, self._name):
            if self._rows is None:
                values = np.array(self._array.oindex[key], self.dtype)
                values[~mask] = self._array.fill_value
                return values
            inner = _select(np.broadcast_to(False, self._inner), key[count:]).shape
            values = np.full((*mask.shape, *inner), self._array.fill_value, self.dtype)
            rows = _select(self._rows, key[:count])[mask]
            values[mask] = self._array.oindex[(rows, *key[count:])]
        return values


def _grid_values(values: Any, rows: Indices | None) -> Any:
    """Put values of single stored points on a grid of loads and velocities, with 0 elsewhere.

    `rows` has the number of the stored point at each load and velocity, −1 where there is none. If
    it is None, the values are on a grid already, and are returned unchanged.
    """
    return values if rows is None else np.where(rows >= 0, values[rows], values.dtype.type(0))


def _select(values: Any, key: tuple[Any, ...]) -> Any:
    """Select values; `key` has an index for each dimension (outer indexing)."""
    return xr.Variable([str(number) for number in range(values.ndim)], values)[key].values

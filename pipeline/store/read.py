"""A store as an xarray dataset; points that are not done are NaN."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.place import PathLike, damaged, place_of
from pipeline.store.schema import (
    AT_TESTS,
    DATA,
    DONE,
    FAILED,
    FIELDS,
    INPUTS,
    PROGRESS,
    RECORDS,
    TEST_STEP,
    attributes_of,
    variable_of_tests,
)
from pipeline.store.store import Store, opened
from pipeline.sweep.case import TEST
from pipeline.sweep.points_of_tests import NO_TEST, TEST_POINT


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store as a dataset of its present state; data are read when they are used.

    The store may still be in use by a run. Raises a `StoreError` if there is no readable store.
    """
    location = place_of(path)
    return xr.open_dataset(str(location), engine=_Backend, chunks=None)


class _Backend(BackendEntrypoint):
    """Backend of xarray for stores, with axes and metadata derived from the sweep."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open a store for xarray; `drop_variables` is not supported."""
        return store_dataset(opened(filename_or_obj))


def store_dataset(store: Store) -> xr.Dataset:
    """Present state of an open store as a dataset; data are read when they are used."""
    return _dataset_of(store).assign_coords(_test_coordinates(store))


def completed(ds: xr.Dataset) -> xr.Dataset:
    """The dataset with its sweep and the results of tests, which plain xarray leaves in the store.

    `xarray.open_zarr` and `sel` keep the path of the store; a dataset without it is returned as it
    is.
    """
    source = ds.encoding.get("source")
    if "sweep" in ds.attrs or source is None or "status" not in ds.variables:
        return ds
    store = opened(source)
    with_tests = ds.assign_coords(_test_coordinates(store))
    return with_tests.assign_attrs(sweep=json.dumps(store.root.plain))


def _dataset_of(store: Store) -> xr.Dataset:
    """Points of a store as a dataset whose data are read when they are used."""
    group = store.group
    present: dict[str, Any] = {**group.coordinates, "status": store.flags}
    coords = {*group.coordinates, *PROGRESS} - {INPUTS}
    variables = {}
    for name, variable in group.variables.items():
        if name == "checksum":
            continue
        values = present.get(name)
        if values is None:
            values = indexing.LazilyIndexedArray(_Masked(store, name))
        elif name in group.axes:
            values = np.array(values, object if variable.dtype == "str" else variable.dtype)
        attributes = attributes_of(variable)
        attributes.pop("coordinates", None)
        variables[name] = xr.Variable(variable.dims, values, attributes)
    variables["status"].encoding["store"] = str(store.location)
    # Answers need the sweep, which stays in the attributes of datasets made from this one.
    dataset_attributes = store.root.attributes | {"sweep": json.dumps(store.root.plain)}
    return xr.Dataset(variables, attrs=dataset_attributes).set_coords(coords & {*variables})


def _test_coordinates(store: Store) -> dict[str, xr.Variable]:
    """Results at points of the scene's tests, as coordinates, which xarray operations keep."""
    if not (store.tests and store.sweep.tests):
        return {}
    ds = _dataset_of(store.tests).drop_vars(TEST_STEP)
    order = np.lexsort([ds[name].values for name in ("velocity", "load", TEST)])
    ds = ds.isel({TEST_POINT: order[ds[TEST].values[order] != NO_TEST]})
    names = [name for name in AT_TESTS if name in ds.variables]
    coordinates = {variable_of_tests(name): ds[name].variable for name in names}
    message = coordinates[variable_of_tests("message")]
    message.values = message.values.astype(object)
    return {TEST: ds[TEST].variable, **coordinates}


class _Masked(BackendArray):
    """A stored variable, read when it is indexed, with fill values at points without data."""

    def __init__(self, store: Store, name: str) -> None:
        self._store, self._name = store, name
        self._array = array = store.arrays[name]
        self._mask = np.isin(store.flags, (DONE, FAILED) if name in RECORDS else (DONE,))
        if name in FIELDS:
            self._mask = store.group.on_surface_with_fields(self._mask)
        self.shape, self.dtype = array.shape, array.dtype
        if self.dtype.kind == "T":  # xarray writes text to netCDF only as Python strings
            self.dtype = np.dtype(object)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def _read(self, key: tuple[Any, ...]) -> Any:
        """Read a part of the variable; `key` has an index for each dimension (outer indexing)."""
        count = self._mask.ndim
        at = [np.arange(n)[index] for n, index in zip(self._mask.shape, key, strict=False)]
        mask = self._mask[np.ix_(*map(np.atleast_1d, at))]
        values = np.asarray(self._store.read(self._name, key), self.dtype)
        inner = values.shape[sum(index.ndim for index in at) :]
        values = values.reshape(mask.shape + inner)
        if self._name in DATA:
            self._require_written(values, mask, at, key[count:])
        values[~mask] = self._array.fill_value
        return values.reshape([*(n for index in at for n in index.shape), *inner])

    def _require_written(self, values: Any, done: Any, at: Sequence[Any], key: Any) -> None:
        """Raise a `DamagedError` if a value of a done point is missing.

        In a copy made while a run wrote, statuses may be newer than data.
        """
        if values.dtype.kind != "f":
            return
        if self._store.group.is_stepped(self._name):
            steps = np.arange(self.shape[done.ndim])[key[0]]
            (last,) = np.nonzero(np.atleast_1d(steps) == self.shape[done.ndim] - 1)
            if not last.size:  # the last step, which every point has, is not read
                return
            values = values if np.ndim(steps) == 0 else np.take(values, last[0], done.ndim)
        lost = np.isnan(values).reshape(*done.shape, -1).any(-1) & done
        if lost.any():
            is_lost_point = np.zeros_like(self._store.flags, bool)
            is_lost = (
                self._store.group.on_surface_with_fields(is_lost_point)
                if self._name in FIELDS
                else is_lost_point
            )
            is_lost[np.ix_(*map(np.atleast_1d, at))] = lost
            first, *more_points = map(
                self._store.group.to_text, self._store.points_where(is_lost_point)
            )
            problem = f"is missing at {first}"
            if more_points:
                problem += f" and at {len(more_points)} more"
            raise damaged(self._store.location, self._name, problem)

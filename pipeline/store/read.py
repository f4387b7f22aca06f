"""A store as a dataset of xarray, with points that are not done as NaN."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.layout import blocks
from pipeline.store.place import (
    Memory,
    PathLike,
    StoreError,
    damaged,
    io_errors,
    place_of,
    read_errors,
)
from pipeline.store.schema import (
    AT_END,
    AT_ENDS,
    AT_TESTS,
    DONE,
    INPUTS,
    PENDING,
    RECORDS,
    TEST_STEP,
    attributes_of,
    is_coordinate,
    test_variable,
)
from pipeline.store.write import Store, opened
from pipeline.sweep.measurement import TEST
from pipeline.sweep.points_of_tests import NO_TEST, TEST_POINT


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store as a dataset of its present state; data are read when they are used.

    The store may still be in use by a run. A copy written by xarray is opened, too. Raises a
    `StoreError` if there is no readable store, or done points lack chunks.
    """
    place = place_of(path)
    return xr.open_dataset(str(place), engine=_Backend, chunks=None)


class _Backend(BackendEntrypoint):
    """Backend by which xarray opens a store, with axes and metadata from its root document."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open a store for xarray; `drop_variables` is not supported."""
        store = opened(filename_or_obj)  # reads statuses first: data of done points are complete
        return store_dataset(store)


def store_dataset(store: Store) -> xr.Dataset:
    """Present state of an open store as a dataset; data are read when they are used."""
    return _dataset_of(store).assign_coords(_test_coordinates(store))


def _dataset_of(store: Store) -> xr.Dataset:
    """Points of a store as a dataset whose data are read when they are used."""
    done = store.flags == DONE
    with io_errors(store.place):
        keys = store.place.keys()
    # A copy may lack the fields, which are most of a store.
    lacks = set() if any(key.startswith(f"{AT_ENDS}/") for key in keys) else {*AT_END, "x", "y"}
    for name in store.arrays.keys() - lacks:
        if is_coordinate(name):
            continue
        chunks = blocks(done, store.arrays[name].chunks[: done.ndim])
        if not all(store.key(name, chunk) in keys for chunk, _ in chunks):
            raise StoreError(damaged(store.place, name))
    root = store.root
    present = root.coordinates()
    coords = {*present, "own_grid"} - {INPUTS, *lacks}
    present |= {"status": store.flags, "asked": store.asked}
    variables = {}
    for name, variable in root.variables.items():
        if name in lacks:
            continue
        values = present.get(name)
        if values is None:
            values = indexing.LazilyIndexedArray(_Masked(store, name))
        elif name in root.axes:
            values = np.array(values, object if variable.dtype == "str" else variable.dtype)
        shown = attributes_of(variable)
        shown.pop("coordinates", None)
        variables[name] = xr.Variable(variable.dims, values, shown)
    if not isinstance(store.place, Memory):
        variables["status"].encoding["store"] = str(store.place)
    steps = np.isfinite(present["time"]).any(tuple(range(present["time"].ndim - 1)))
    ds = xr.Dataset(variables, attrs=root.attributes).set_coords(coords)
    return ds.isel(step=slice(int(steps.argmax()), None))  # without the spare room for steps


def _test_coordinates(store: Store) -> dict[str, xr.Variable]:
    """Results at points of the scene's tests, as coordinates: xarray keeps these in all it does."""
    if not (store.tests and store.tests.root.points):
        return {}
    ds = _dataset_of(store.tests)
    order = np.lexsort([ds[name].values for name in ("velocity", "load", TEST)])
    order = order[ds[TEST].values[order] != NO_TEST]
    ds = ds.isel({TEST_POINT: order}).rename_dims(step=TEST_STEP).drop_vars("step")
    names = [name for name in AT_TESTS if name in ds.variables]
    found = {test_variable(name): ds[name].variable for name in names}
    message = found[test_variable("message")]
    message.values = message.values.astype(object)
    return {TEST: ds[TEST].variable, **found}


def open_tests(path: PathLike) -> xr.Dataset:
    """Results at the points of tests in a store, as they are beside the plane in `open_store`."""
    store = opened(path)
    shares = {
        name: store.axes[name] for name in ("cooler_share", "bulk_ratio") if name in store.axes
    }
    return xr.Dataset(coords={**shares, **_test_coordinates(store)})


def open_messages(path: PathLike) -> xr.DataArray:
    """Messages of the points of a store, "" for a point without one, by the store's axes."""
    store = opened(path)
    texts = store.read("message", ...).astype(object)
    texts[store.flags == PENDING] = ""
    return xr.DataArray(texts, {dim: list(store.axes[dim]) for dim in store.dims}, store.dims)


class _Masked(BackendArray):
    """A stored variable, read when it is indexed, with fill values at points without data."""

    def __init__(self, store: Store, name: str) -> None:
        self._place, self._name = store.place, name
        self._array = array = store.arrays[name]
        self._mask = store.flags != PENDING if name in RECORDS else store.flags == DONE
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
        dims = [str(number) for number in range(count)]
        mask = xr.Variable(dims, self._mask)[key[:count]].values  # outer indexing, as the array's
        with read_errors(self._place, self._name):
            values = np.asarray(self._array.oindex[key], self.dtype)
        values[~mask] = self._array.fill_value
        return values

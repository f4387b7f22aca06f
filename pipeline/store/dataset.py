"""A store as an xarray dataset; points that are not done are NaN."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store import schema
from pipeline.store.location import PathLike, damaged, location_of
from pipeline.store.store import Store, opened
from pipeline.sweep.case import TEST
from tribo import InputError


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store as a dataset of its present state; data are read when they are used.

    The store may still be in use by a run. Raises a `StoreError` if there is no readable store.
    """
    location = location_of(path)
    return xr.open_dataset(str(location), engine=_Backend, chunks=None)


class _Backend(BackendEntrypoint):
    """Backend of xarray for stores, with axes and metadata derived from the sweep."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open a store for xarray; `drop_variables` is not supported."""
        return store_dataset(opened(filename_or_obj))


def store_dataset(store: Store) -> xr.Dataset:
    """Present state of an open store as a dataset; data are read when they are used.

    It has the fields if the store has a single realization. Otherwise, a dataset in which another
    realization is selected would have the fields of the first.
    """
    ds = _dataset_of(store).assign_coords(_test_coordinates(store))
    has_realizations = any(ds.sizes[dim] > 1 for dim, _ in store.sweep.surface_with_fields)
    return ds if has_realizations else ds.assign(_fields_of(store).variables)


def with_sweep_and_tests(ds: xr.Dataset) -> xr.Dataset:
    """The dataset with its sweep and the results of tests, which plain xarray leaves in the store.

    A dataset without a store is returned as it is.
    """
    store = None if "sweep" in ds.attrs else _store_of(ds)
    if store is None:
        return ds
    with_tests = ds.assign_coords(_test_coordinates(store))
    return with_tests.assign_attrs(sweep=json.dumps(store.root.plain))


def _store_of(ds: xr.Dataset) -> Store | None:
    """The store that a dataset was read from, whose path `sel` keeps; None if it is not known.

    Raises an `InputError` if the store has another sweep by now.
    """
    if "status" not in ds.variables:
        return None
    location = ds.variables["status"].encoding.get("store", ds.encoding.get("source"))
    if not location or Path(location).is_file() or "sweep_digest" not in ds.attrs:
        return None
    if Path(location).is_dir() and not (Path(location) / schema.ABOUT).is_dir():
        return None  # written by xarray
    store = opened(location)
    if ds.attrs.get("sweep_digest") != store.root.sweep_digest:
        raise InputError(
            f"the dataset does not belong to the sweep that is in {location} now; open it again, "
            "and keep its attributes"
        )
    return store


def _dataset_of(store: Store) -> xr.Dataset:
    """Points of a store without fields, as a dataset whose data are read when they are used."""
    names = [name for name in store.group.variables if not schema.is_in_fields(name)]
    variables = {name: _variable_of(store, name) for name in names}
    # Answers need the sweep, which stays in the attributes of datasets made from this one.
    attributes = store.root.attributes | {"sweep": json.dumps(store.root.plain)}
    coords = {*store.group.coordinates, *schema.PROGRESS} - {schema.INPUTS}
    return xr.Dataset(variables, attrs=attributes).set_coords(coords & {*variables})


def _fields_of(store: Store) -> xr.Dataset:
    """The group of fields of a store as a dataset whose data are read when they are used."""
    variables = {
        name.removeprefix(f"{schema.OF_FIELDS}/"): _variable_of(store, name)
        for name in filter(schema.is_in_fields, store.group.variables)
    }
    return xr.Dataset(variables).set_coords(variables.keys() - schema.FIELDS.keys())


def _variable_of(store: Store, name: str) -> xr.Variable:
    """A stored variable, which is read when it is used, or a coordinate with its values."""
    variable = store.group.variables[name]
    if name == "status":
        values: Any = store.flags
    elif name in store.group.coordinates:
        dtype = object if variable.dtype == "str" else variable.dtype
        values = np.array(store.group.coordinates[name], dtype)
    else:
        values = indexing.LazilyIndexedArray(_MaskedVariable(store, name))
    attributes = schema.attributes_of(variable)
    attributes.pop("coordinates", None)
    # Variables that xarray computes from this one have no encoding, see `cases_of`.
    return xr.Variable(variable.dims, values, attributes, {"store": str(store.location)})


def _test_coordinates(store: Store) -> dict[str, xr.Variable]:
    """Results at points of the scene's tests, as coordinates, which xarray operations keep."""
    coordinates = dict[str, xr.Variable]()
    for ds in map(_dataset_of, store.groups[1:]):
        names = [name for name in (TEST, *schema.AT_TESTS) if name in ds.variables]
        coordinates |= {schema.variable_of_tests(name): ds[name].variable for name in names}
        message = coordinates[schema.variable_of_tests("message")]
        message.values = message.values.astype(object)
    return coordinates


class _MaskedVariable(BackendArray):
    """A stored variable, read when it is indexed, with fill values at points without data."""

    def __init__(self, store: Store, name: str) -> None:
        self._store, self._name = store, name
        self._array = array = store.arrays[name]
        states = (schema.DONE, schema.FAILED) if name in schema.RECORDS else (schema.DONE,)
        self._mask = store.group.values_at(name, np.isin(store.flags, states))
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
        if self._name in schema.DATA:
            self._require_written(values, mask, key[count:])
        values[~mask] = self._array.fill_value
        return values.reshape([*(n for index in at for n in index.shape), *inner])

    def _require_written(self, values: Any, done: Any, key: Any) -> None:
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
        count = np.count_nonzero(np.isnan(values).reshape(*done.shape, -1).any(-1) & done)
        if count:
            raise damaged(self._store.location, self._name, f"is missing at {count} done points")

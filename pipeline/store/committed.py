"""The committed part of a store, and nothing else, for xarray to read as it is needed.

A point that was cut short has data on the disk, too, and one that is being written has some of its
data. So the status is read first, and the data of points that are not done by then are NaN. Data
that a done point lacks are an error.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.folder import DAMAGED, StoreError
from pipeline.store.snapshot import Snapshot, read_whole
from pipeline.store.variables import DONE, PENDING, is_coordinate


class Committed(BackendEntrypoint):
    """Opens a store as a dataset whose data are read, and checked, when they are used."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open the store in a folder.

        Raises
        ------
        StoreError
            If there is no readable store.
        """
        store, flags = read_whole(filename_or_obj, _checked, Snapshot)
        reader = _Reader(store, flags)
        found = {}
        for name, metadata in store.metadata.items():
            attributes = {k: v for k, v in metadata["attributes"].items() if k != "_FillValue"}
            dims = metadata["dimension_names"]
            if is_coordinate(name):
                found[name] = xr.Variable(dims, np.array(store.axes[name]), attributes)
            elif name == "status":
                found[name] = xr.Variable(dims, flags, attributes)
            else:
                found[name] = reader.variable(name, dims, attributes)
        coordinates = {name: found.pop(name) for name in list(found) if is_coordinate(name)}
        return xr.Dataset(found, coordinates, store.attributes)


def _checked(store: Snapshot) -> NDArray[np.int8]:
    """Status by place, of a store whose coordinates are as they were committed."""
    for name in store.axes:
        if not store.has_coordinate(name):
            raise StoreError(DAMAGED.format(store.path, name))
    flags: NDArray[np.int8] = store.flags()[0]
    return flags


class _Reader:
    """Reads what was done when a store was opened, also after it has grown or was compacted."""

    def __init__(self, store: Snapshot, flags: NDArray[np.int8]) -> None:
        self._store, self._done, self._known = store, flags == DONE, flags != PENDING

    def variable(self, name: str, dims: Any, attributes: Mapping[str, Any]) -> xr.Variable:
        """A variable that has fill values where a point is not done."""
        array = self._store.array(name)
        needed = self._known if name == "message" else self._done
        dtype = np.dtypes.StringDType() if array.dtype == object else array.dtype

        def read(key: tuple[Any, ...]) -> NDArray[Any]:
            picks = [_entries(each, n) for each, n in zip(key, array.shape, strict=True)]
            values = self._read(name, picks, needed[np.ix_(*picks[: needed.ndim])])
            found: NDArray[Any] = values.astype(dtype, copy=False)
            return found[
                tuple(
                    0 if np.ndim(each) == 0 and not isinstance(each, slice) else slice(None)
                    for each in key
                )
            ]

        return as_needed(dims, array.shape, dtype, read, attributes)

    def _read(self, name: str, picks: list[Any], needed: NDArray[np.bool_]) -> NDArray[Any]:
        store = self._store

        def read(store: Snapshot) -> NDArray[Any]:
            values: NDArray[Any] = store.pick(name, picks, needed)
            return values

        try:
            values = read(store)
            is_whole = store.is_current()
        except StoreError:
            is_whole = False
        if not is_whole:
            self._store, values = read_whole(store.path, read, Snapshot)
        values[~needed] = store.array(name).fill
        return values


def _entries(key: Any, length: int) -> NDArray[np.int64]:
    """Which entries an index takes along a dimension of some length."""
    if isinstance(key, slice):
        return np.arange(*key.indices(length))
    return np.atleast_1d(np.asarray(key)) % length


def as_needed(
    dims: tuple[Hashable, ...],
    shape: tuple[int, ...],
    dtype: Any,
    read: Callable[[tuple[Any, ...]], NDArray[Any]],
    attributes: Mapping[Any, Any],
) -> xr.Variable:
    """A variable whose parts, each given by an orthogonal index, are read when they are used."""
    lazy = indexing.LazilyIndexedArray(_Read(shape, np.dtype(dtype), read))
    cached = indexing.MemoryCachedArray(lazy)  # type: ignore[no-untyped-call]
    return xr.Variable(dims, cached, dict(attributes))


class _Read(BackendArray):
    """An array whose parts a function reads."""

    def __init__(
        self,
        shape: tuple[int, ...],
        dtype: np.dtype[Any],
        read: Callable[[tuple[Any, ...]], NDArray[Any]],
    ) -> None:
        self.shape, self.dtype, self._read = shape, dtype, read

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

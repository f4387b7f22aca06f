"""A store as xarray opens it: what is done, read as it is needed."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.finished import Finished
from pipeline.store.variables import is_coordinate


class Committed(BackendEntrypoint):
    """Opens a store as a dataset whose data are read, and checked, when they are used."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open the store in a folder.

        Raises
        ------
        StoreError
            If there is no readable store.
        """
        store = Finished(filename_or_obj)
        found = {}
        for name, metadata in store.metadata.items():
            attributes = {k: v for k, v in metadata["attributes"].items() if k != "_FillValue"}
            dims = metadata["dimension_names"]
            if is_coordinate(name):
                found[name] = xr.Variable(dims, np.array(store.axes[name]), attributes)
            elif name == "status":
                found[name] = xr.Variable(dims, store.flags, attributes)
            else:
                found[name] = _variable(store, name, dims, attributes)
        coordinates = {name: found.pop(name) for name in list(found) if is_coordinate(name)}
        return xr.Dataset(found, coordinates, store.attributes)


def _variable(store: Finished, name: str, dims: Any, attributes: Mapping[str, Any]) -> xr.Variable:
    """A variable that has fill values where a point is not done."""
    shape, dtype = store.shape(name), store.dtype(name)
    dtype = np.dtypes.StringDType() if dtype.hasobject else dtype

    def read(key: tuple[Any, ...]) -> NDArray[Any]:
        picks = [_entries(each, n) for each, n in zip(key, shape, strict=True)]
        found: NDArray[Any] = store.pick(name, picks).astype(dtype, copy=False)
        return found[
            tuple(
                0 if np.ndim(each) == 0 and not isinstance(each, slice) else slice(None)
                for each in key
            )
        ]

    return as_needed(dims, shape, dtype, read, attributes)


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

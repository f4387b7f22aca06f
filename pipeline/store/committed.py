"""What is committed to a store, for xarray to read as it is needed, and nothing that is not.

A point that was cut short has data on the disk, too, and one that is being written has some of
them. So the status is read first, and the data of points that are not done by then are NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.folder import DAMAGED, UNREADABLE, Place, StoreError, folder_of, read_metadata
from pipeline.store.variables import COLUMNS, DONE, FIELDS

__all__ = ["Committed", "as_needed"]


class Committed(BackendEntrypoint):
    """Opens a store as a dataset whose data are read, and checked, when they are used."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open the store in a folder.

        Raises
        ------
        StoreError
            If there is no readable store.
        """
        folder = folder_of(filename_or_obj)
        attributes, _ = read_metadata(folder)
        try:
            ds = xr.open_zarr(str(folder), chunks=None, consolidated=True, zarr_format=3)
            status = ds["status"].load()
        except UNREADABLE as error:
            raise StoreError(DAMAGED.format(folder, "coordinates or status")) from error
        for name, values in attributes.get("axes", {}).items():
            if not np.array_equal(ds[name].values, values):
                raise StoreError(DAMAGED.format(folder, name))
        done = (status == DONE).variable
        variables = {
            name: _committed(folder, str(name), data.variable, done)
            for name, data in ds.data_vars.items()
            if name != "status"
        }
        found: xr.Dataset = ds.assign(variables)
        return found


def _committed(folder: Place, name: str, stored: xr.Variable, done: xr.Variable) -> xr.Variable:
    """The same variable, NaN where a point is not done."""
    leads = name in COLUMNS or name in FIELDS

    def read(key: tuple[Any, ...]) -> NDArray[Any]:
        try:
            values = np.array(stored[key].values)
        except UNREADABLE as error:
            raise StoreError(DAMAGED.format(folder, name)) from error
        if leads:
            is_done = done[key[: done.ndim]].values
            values[~is_done] = np.nan
        return values

    return as_needed(stored.dims, stored.shape, stored.dtype, read, stored.attrs)


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

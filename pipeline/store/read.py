"""A store as a dataset: xarray on Zarr, with points that are not done as NaN."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from pipeline.store.place import PathLike, StoreError, is_lack_of_memory, place_of
from pipeline.store.points import missing_chunks
from pipeline.store.root import read_root
from pipeline.store.schema import DONE, PENDING, RECORDS, is_coordinate
from pipeline.store.write import DAMAGED, UNREADABLE
from tribo.types import Mask

_OF_ALL = ("status", "asked")


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store, which may be written to meanwhile, as it is now.

    Parameters
    ----------
    path : str or path
        Folder or address of the store.

    Returns
    -------
    Dataset
        Axes in the order of the store; attributes as plain data. Data are read when they are used.

    Raises
    ------
    StoreError
        If there is no readable store, or done points lack chunks.
    """
    place = place_of(path)
    root = read_root(place)
    try:
        ds = xr.open_zarr(
            place.zarr(read_only=True),
            chunks=None,
            consolidated=True,
            decode_cf=False,
            zarr_format=3,  # or it looks for the files of format 2 too
        )
        ds = ds.set_coords([str(name) for name in ds.variables if is_coordinate(str(name))])
        flags: NDArray[np.int8] = ds["status"].values
        ds["asked"].load()
    except (*UNREADABLE, KeyError, TypeError) as error:
        if is_lack_of_memory(error):  # nothing is damaged
            raise
        raise StoreError(DAMAGED.format(place, "its axes or statuses")) from error
    if ds.attrs["axes"] != root.axes:
        return open_store(path)  # it has grown in between
    for name in ds.coords:
        if ds[name].values.tolist() != root.axes.get(str(name)):
            raise StoreError(DAMAGED.format(place, f"the axis {name}"))
    if missing := missing_chunks(place, root, flags):
        names = ", ".join(sorted(missing))
        raise StoreError(DAMAGED.format(place, names))
    variables: dict[str, xr.Variable] = {}
    for name in map(str, ds.data_vars):
        if name not in _OF_ALL:
            mask = flags != PENDING if name in RECORDS else flags == DONE
            variables[name] = _where(ds[name].variable, mask, DAMAGED.format(place, name))
    opened: xr.Dataset = ds.assign(variables).assign_attrs(root.attributes)
    return opened


class _Masked(BackendArray):
    """A variable of which the entries of some points alone are shown."""

    def __init__(self, variable: xr.Variable, mask: Mask, fault: str, fill: Any) -> None:
        # Text as Python's, since xarray writes no other to netCDF.
        is_text = variable.dtype.kind == "T"
        self.shape, self.dtype = variable.shape, np.dtype(object) if is_text else variable.dtype
        self._variable, self._mask, self._fault, self._fill = variable, mask, fault, fill

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def _read(self, key: tuple[Any, ...]) -> Any:
        """Read a part that is given by an orthogonal index."""
        try:
            values = np.array(self._variable[key].values, self.dtype)
        except UNREADABLE as error:
            if is_lack_of_memory(error):  # nothing is damaged
                raise
            raise StoreError(self._fault) from error
        mask = xr.Variable(self._variable.dims[: self._mask.ndim], self._mask)
        shown = mask[key[: self._mask.ndim]].values
        values[~shown] = self._fill
        return values


def _where(variable: xr.Variable, mask: Mask, fault: str) -> xr.Variable:
    """Show entries of a variable within a mask alone, and read them when they are used."""
    kind = variable.dtype.kind
    fill = np.nan if kind == "f" else 0 if kind in "iu" else ""
    lazy = indexing.LazilyIndexedArray(_Masked(variable, mask, fault, fill))
    # As xarray wraps what it opens itself: read once, and writable in memory.
    writable = indexing.CopyOnWriteArray(lazy)  # type: ignore[arg-type]
    cached = indexing.MemoryCachedArray(writable)  # type: ignore[no-untyped-call]
    return xr.Variable(variable.dims, cached, variable.attrs)

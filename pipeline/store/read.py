"""A store as a dataset of xarray, with points that are not done as NaN."""

from __future__ import annotations

import itertools
from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from pipeline.store.layout import made_coordinates
from pipeline.store.place import (
    KEPT,
    Mark,
    PathLike,
    StoreError,
    StorePlace,
    damaged,
    place_of,
    reaches,
    reads,
    steadily,
)
from pipeline.store.root import read_root
from pipeline.store.schema import DONE, INPUTS, MADE, PENDING, RECORDS, is_coordinate
from pipeline.store.write import Store
from tribo.types import Mask


def open_store(path: PathLike) -> xr.Dataset:
    """Open a store, which may be written to meanwhile, as it is now; data are read when used.

    Raise a `StoreError` if there is no readable store, or done points lack chunks.
    """
    return xr.open_dataset(str(place_of(path)), engine=_Backend, chunks=None)


class _Backend(BackendEntrypoint):
    """Backend of xarray for a store, which takes axes and metadata from its root."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> xr.Dataset:
        """Open a store; no variable may be dropped."""
        return steadily(filename_or_obj, self._opened)

    def _opened(self, place: StorePlace) -> xr.Dataset:
        mark, root = place.mark(), read_root(place)
        seen = _Generation(place, mark, root.facts.generation)
        store = Store(place, root)  # statuses first: a point that was done stays whole
        done = store.flags == DONE
        with reaches(place):
            keys = place.keys(store.arrays)
        of_points = itertools.filterfalse(is_coordinate, store.arrays)
        if lost := [name for name in of_points if store.lacks(name, done, keys)]:
            raise StoreError(damaged(place, ", ".join(sorted(lost))))
        present: dict[str, Any] = {"status": store.flags, "asked": store.asked}
        present |= store.axes | made_coordinates(store.sweep, store.axes)
        variables = {}
        for name, array in store.arrays.items():
            if name == INPUTS:
                present[name] = store.read(name, ...)
            elif name in store.axes:
                present[name] = np.array(store.axes[name], array.dtype)
            elif name not in present:
                mask = store.flags != PENDING if name in RECORDS else done
                present[name] = indexing.LazilyIndexedArray(_Masked(store, name, mask, seen))
            dims, attributes = array.metadata.dimension_names, array.metadata.attributes
            shown = {key: value for key, value in attributes.items() if key != "coordinates"}
            variables[name] = xr.Variable(dims, present[name], shown)
        variables["status"].encoding["keeper"] = Keeper(place)
        along = {*store.axes, *MADE, "own_grid"}
        coords = {name: variables.pop(name) for name in [*variables] if name in along}
        return xr.Dataset(variables, coords, root.attributes)


class _Generation:
    """The generation of a store, in which each point has its place in the arrays."""

    def __init__(self, place: StorePlace, mark: Mark, generation: int) -> None:
        self._place, self._mark, self._generation = place, mark, generation

    def __deepcopy__(self, _: Any) -> _Generation:
        return self

    def require(self) -> None:
        """Raise a `StoreError` if points have moved since the store was opened."""
        if (mark := self._place.mark()) == self._mark:
            return
        place = place_of(str(self._place))  # which may lie between its two renames
        if read_root(place).facts.generation != self._generation:
            raise StoreError(f"{self._place} has grown since it was opened; open it again")
        self._mark = mark


class _Masked(BackendArray):
    """A variable that shows the entries of some points alone."""

    def __init__(self, store: Store, name: str, mask: Mask, seen: _Generation) -> None:
        self._place, self._name, self._mask, self._seen = store.place, name, mask, seen
        self._array = store.arrays[name]
        self.shape, self.dtype = self._array.shape, self._array.dtype
        if self.dtype.kind == "T":  # text as Python's, since xarray writes no other to netCDF
            self.dtype = np.dtype(object)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._read
        )

    def _read(self, key: tuple[Any, ...]) -> Any:
        """Read a part that is given by an orthogonal index."""
        try:
            with reads(self._place, self._name):
                values = np.array(self._array.oindex[key], self.dtype)
        finally:
            self._seen.require()
        mask = xr.Variable(self._array.metadata.dimension_names[: self._mask.ndim], self._mask)
        values[~mask[key[: self._mask.ndim]].values] = self._array.fill_value
        return values


class Keeper:
    """Keeps what commands make of a dataset in the store that it is read from."""

    def __init__(self, place: StorePlace) -> None:
        self._place = place
        self.may_keep = False  # True while a run reads, which writes anyway

    def __deepcopy__(self, _: Any) -> Keeper:
        return self

    def kept(self, name: str) -> bytes | None:
        """Content that is kept under a name; None if there is none."""
        with suppress(OSError):
            return self._place.read(KEPT + name)
        return None

    def keep(self, name: str, content: bytes) -> None:
        """Keep content under a name, if this may write to the store and can."""
        with suppress(OSError):
            if self.may_keep:
                self._place.put({KEPT + name: content})

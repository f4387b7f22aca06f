"""The points of a store that are done, and nothing else.

A point that was cut short has data on the disk, too, and one that is being written has some of its
data. So the status is read first, and the data of points that are not done by then are NaN. Data
that a done point lacks are an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store.checked import Checked
from pipeline.store.folder import DAMAGED, PathLike, StoreError
from pipeline.store.variables import DONE, PENDING
from pipeline.store.whole import read_whole


class Finished:
    """Reads what was done when a store was opened, also after it has grown or was compacted.

    Parameters
    ----------
    path : str or path
        Folder or address of the store.

    Attributes
    ----------
    attributes : dict
        Attributes of the root group.
    metadata : dict
        Metadata of each array, by its name.
    axes : dict of list
        Values along each dimension and of each input drawn, in the order of the store.
    flags : ndarray of int
        Status by place.

    Raises
    ------
    StoreError
        If there is no readable store.
    """

    def __init__(self, path: PathLike) -> None:
        self._store, self.flags = read_whole(path, _checked, Checked)
        self.attributes, self.metadata = self._store.attributes, self._store.metadata
        self.axes = self._store.axes
        self._arrays = {name: self._store.array(name) for name in self.metadata}
        self._done, self._known = self.flags == DONE, self.flags != PENDING

    def shape(self, name: str) -> tuple[int, ...]:
        """Size of a variable along each of its dimensions."""
        return self._arrays[name].shape

    def dtype(self, name: str) -> np.dtype[Any]:
        """Type of the values of a variable; object for text."""
        return self._arrays[name].dtype

    def pick(self, name: str, picks: Sequence[NDArray[np.int64]]) -> NDArray[Any]:
        """Read a part of a variable of points; fill values where a point is not done.

        Parameters
        ----------
        name : str
            Name of the variable.
        picks : sequence of ndarray of int
            Indices of the entries along each dimension.

        Raises
        ------
        StoreError
            If something cannot be read, or a point lacks it.
        """
        if name == "status":
            return self.flags[np.ix_(*picks)]
        known = self._known if name == "message" else self._done
        needed = known[np.ix_(*picks[: known.ndim])]
        store = self._store

        def read(store: Checked) -> NDArray[Any]:
            values: NDArray[Any] = store.pick(name, picks, needed)
            return values

        try:
            values = read(store)
            is_whole = store.is_current()
        except StoreError:
            is_whole = False
        if not is_whole:
            self._store, values = read_whole(store.path, read, Checked)
        values[~needed] = self._arrays[name].fill
        return values


def _checked(store: Checked) -> NDArray[np.int8]:
    """Status by place, of a store whose coordinates are as they were committed."""
    for name in store.axes:
        if not store.has_coordinate(name):
            raise StoreError(DAMAGED.format(store.path, name))
    flags: NDArray[np.int8] = store.flags()[0]
    return flags

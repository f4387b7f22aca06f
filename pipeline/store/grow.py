"""Growth of a store whose axes no longer ascend if values are put at their ends.

The larger store is made beside the old one, in order, and then put in its place by two renames.
Whoever opens the name between them finishes the second (`pipeline.store.place.place_of`). The file
of the lock is linked into the larger store, so that the lock stays held throughout.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.store.files import sync
from pipeline.store.layout import arrays_of, blocks
from pipeline.store.place import LOCK, ROOT, Folder, larger, smaller
from pipeline.store.root import root_document
from pipeline.store.schema import AT_END, PENDING, STEPPED, is_coordinate
from pipeline.store.write import Store
from tribo.types import Indices

_ABSENT = -1


def goes_on(before: Mapping[str, Sequence[Any]], after: Mapping[str, Sequence[Any]]) -> bool:
    """True if values are added to axes at their ends alone.

    Examples
    --------
    >>> goes_on({"load": [1.0, 2.0]}, {"load": [1.0, 2.0, 3.0]})
    True
    >>> goes_on({"step": [-1, 0]}, {"step": [-2, -1, 0]})
    False
    """
    return all(list(after[name][: len(values)]) == list(values) for name, values in before.items())


def replace_by_larger(
    store: Store,
    attributes: Mapping[str, Any],
    contents: Mapping[str, bytes],
    metadata: Mapping[str, Any],
) -> None:
    """Replace a store by a larger one with these attributes, documents and metadata of arrays."""
    assert isinstance(store.place, Folder)
    path = store.place.path
    remove_unfinished(path)
    beside = Folder(larger(path))
    (beside.path / LOCK).parent.mkdir(parents=True)
    (beside.path / LOCK).hardlink_to(path / LOCK)
    beside.put(contents)
    _copy(store, arrays_of(beside, metadata, read_only=False), attributes["axes"], beside.path)
    beside.put({ROOT: root_document(attributes, metadata)})
    sync(path.parent)
    path.rename(smaller(path))
    try:
        beside.path.rename(path)
    except OSError:
        if not (path / ROOT).exists():  # unless a reader has finished it
            raise
    sync(path.parent)
    remove_unfinished(path)


def remove_unfinished(path: Path) -> None:
    """Remove what a growth that was killed has left beside a store, whose lock is held."""
    for folder in (larger(path), smaller(path)):
        if folder.exists():
            shutil.rmtree(folder)


def _copy(
    store: Store, arrays: Mapping[str, Any], axes: Mapping[str, Sequence[Any]], folder: Path
) -> None:
    """Copy what is stored of points to their places in larger arrays."""
    places = [_places(store.axes[dim], axes[dim]) for dim in store.dims]
    begun = store.flags != PENDING
    shape = arrays["status"].shape
    where = np.zeros(shape, bool)
    inverse = [{int(old): new for new, old in enumerate(along)} for along in places]
    for index in np.argwhere(begun | (store.asked != 0)):
        where[tuple(along[int(i)] for along, i in zip(inverse, index, strict=True))] = True
    size = arrays["status"].chunks
    for name, array in arrays.items():
        if name in AT_END:
            _link(store, name, inverse, folder)
        elif not is_coordinate(name):
            for _, block in blocks(where, size):
                array[block] = _part(store, name, array, block, places)


def _places(before: Sequence[Any], after: Sequence[Any]) -> Indices:
    """Place in the old axis of each value of the new one, where it has one."""
    numbers = {value: number for number, value in enumerate(before)}
    return np.array([numbers.get(value, _ABSENT) for value in after])


def _part(
    store: Store, name: str, array: Any, block: tuple[slice, ...], places: Sequence[Indices]
) -> Any:
    """A chunk of a larger array, with what the store has of it."""
    part = array[block]
    along = [of_dim[one] for of_dim, one in zip(places, block, strict=True)]
    present = [np.flatnonzero(one != _ABSENT) for one in along]
    if not all(one.size for one in present):
        return part
    old = tuple(one[at] for one, at in zip(along, present, strict=True))
    values = store.read_at(name, old)
    if name in STEPPED:  # which are counted back from the end
        part[(*np.ix_(*present), slice(-values.shape[len(old)], None))] = values
    else:
        part[np.ix_(*present)] = values
    return part


def _link(store: Store, name: str, inverse: Sequence[Mapping[int, int]], folder: Path) -> None:
    """Link the files of a field, one for each point, to their new names."""
    assert isinstance(store.place, Folder)
    with suppress(FileNotFoundError), os.scandir(store.place.path / name) as entries:
        for entry in entries:
            first, *numbers = entry.name.split(".")
            if first != "c" or not all(number.isdigit() for number in numbers):
                continue
            index, rest = numbers[: len(inverse)], numbers[len(inverse) :]
            new = [str(of_dim[int(i)]) for of_dim, i in zip(inverse, index, strict=True)]
            (folder / name / ".".join(["c", *new, *rest])).hardlink_to(entry.path)

"""Which points of a store are sound, block by block: many points are read and hashed together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from pipeline.store.checked import Checked
from pipeline.store.folder import StoreError
from pipeline.store.identity import checksums
from pipeline.store.variables import BULK_COLUMNS, BULK_FIELDS, COLUMNS, DONE, FIELDS, HASHED
from pipeline.sweep.model import Point
from tribo.types import Array, Mask

_BYTES = 2**24  # of the data that are read at a time, unless a chunk holds more

_Block = tuple[slice, ...]


def sound(
    store: Checked,
    flags: NDArray[np.int8],
    places: Mask,
    progress: Callable[[int], None] = lambda number: None,
) -> Mask:
    """Tell with which points nothing is wrong, as far as can be told of many at a time.

    Parameters
    ----------
    store : Checked
    flags : ndarray of int
        Status of each point.
    places : ndarray of bool
        Points to look at.
    progress : callable, optional
        Called after each block with how many of them were read.

    Returns
    -------
    ndarray of bool
        Points that are done and intact, or are not done, and have nothing that cannot be read. It
        is False for all of a block of which something cannot be read; the store tells more of each
        point by `Checked.fault` and `Checked.unreadable`.
    """
    found = np.zeros_like(places)
    for block in _blocks(store, places):
        done = places[block] & (flags[block] == DONE)
        others = places[block] & ~done
        with suppress(StoreError):
            if done.any():
                done = _intact(store, block, done)
            if others.any():
                for name in store.names:
                    store.pick(name, _picks(store, name, block))
            found[block] = done | others
        progress(int(np.count_nonzero(places[block])))
    return found


def _blocks(store: Checked, places: Mask) -> Iterator[_Block]:
    """Blocks with any of these places; each is of whole chunks, as many as are read at a time."""
    arrays = [store.array(name) for name in store.names]
    each = sum(8 * math.prod(array.shape[places.ndim :]) for array in arrays)
    sizes = list(store.array("status").chunks)
    sizes[-1] *= max(1, _BYTES // (each * math.prod(sizes)))
    spans = (range(0, n, size) for n, size in zip(places.shape, sizes, strict=True))
    for begin in itertools.product(*spans):
        block = tuple(slice(at, at + size) for at, size in zip(begin, sizes, strict=True))
        if places[block].any():
            yield block


def _points(store: Checked, block: _Block, places: Mask) -> list[Point]:
    """Points at some places of a block."""
    within = zip(block, np.nonzero(places), strict=True)
    return store.points_at([each.start + along for each, along in within])


def _picks(store: Checked, name: str, block: _Block) -> list[range]:
    """Indices of all that a variable holds at the points of a block."""
    shape = store.array(name).shape
    lead = [range(*each.indices(n)) for each, n in zip(block, shape, strict=False)]
    return [*lead, *map(range, shape[len(block) :])]


def _intact(store: Checked, block: _Block, places: Mask) -> Mask:
    """Which of the places of a block hold what their checksums were taken of."""
    kept = {*COLUMNS, *BULK_COLUMNS, *FIELDS, *BULK_FIELDS, "checksum"}
    data: dict[str, Array] = {}
    for name in store.names:
        if name != "status":
            values = store.pick(name, _picks(store, name, block), places)
            if name in kept:
                data[name] = values[places]
    points = _points(store, block, places)
    stored = data.pop("checksum")
    steps = np.count_nonzero(np.isfinite(data["time"]), axis=-1)
    bare = np.array([store.lacks_fields(point) for point in points], bool)
    fields = {*FIELDS, *BULK_FIELDS} if "pressure" in data else set()
    is_old = store.attributes["format"] < HASHED
    same = np.zeros(len(points), bool)
    for count, is_bare in {*zip(steps.tolist(), bare.tolist(), strict=True)}:
        (alike,) = np.nonzero((steps == count) & (bare == is_bare))
        parts = {
            name: values[alike] if name in fields else values[alike, :count]
            for name, values in data.items()
            if not (is_bare and name in fields)
        }
        own = [None if is_old else points[i] for i in alike]
        same[alike] = checksums(parts, own) == stored[alike]
    found = np.zeros_like(places)
    found[places] = same
    return found

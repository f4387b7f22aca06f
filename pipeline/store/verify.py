"""Damage of a store: points that do not have their checksums, and files that several points share.

What `irg verify` names, `irg run` makes pending, and computes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pipeline.store.checksum import SIGNED, checksum
from pipeline.store.files import THREADS
from pipeline.store.layout import (
    Slices,
    arrays_of,
    blocks,
    chunk_key,
    documents,
    field_key,
    made_coordinates,
    slices_of,
    spread_ids,
)
from pipeline.store.lock import held
from pipeline.store.place import (
    Bucket,
    DamagedError,
    PathLike,
    place_of,
    reaches,
    reads,
    writes,
)
from pipeline.store.progress import FailedPoint
from pipeline.store.root import find_root, read_root, require_same_scene
from pipeline.store.schema import (
    AT_END,
    DONE,
    OF_POINT,
    PENDING,
    RECORDS,
    SCENE_ID,
    STEPPED,
    is_coordinate,
    variables_of,
)
from pipeline.store.write import Store
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report, silent
from tribo.types import Mask

_MARKS = ("status", "asked")
_TOLD = {*RECORDS} - {*_MARKS, "steps"}  # also of a point that failed

_Index = tuple[int, ...]


@shown
@dataclass(frozen=True, slots=True)
class Verification:
    """Result of reading a whole store."""

    done: int  #: Points that are done and intact.
    damaged: tuple[FailedPoint, ...]  #: Points that are damaged.
    shared: tuple[str, ...]  #: Damaged coordinates and files, which several points share.

    @property
    def is_clean(self) -> bool:
        """True if nothing was damaged."""
        return not (self.damaged or self.shared)


def verify_store(path: PathLike, progress: Report | None = None) -> Verification:
    """Read everything in a store, name what is damaged, and write nothing.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use.
    progress : callable, optional
        Called now and then with a `Progress`, whose parts are the points that are read.

    Raises
    ------
    StoreError
        If there is no readable store, or any file of it cannot be read now.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """
    place = place_of(path)
    store = Store(place, read_root(place), is_damaged=True)
    damage = _find_damage(store, progress or silent)
    return Verification(
        done=int(np.count_nonzero(store.flags == DONE))
        - sum(bool(store.flags[index] == DONE) for index in damage.points),
        damaged=tuple(damage.points.values()),
        shared=(*damage.chunks, *_differing_coordinates(store)),
    )


def mend_store(path: PathLike, sweep: Sweep) -> int:
    """Make damaged points of a folder pending; return how many there are.

    Raise as `writing` does. Nothing is changed in a store of another scene, nor in a bucket.
    """
    place = place_of(path)
    if isinstance(place, Bucket) or not find_root(place):
        return 0
    with held(place) as lock:
        root = read_root(place)
        require_same_scene(place, root, sweep)
        store = Store(place, root, lock, is_damaged=True)
        damage = _find_damage(store, silent)
        # First: a point that is done is whole, also after a kill in between.
        store.write({}, dict.fromkeys(damage.points, PENDING))
        with writes(place):
            for name, block in damage.chunks.values():
                store.arrays[name][block] = store.arrays[name].fill_value
        return len(damage.points)


class _Damage(NamedTuple):
    """Damaged points by their places, and chunks that cannot be read by their keys."""

    points: dict[_Index, FailedPoint]
    chunks: dict[str, tuple[str, Slices]]  # variable, and the points of the chunk


def _find_damage(store: Store, progress: Report) -> _Damage:
    """Read all chunks of points, and the marks into the store; write nothing."""
    damage = _Damage({}, {})
    with reaches(store.place):
        keys = store.place.keys()
        begun = [
            (numbers, block)
            for numbers, block in blocks(np.ones(store.flags.shape, bool), store.block)
            if any(chunk_key(name, numbers) in keys for name in RECORDS)
        ]
        for numbers, block in begun:
            _read_marks(store, damage, numbers, block)
        keys = store.place.keys()  # a writer may have finished points meanwhile
        names = [n for n in store.arrays if not (n in _MARKS or n in AT_END or is_coordinate(n))]
        count, total = 0, int(np.count_nonzero(store.flags == DONE))
        for numbers, block in begun:
            values = read_chunks(store, names, numbers, keys)
            damage.chunks.update(
                (key, (name, block))
                for name in names
                if values[name] is None
                for key in keys.intersection(store.chunk_keys(name, numbers))
            )
            for index, point in points_in(store, block, store.flags != PENDING):
                if fault := _fault(store, index, point, values):
                    damage.points[index] = _damaged(store, point, fault)
            count += int(np.count_nonzero(store.flags[block] == DONE))
            progress(Progress(done=count, total=total))
    return damage


def _read_marks(store: Store, damage: _Damage, numbers: _Index, block: Slices) -> None:
    """Read statuses and points asked for; these are damaged in a chunk that has lost its statuses.

    A run writes both before it computes, statuses first.
    """
    for name, marks in (("status", store.flags), ("asked", store.asked)):
        key = chunk_key(name, numbers)
        is_there = store.place.read(key) is not None
        if (values := _read(store, name, numbers, is_there)) is not None:
            marks[block] = values
        elif is_there or name == "status" or store.flags[block].any():
            damage.chunks[key] = name, block
    if chunk_key("status", numbers) in damage.chunks:
        for index, point in points_in(store, block, store.asked == 1):
            damage.points[index] = _damaged(store, point, "status cannot be read")


def _read(store: Store, name: str, numbers: _Index, is_there: bool) -> Any:
    """Values in the chunks of these numbers; None if any is missing or damaged."""
    if is_there:
        with suppress(DamagedError):
            return store.read(name, slices_of(numbers, store.block))
    return None


def read_chunks(
    store: Store, names: Sequence[str], numbers: _Index, keys: set[str]
) -> dict[str, Any]:
    """Values of variables in the chunks of these numbers, None where lost."""

    def read(name: str) -> Any:
        lacked = (key for key in store.chunk_keys(name, numbers) if key not in keys)
        with reaches(store.place):  # also of a link, behind which nobody looks
            is_there = all(store.place.read(key) is not None for key in lacked)
        return _read(store, name, numbers, is_there)

    with ThreadPoolExecutor(THREADS) as threads:  # which an object store answers side by side
        return dict(zip(names, threads.map(read, names), strict=True))


def points_in(store: Store, block: Slices, mask: Mask) -> Iterator[tuple[_Index, Point]]:
    """Points of a mask in a block, with their places."""
    indices = np.argwhere(mask[block]) + [part.start for part in block]
    yield from zip(map(tuple, indices.tolist()), store.points_at([*indices.T]), strict=True)


def _damaged(store: Store, point: Point, fault: str) -> FailedPoint:
    return FailedPoint(*point[:2], fault, point.variant, store.in_words(point))


def _fault(store: Store, index: _Index, point: Point, values: Mapping[str, Any]) -> str:
    """Fault of a point by the values of its chunk, None for lost ones; empty if it has none."""
    entries = stored_entries(store, index, values)
    if lost := sorted(name for name, entry in entries.items() if entry is None):
        return f"{', '.join(lost)} cannot be read"
    if store.flags[index] != DONE:
        return ""
    is_right = entries["checksum"] == checksum(
        store.simulated.at(point), point, signed_data(entries)
    )
    return "" if is_right else "the data are not those that were computed"


def stored_entries(store: Store, index: _Index, values: Mapping[str, Any]) -> dict[str, Any]:
    """What a store has of a point, by the values of its chunk; None for what is lost."""
    is_done, within = store.flags[index] == DONE, store.within(index)
    entries: dict[str, Any] = {
        name: None if of_chunk is None else of_chunk[within]
        for name, of_chunk in values.items()
        if is_done or name in _TOLD
    }
    if is_done and entries["steps"] is not None:
        steps = int(entries["steps"])
        for name in entries.keys() & STEPPED.keys():
            if entries[name] is not None:
                entries[name] = entries[name][len(entries[name]) - steps :]
    if is_done:
        fields = store.arrays.keys() & AT_END.keys()
        entries |= {name: store.place.read(field_key(name, index)) for name in fields}
    return entries


def signed_data(entries: Mapping[str, Any]) -> dict[str, Any]:
    """What the checksum of a point covers."""
    return {
        name: entries[name] for name in entries.keys() & {*STEPPED, *AT_END, *OF_POINT, *SIGNED}
    }


def _differing_coordinates(store: Store) -> Iterator[str]:
    """Coordinates that have other values than the root, which plain xarray reads.

    A growth that was killed may have left arrays longer than the root says.
    """
    values: dict[str, Any] = store.axes | made_coordinates(store.sweep, store.axes)
    values[SCENE_ID] = spread_ids(store.sweep, store.axes, store.root.ids)
    wanted = variables_of(store.sweep)
    _, metadata = documents(wanted, values, store.root.facts.points_per_chunk)
    metadata = {name: metadata[name] for name in values.keys() & metadata.keys()}
    for name, array in sorted(arrays_of(store.place, metadata, read_only=True).items()):
        is_right = False
        with suppress(DamagedError), reads(store.place, name):
            found = array[...]
            is_real, expected = found.dtype.kind == "f", np.array(values[name], found.dtype)
            is_right = np.array_equal(found, expected, equal_nan=is_real)
        if not is_right:
            yield name

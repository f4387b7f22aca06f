"""Damage of a store: points whose data are not those that their checksums were taken of.

Repair makes damaged points pending, so that the next run computes them again.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.store.attributes import checksum
from pipeline.store.files import THREADS
from pipeline.store.layout import Slices, blocks, chunk_key, field_key, slices_of
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    PathLike,
    Place,
    StoreError,
    place_of,
    reaches,
    steadily,
    writes,
)
from pipeline.store.progress import FailedPoint
from pipeline.store.root import read_root
from pipeline.store.schema import AT_END, DONE, PENDING, RECORDS, STEPPED, is_coordinate
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from tribo.types import Mask

_BESIDE = ("checksum", "steps", "warning_flags")
_OTHER = "the data are not those that were computed"


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of reading a whole store.

    Attributes
    ----------
    done : int
        Points that are done and intact.
    damaged : tuple of FailedPoint
        Points that are damaged; repair makes them pending.
    shared : tuple of str
        Faults of coordinates and metadata, which belong to no point.
    without_status : tuple of Point
        Points that are complete, but have no readable status; repair makes them done.
    repaired : bool
        True if all of that was repaired.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.shared
    (24, (), ())
    """

    done: int
    damaged: tuple[FailedPoint, ...]
    shared: tuple[str, ...]
    without_status: tuple[Point, ...]
    repaired: bool

    @property
    def is_clean(self) -> bool:
        """True if nothing was damaged."""
        return not (self.damaged or self.shared)


def verify_store(
    path: PathLike, repair: bool = False, progress: Callable[[int, int], None] | None = None
) -> Verification:
    """Read everything in a store and name what is damaged.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use unless it is to be repaired.
    repair : bool
        True to make damaged points pending, and to restore shared data.
    progress : callable, optional
        Called now and then with how many points are read, and how many there are.

    Raises
    ------
    StoreError
        If there is no readable store, or it is to be repaired while in use.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.is_clean
    (24, True)
    """

    def read(place: Place, lock: Lock | None = None) -> Verification:
        return examined(Store(place, read_root(place), lock, is_damaged=True), repair, progress)

    if not repair:
        return steadily(path, read)
    read_root(place := place_of(path))  # before a lock is laid in what is no store
    with held(place) as lock:
        return read(place, lock)


def examined(
    store: Store,
    repair: bool,
    progress: Callable[[int, int], None] | None = None,
    chunks: Container[tuple[int, ...]] | None = None,
) -> Verification:
    """Read all of an open store, or only these chunks of points; see `verify_store`."""
    with writes(store.place) if repair else reaches(store.place):
        return _examined(store, repair, progress, chunks)


def _examined(
    store: Store,
    repair: bool,
    progress: Callable[[int, int], None] | None,
    chunks: Container[tuple[int, ...]] | None,
) -> Verification:
    shared, keys = [*_shared_faults(store, repair)], store.place.keys()
    begun = [
        (numbers, block)
        for numbers, block in blocks(np.ones(store.flags.shape, bool), store.block)
        if any(chunk_key(name, numbers) in keys for name in RECORDS)
        and (chunks is None or numbers in chunks)
    ]
    unknown, lost = _read_marks(store, begun, keys, shared)
    keys = store.place.keys()  # again: a writer may have finished points meanwhile
    apart = {*filter(is_coordinate, store.arrays), *AT_END, "status", "asked"}
    total, count = int(np.count_nonzero(store.flags == DONE)), 0
    damaged: dict[tuple[int, ...], FailedPoint] = {}
    complete: list[Point] = []
    for numbers, block in begun:
        values = {n: _read(store, n, numbers, keys) for n in store.arrays if n not in apart}
        lost += [
            (name, block)
            for name, of_block in values.items()
            if of_block is None and not keys.isdisjoint(store.chunk_keys(name, numbers))
        ]
        indices = np.argwhere((store.flags != PENDING)[block] | unknown[block])
        indices += [part.start for part in block]
        for point, index in zip(store.points_at([*indices.T]), map(tuple, indices), strict=True):
            entries = _entries(store, index, values, keys)
            is_done = bool(unknown[index] or store.flags[index] == DONE)
            reason = _fault(store, point, entries, is_done)
            if reason and not unknown[index]:
                place = store.in_words(point)
                damaged[index] = FailedPoint(
                    point.load, point.velocity, reason, point.variant, place
                )
            elif unknown[index] and not reason:
                complete.append(point)
        count += int(np.count_nonzero(store.flags[block] == DONE))
        if progress:
            progress(count, total)
    done = total - sum(bool(store.flags[index] == DONE) for index in damaged)
    if repair:
        _repair(store, lost, damaged, unknown, complete)
        done = int(np.count_nonzero(store.flags == DONE))
    return Verification(
        done=done,
        damaged=tuple(damaged.values()),
        shared=tuple(dict.fromkeys(shared)),
        without_status=tuple(complete),
        repaired=repair,
    )


def _read_marks(
    store: Store,
    begun: Iterable[tuple[tuple[int, ...], Slices]],
    keys: set[str],
    shared: list[str],
) -> tuple[Mask, list[tuple[str, Slices]]]:
    """Read statuses and points asked for; points whose status is unknown, and chunks that are lost.

    Faults are added to those that belong to no point.
    """
    unknown, lost = np.zeros(store.flags.shape, bool), []
    for numbers, block in begun:
        statuses, asked = (_read(store, name, numbers, keys) for name in ("status", "asked"))
        store.flags[block] = PENDING if statuses is None else statuses
        store.asked[block] = store.flags[block] != PENDING if asked is None else asked
        present = [name for name in ("status", "checksum") if chunk_key(name, numbers) in keys]
        unknown[block] = statuses is None and bool(present)
        if statuses is None and "status" in present:
            shared.append("the statuses are damaged")
        if asked is None and (chunk_key("asked", numbers) in keys or store.asked[block].any()):
            shared.append("the points that the last run asked for are damaged")
            lost.append(("asked", block))
    return unknown, lost


def _read(store: Store, name: str, numbers: tuple[int, ...], keys: set[str]) -> Any:
    """Values in the chunks of these numbers; None if any is lost."""
    if not keys.issuperset(store.chunk_keys(name, numbers)):
        return None
    try:
        return store.read(name, slices_of(numbers, store.arrays[name].chunks[: len(numbers)]))
    except StoreError:
        return None


def _entries(
    store: Store, index: tuple[int, ...], values: Mapping[str, Any], keys: set[str]
) -> dict[str, Any]:
    """Values of one point, of which those of its block are read already; None where lost."""
    within = tuple(i % n for i, n in zip(index, store.block, strict=True))
    of_block = {
        name: None if entries is None else entries[within] for name, entries in values.items()
    }
    fields = store.arrays.keys() & AT_END.keys()
    return of_block | {name: _read_or_none(store.place, field_key(name, index)) for name in fields}


def _read_or_none(place: Place, key: str) -> bytes | None:
    """Content of a key; None where it is lost, or cannot be read."""
    try:
        return place.read(key)
    except OSError:
        return None


def _fault(store: Store, point: Point, entries: Mapping[str, Any], is_done: bool) -> str:
    """Fault of a point by its entries, of which lost ones are None; empty if it has none."""
    if lost := [name for name in RECORDS.keys() & entries.keys() if entries[name] is None]:
        return _unreadable(sorted(lost))
    simulated = store.simulated.at(point)
    own = entries if is_done else {name: entries[name] for name in entries.keys() & RECORDS.keys()}
    return _fault_of_data(simulated, point, own)


def faults_at(store: Store, indices: Iterable[tuple[int, ...]]) -> Iterator[tuple[Point, str]]:
    """Done points at some places, each with the fault of its data; empty if it has none."""
    keys, of_chunk = store.place.keys(), dict[tuple[int, ...], list[tuple[int, ...]]]()
    names = [name for name in store.arrays if name in STEPPED or name in _BESIDE]
    for index in sorted(indices):
        numbers = tuple(i // n for i, n in zip(index, store.block, strict=True))
        of_chunk.setdefault(numbers, []).append(index)
    for numbers, members in of_chunk.items():
        with ThreadPoolExecutor(THREADS) as threads:  # which an object store answers side by side
            parts = threads.map(lambda name, at=numbers: _read(store, name, at, keys), names)
            values = dict(zip(names, parts, strict=True))
        points = store.points_at([*np.transpose(members)])
        for index, point in zip(members, points, strict=True):
            entries = _entries(store, index, values, keys)
            yield point, _fault_of_data(store.simulated.at(point), point, entries)


def _fault_of_data(simulated: str, point: Point, entries: Mapping[str, Any]) -> str:
    """Fault of the data of a point by its entries, lost ones None; empty if they are sound."""
    checked = {*STEPPED, *AT_END, "warning_flags"}
    data = {name: entries[name] for name in entries.keys() & checked}
    needed = data | {name: entries[name] for name in ("checksum", "steps")}
    if lost := sorted(name for name, values in needed.items() if values is None):
        return _unreadable(lost)
    steps = int(needed["steps"])
    data |= {name: data[name][-steps:] for name in data.keys() & STEPPED.keys()}
    return "" if needed["checksum"] == checksum(simulated, point, data) else _OTHER


def _unreadable(names: Iterable[str]) -> str:
    return f"{', '.join(names)} cannot be read"


def _repair(
    store: Store,
    lost: Iterable[tuple[str, Slices]],
    damaged: Collection[tuple[int, ...]],
    unknown: Mask,
    complete: Iterable[Point],
) -> None:
    """Make damaged points pending, and write lost chunks anew."""
    pending = dict.fromkeys([*map(tuple, np.argwhere(unknown)), *damaged], PENDING)
    store.write({}, pending)  # first: a point that is done is whole, also after a kill in between
    for name, block in lost:
        array = store.arrays[name]
        array[block] = store.asked[block] if name == "asked" else array.fill_value
    for index, name in itertools.product(damaged, store.arrays.keys() & AT_END.keys()):
        store.arrays[name][index] = store.arrays[name].fill_value
    store.write({}, {store.index(point): DONE for point in complete})


def _shared_faults(store: Store, repair: bool) -> Iterator[str]:
    """Faults of coordinates and metadata, which are restored from the root if so desired."""
    for name, expected in store.root.arrays.items():
        key = f"{name}/{ROOT}"
        if not _is_same(store.place.read(key), expected):
            yield f"the metadata of {name} are damaged"
            if repair:
                store.place.put({key: json.dumps(expected).encode()})
        if is_coordinate(name):
            try:
                values = store.read(name, ...).tolist()
            except StoreError:
                values = None
            if values != store.axes[name]:
                yield f"the coordinate {name} is damaged"
                if repair:
                    store.arrays[name][:] = np.array(store.axes[name])


def _is_same(content: bytes | None, expected: Mapping[str, Any]) -> bool:
    """True if metadata are as in the root, but for a growth that was cut short."""
    try:
        return bool(json.loads(content or b"") | {"shape": expected["shape"]} == expected)
    except (ValueError, TypeError, RecursionError):
        return False

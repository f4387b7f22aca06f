"""Damage of a store, and its repair: points whose data do not have their checksums."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.store.attributes import checksum
from pipeline.store.files import THREADS
from pipeline.store.layout import (
    Slices,
    blocks,
    chunk_key,
    chunk_numbers,
    field_key,
    slices_of,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    Folder,
    PathLike,
    StoreError,
    StorePlace,
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

_MARKS = ("status", "asked")
_BESIDE = ("checksum", "steps", "warning_flags")
_OTHER = "the data are not those that were computed"
_SEEN = "status/seen"
"""Key of the list of the files of a store as the last run left them."""

_Index = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of reading a whole store."""

    done: int  #: Points that are done and intact.
    damaged: tuple[FailedPoint, ...]  #: Points that are damaged; repair makes them pending.
    shared: tuple[str, ...]  #: Faults of coordinates and metadata, which belong to no point.
    #: Points that are complete, but have no readable status; repair makes them done.
    without_status: tuple[Point, ...]
    repaired: bool  #: True if all of that was repaired.

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
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """

    def read(place: StorePlace, lock: Lock | None = None) -> Verification:
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
    chunks: Container[_Index] | None = None,
) -> Verification:
    """Read all of an open store, or only these chunks of points; see `verify_store`."""
    with writes(store.place) if repair else reaches(store.place):
        shared, keys = [*_shared_faults(store, repair)], store.place.keys()
        begun = [
            (numbers, block)
            for numbers, block in blocks(np.ones(store.flags.shape, bool), store.block)
            if any(chunk_key(name, numbers) in keys for name in RECORDS)
            and (chunks is None or numbers in chunks)
        ]
        unknown, lost = _read_marks(store, begun, keys, shared)
        keys = store.place.keys()  # again: a writer may have finished points meanwhile
        names = [n for n in store.arrays if not (n in _MARKS or n in AT_END or is_coordinate(n))]
        total, count = int(np.count_nonzero(store.flags == DONE)), 0
        damaged: dict[_Index, FailedPoint] = {}
        complete: list[Point] = []
        for numbers, block in begun:
            values = _values(store, names, numbers, keys)
            lost += [
                (name, block)
                for name in names
                if values[name] is None and not keys.isdisjoint(store.chunk_keys(name, numbers))
            ]
            indices = np.argwhere((store.flags != PENDING)[block] | unknown[block])
            indices += [part.start for part in block]
            places = [*map(tuple, indices)]
            for index, point, entries in _points(store, places, values, keys):
                is_done = bool(unknown[index] or store.flags[index] == DONE)
                fault = _fault(store, point, entries, is_done)
                if fault and not unknown[index]:
                    damaged[index] = FailedPoint(
                        *point[:2], fault, point.variant, store.in_words(point)
                    )
                elif unknown[index] and not fault:
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
    store: Store, begun: Iterable[tuple[_Index, Slices]], keys: set[str], shared: list[str]
) -> tuple[Mask, list[tuple[str, Slices]]]:
    """Read statuses and points asked for, add faults; points of unknown status, chunks lost."""
    unknown, lost = np.zeros(store.flags.shape, bool), []
    for numbers, block in begun:
        statuses, asked = (_read(store, name, numbers, keys) for name in _MARKS)
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


def _read(store: Store, name: str, numbers: _Index, keys: set[str]) -> Any:
    """Values in the chunks of these numbers; None if any is lost."""
    if not keys.issuperset(store.chunk_keys(name, numbers)):
        return None
    try:
        return store.read(name, slices_of(numbers, store.arrays[name].chunks[: len(numbers)]))
    except StoreError:
        return None


def _values(store: Store, names: Sequence[str], numbers: _Index, keys: set[str]) -> dict[str, Any]:
    """Values of variables in the chunks of these numbers, None where lost."""
    with ThreadPoolExecutor(THREADS) as threads:  # which an object store answers side by side
        values = threads.map(lambda name: _read(store, name, numbers, keys), names)
        return dict(zip(names, values, strict=True))


def _points(
    store: Store, indices: Sequence[_Index], values: Mapping[str, Any], keys: set[str]
) -> Iterator[tuple[_Index, Point, dict[str, Any]]]:
    """Points at places in one block, each with its own of the block's values and its fields."""
    fields = sorted(store.arrays.keys() & AT_END.keys())
    points = store.points_at([*np.transpose(indices)])
    for index, point in zip(indices, points, strict=True):
        within = store.within(index)
        entries = {name: None if of is None else of[within] for name, of in values.items()}
        entries |= {name: _read_field(store.place, name, index) for name in fields}
        yield index, point, entries


def _read_field(place: StorePlace, name: str, index: _Index) -> bytes | None:
    """A field of a point as it is encoded; None if it is lost."""
    with suppress(OSError):
        return place.read(field_key(name, index))
    return None


def faults_at(store: Store, indices: Iterable[_Index]) -> Iterator[tuple[Point, str]]:
    """Done points at some places, each with the fault of its data; empty if it has none."""
    keys, of_chunk = store.place.keys(), dict[_Index, list[_Index]]()
    names = [name for name in store.arrays if name in STEPPED or name in _BESIDE]
    for index in sorted(indices):
        of_chunk.setdefault(store.chunk_of(index), []).append(index)
    for numbers, members in of_chunk.items():
        values = _values(store, names, numbers, keys)
        for _, point, entries in _points(store, members, values, keys):
            yield point, _fault(store, point, entries)


def _fault(store: Store, point: Point, entries: Mapping[str, Any], is_done: bool = True) -> str:
    """Fault of a point by its entries, of which lost ones are None; empty if it has none."""
    told = RECORDS.keys() - {"steps"}  # of a point that failed, whose chunk may have no steps yet
    entries = {name: entries[name] for name in entries if is_done or name in told}
    if lost := sorted(name for name, values in entries.items() if values is None):
        return f"{', '.join(lost)} cannot be read"
    steps = int(entries.get("steps", 0))
    data = {name: entries[name][-steps:] for name in entries.keys() & STEPPED.keys()}
    data |= {name: entries[name] for name in entries.keys() & {*AT_END, "warning_flags"}}
    expected = checksum(store.simulated.at(point), point, data)
    return "" if entries["checksum"] == expected else _OTHER


def _repair(
    store: Store,
    lost: Iterable[tuple[str, Slices]],
    damaged: Collection[_Index],
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


def note_files(store: Store) -> None:
    """Write the list of the files of a store, whose lock is held."""
    if isinstance(store.place, Folder):
        store.place.put({_SEEN: json.dumps(_files(store.place)).encode()})


def changed_chunks(store: Store) -> set[_Index] | None:
    """Chunks with a file that differs from the list in name, size or time; None without a list."""
    assert isinstance(store.place, Folder)
    now, listed = _files(store.place), None
    with suppress(ValueError):
        listed = json.loads(store.place.read(_SEEN) or b"")
    if not isinstance(listed, dict):
        return None
    chunks = set()
    for key in listed.keys() | now.keys():
        name, _, file = key.partition("/")
        numbers = chunk_numbers(file)[: len(store.dims)]
        is_of_points = len(numbers) == len(store.dims) and name in store.arrays
        if is_of_points and listed.get(key) != now.get(key):  # a restored file is older, not newer
            if name in AT_END:
                numbers = store.chunk_of(numbers)
            chunks.add(numbers)
    return chunks


def _files(folder: Folder) -> dict[str, list[int]]:
    """Size and time of each chunk of a store [B, ns]."""
    files = {}
    for array in os.scandir(folder.path):
        with suppress(NotADirectoryError), os.scandir(array) as entries:
            for entry in entries:
                if chunk_numbers(entry.name):
                    state = entry.stat()
                    files[f"{array.name}/{entry.name}"] = [state.st_size, state.st_mtime_ns]
    return files

"""Damage of a store, and its repair: points whose data do not have their checksums."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from pipeline.store.checksum import checksum
from pipeline.store.files import THREADS
from pipeline.store.layout import (
    Slices,
    blocks,
    chunk_key,
    chunk_numbers,
    field_key,
    made_coordinates,
    slices_of,
)
from pipeline.store.lock import Lock, held
from pipeline.store.place import (
    ROOT,
    DamagedError,
    Folder,
    PathLike,
    StorePlace,
    UnreadableError,
    keep_beside,
    place_of,
    reaches,
    steadily,
    writes,
)
from pipeline.store.progress import FailedPoint
from pipeline.store.root import ELSEWHERE, LostRootError, Root, copied, read_root, root_fault
from pipeline.store.schema import AT_END, DONE, MADE, PENDING, RECORDS, STEPPED, is_coordinate
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report, silent
from tribo import InputError
from tribo.types import Mask

_MARKS = ("status", "asked")
_BESIDE = ("checksum", "steps", "warning_flags")
_TIMED = {"time", "sliding_distance"}
_OTHER = "the data are not those that were computed"
_SEEN = "status/seen"
"""Key of the list of the files of a store as the last run left them."""

_Index = tuple[int, ...]


@shown
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
    path: PathLike, repair: bool = False, progress: Report | None = None
) -> Verification:
    """Read everything in a store and name what is damaged.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use unless it is to be repaired.
    repair : bool
        True to mark damaged points as pending, and restore shared data. What is replaced is kept
        in the folder ``damaged`` of the store.
    progress : callable, optional
        Called now and then with a `Progress`, whose parts are the points that are read.

    Raises
    ------
    StoreError
        If there is no readable store, any file of it cannot be read now, its root is older than
        its arrays, or it is to be repaired while in use. Then nothing is changed.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """

    def read(place: StorePlace, lock: Lock | None = None) -> Verification:
        store = Store(place, read_root(place), lock, is_damaged=True)
        found = _found(store, progress or silent)
        done = found.sound(store) - (0 if repair else len(found.complete))
        if repair:
            _repair(store, found)
            _restore(store, found.shared)
        return Verification(
            done=done,
            damaged=tuple(found.damaged.values()),
            shared=tuple(dict.fromkeys(found.shared.faults.values())),
            without_status=tuple(found.complete),
            repaired=repair,
        )

    if not repair:
        return steadily(path, read)
    read_root(place := place_of(path, to_write=True))  # before a lock is laid in what is no store
    with held(place) as lock:
        return read(place, lock)


def repaired(store: Store, chunks: Container[_Index] | None = None) -> int:
    """Make points pending that are proved wrong, of these chunks of points or all; their number.

    Axes and metadata of arrays stay as they are.
    """
    found = _found(store, chunks=chunks)
    _repair(store, found)
    return len(found.damaged)


@dataclass(slots=True)
class _Found:
    """What reading a store has found; nothing in it is of a file that could not be read."""

    shared: _Shared
    unmarked: Mask  # points whose status is lost
    lost: list[tuple[str, _Index, Slices]]  # chunks that cannot be decoded, by array
    keys: set[str] = field(default_factory=set)  # keys in the store
    damaged: dict[_Index, FailedPoint] = field(default_factory=dict)
    complete: list[Point] = field(default_factory=list)  # sound, of those without a status

    def sound(self, store: Store) -> int:
        """Number of points that agree with their checksums."""
        done = int(np.count_nonzero(store.flags == DONE)) + len(self.complete)
        return done - sum(bool(store.flags[index] == DONE) for index in self.damaged)


def _found(
    store: Store,
    progress: Report = silent,
    chunks: Container[_Index] | None = None,
    root_may_be_wrong: bool = True,
) -> _Found:
    """Read all of an open store, or only these chunks of points, and write nothing.

    Raise an `UnreadableError` if anything cannot be read now, a `LostRootError` if all was read and
    the root is not that of the arrays.
    """
    with reaches(store.place):
        keys = store.place.keys()
        shared = _shared(store, keys)
        begun = [
            (numbers, block)
            for numbers, block in blocks(np.ones(store.flags.shape, bool), store.block)
            if any(chunk_key(name, numbers) in keys for name in RECORDS)
            and (chunks is None or numbers in chunks)
        ]
        found = _Found(shared, *_read_marks(store, begun, keys, shared.faults))
        found.keys = keys = store.place.keys()  # a writer may have finished points meanwhile
        names = [n for n in store.arrays if not (n in _MARKS or n in AT_END or is_coordinate(n))]
        total, count = int(np.count_nonzero(store.flags == DONE)), 0
        for numbers, block in begun:
            values = _values(store, names, numbers, keys)
            found.lost += [
                (name, numbers, block)
                for name in names
                if values[name] is None and not keys.isdisjoint(store.chunk_keys(name, numbers))
            ]
            _judge(store, found, block, values)
            count += int(np.count_nonzero(store.flags[block] == DONE))
            progress(Progress(done=count, total=total))
        if chunks is None and root_may_be_wrong:
            _require_right_root(store, found)
        return found


def _judge(store: Store, found: _Found, block: Slices, values: Mapping[str, Any]) -> None:
    """Compare the points of a block that are done, or have no status, with their checksums."""
    indices = np.argwhere((store.flags != PENDING)[block] | found.unmarked[block])
    indices += [part.start for part in block]
    for index, point, entries in _points(store, [*map(tuple, indices)], values):
        unmarked = bool(found.unmarked[index])
        fault = _fault(store, point, entries, unmarked or bool(store.flags[index] == DONE))
        if fault and not unmarked:
            place = store.in_words(point)
            found.damaged[index] = FailedPoint(*point[:2], fault, point.variant, place)
        elif unmarked and not fault:
            found.complete.append(point)


def agrees(store: Store) -> bool:
    """True if nothing is damaged, or of each scene with a point proved wrong another is sound."""
    found = _found(store)
    sound, wrong = store.flags == DONE, np.zeros(store.flags.shape, bool)
    for index, point in found.damaged.items():
        sound[index], wrong[index] = False, point.message == _OTHER
    of_sound, of_wrong = (
        {*map(store.simulated.group, store.points_at(np.nonzero(mask)))} for mask in (sound, wrong)
    )
    of_sound |= {*map(store.simulated.group, found.complete)}
    return bool(of_sound or not found.damaged) and of_wrong <= of_sound


def require_right_root(place: StorePlace, root: Root) -> tuple[str, ...]:
    """Raise as `_found` if a root is not that of its arrays; else name faults of what they copy."""
    store = Store(place, root, is_damaged=True)
    with reaches(place):
        shared = _shared(store, place.keys())
    if shared.faults or shared.is_resized:
        _found(store)
    return (*shared.faults.values(),)


def _require_right_root(store: Store, found: _Found) -> None:
    """Raise an error if the arrays have axes by which more points are sound than by the root's.

    Then the root is older than they are, or newer, as after a copy of one without the other. Where
    none of both makes the points sound, nothing tells which files belong together.
    """
    place, shared = store.place, found.shared
    if not (shared.faults or shared.is_resized):
        return
    with suppress(DamagedError):
        _, facts, arrays = copied(place, store.arrays)
        root = Root(store.sweep, facts, arrays)
        if root.axes != store.axes and not root_fault(facts, arrays):
            other = Store(place, root, is_damaged=True)
            if _found(other, root_may_be_wrong=False).sound(other) > found.sound(store):
                raise LostRootError(
                    f"{place}: {ROOT} is older than its arrays, or newer; nothing was changed; "
                    f"{ELSEWHERE}"
                )
    is_any_wrong = found.damaged or np.count_nonzero(found.unmarked) > len(found.complete)
    if shared.foreign and is_any_wrong:
        raise UnreadableError(
            f"{place}: {ROOT} and {len(shared.foreign)} other files, such as {shared.foreign[0]}, "
            "are not of one store, or not of one time, and points agree with neither; nothing was "
            "changed: copy the whole store anew, or write to another one"
        )


def _read_marks(
    store: Store, begun: Iterable[tuple[_Index, Slices]], keys: set[str], faults: dict[str, str]
) -> tuple[Mask, list[tuple[str, _Index, Slices]]]:
    """Read statuses and points asked for, add faults; points without a status, chunks lost."""
    unmarked, lost = np.zeros(store.flags.shape, bool), []
    for numbers, block in begun:
        statuses, asked = (_read(store, name, numbers, keys) for name in _MARKS)
        store.flags[block] = PENDING if statuses is None else statuses
        store.asked[block] = store.flags[block] != PENDING if asked is None else asked
        present = [name for name in ("status", "checksum") if chunk_key(name, numbers) in keys]
        unmarked[block] = statuses is None and bool(present)
        if statuses is None and "status" in present:
            faults["status"] = "the statuses are damaged"
            lost.append(("status", numbers, block))
        if asked is None and (chunk_key("asked", numbers) in keys or store.asked[block].any()):
            faults["asked"] = "the points that the last run asked for are damaged"
            lost.append(("asked", numbers, block))
    return unmarked, lost


def _read(store: Store, name: str, numbers: _Index, keys: set[str]) -> Any:
    """Values in the chunks of these numbers; None if any is missing or damaged."""
    if not keys.issuperset(store.chunk_keys(name, numbers)):
        return None
    with suppress(DamagedError):
        return store.read(name, slices_of(numbers, store.arrays[name].chunks[: len(numbers)]))
    return None


def _values(store: Store, names: Sequence[str], numbers: _Index, keys: set[str]) -> dict[str, Any]:
    """Values of variables in the chunks of these numbers, None where lost."""
    with ThreadPoolExecutor(THREADS) as threads:  # which an object store answers side by side
        values = threads.map(lambda name: _read(store, name, numbers, keys), names)
        return dict(zip(names, values, strict=True))


def _points(
    store: Store, indices: Sequence[_Index], values: Mapping[str, Any]
) -> Iterator[tuple[_Index, Point, dict[str, Any]]]:
    """Points at places in one block, each with its own of the block's values and its fields."""
    fields = sorted(store.arrays.keys() & AT_END.keys())
    points = store.points_at([*np.transpose(indices)])
    for index, point in zip(indices, points, strict=True):
        within = store.within(index)
        entries = {name: None if of is None else of[within] for name, of in values.items()}
        entries |= {name: store.place.read(field_key(name, index)) for name in fields}
        yield index, point, entries


def _fault(store: Store, point: Point, entries: Mapping[str, Any], is_done: bool = True) -> str:
    """Fault of a point by its entries, None for lost ones; empty if there is no fault."""
    told = RECORDS.keys() - {"steps"}  # a point that failed may have no steps in its chunk yet
    entries = {name: entries[name] for name in entries if is_done or name in told}
    if lost := sorted(name for name, values in entries.items() if values is None):
        return f"{', '.join(lost)} cannot be read"
    steps = int(entries.get("steps", 0))
    data = {name: entries[name][-steps:] for name in entries.keys() & STEPPED.keys()}
    data |= {name: entries[name] for name in entries.keys() & {*AT_END, "warning_flags"}}
    try:
        simulated = store.simulated.at(point)
    except InputError:  # a root that is too old may not know the value: not proved wrong
        return ""
    return "" if entries["checksum"] == checksum(simulated, point, data) else _OTHER


def _repair(store: Store, found: _Found) -> None:
    """Make damaged points pending, and remove chunks that cannot be decoded; keep both beside."""
    place, undecodable = store.place, set[str]()
    for name, numbers, _ in found.lost:
        undecodable |= found.keys.intersection(store.chunk_keys(name, numbers))
    wrong, of_points = {*undecodable}, [*itertools.filterfalse(is_coordinate, store.arrays)]
    for index, point in found.damaged.items():
        if point.message == _OTHER:
            for name in of_points:
                numbers = index if name in AT_END else store.chunk_of(index)
                wrong |= found.keys.intersection(store.chunk_keys(name, numbers))
    with writes(place):
        keep_beside(place, sorted(wrong))
        pending = [*map(tuple, np.argwhere(found.unmarked)), *found.damaged]
        # First: a point that is done is whole, also after a kill in between.
        store.write({}, dict.fromkeys(pending, PENDING))
        for name, _, block in found.lost:
            if name == "asked":
                store.arrays[name][block] = store.asked[block]
        for key in undecodable:
            if not key.startswith(tuple(f"{name}/" for name in _MARKS)):
                place.remove(key)
        store.write({}, {store.index(point): DONE for point in found.complete})


class _Shared(NamedTuple):
    """How what arrays copy of the root differs from it."""

    faults: dict[str, str]  # by array or key
    foreign: list[str]  # files that can be read, and are those of another root
    is_resized: bool  # arrays are longer, or shorter, as a growth leaves them that was cut short


def _shared(store: Store, keys: set[str]) -> _Shared:
    """Compare metadata and coordinates with the root."""
    faults, foreign, is_resized = dict[str, str](), list[str](), False
    expected_values = store.axes | made_coordinates(store.sweep, store.axes)
    for name, expected in store.root.arrays.items():
        key = f"{name}/{ROOT}"
        document = _document(store.place.read(key))
        if document | {"shape": expected["shape"]} != expected:
            faults[key] = f"the metadata of {name} are damaged"
            foreign += [key] if document else []
        else:
            is_resized |= document.get("shape") != expected["shape"]
        if name in store.axes or name in MADE:
            values = None
            with suppress(DamagedError):
                values = store.read(name, ...)
            if values is None or not _is_same(values, expected_values[name]):
                faults[name] = f"the coordinate {name} is damaged"
                is_there = values is not None and not keys.isdisjoint(store.chunk_keys(name, ()))
                foreign += [name] if is_there else []
    # Another scene makes both otherwise, since the distance is the velocity times the time.
    if len(_TIMED & faults.keys()) == 1 and any(store.axes["velocity"]):
        foreign = [name for name in foreign if name not in _TIMED]
    return _Shared(faults, foreign, is_resized)


def _is_same(values: Any, expected: Any) -> bool:
    """True for values of a coordinate that are those expected, NaN at the same places."""
    expected = np.array(expected, values.dtype)
    is_real = values.dtype.kind == "f"
    return bool(np.array_equal(values, expected, equal_nan=is_real))


def _document(content: bytes | None) -> dict[str, Any]:
    """Content of a JSON document; empty if it is lost, or nested without an end."""
    with suppress(ValueError, RecursionError):
        document = json.loads(content or b"")
        if isinstance(document, dict):
            return document
    return {}


def _restore(store: Store, shared: _Shared) -> None:
    """Write metadata and coordinates as the root has them, and keep the others beside."""
    values = store.axes | made_coordinates(store.sweep, store.axes)
    for name, expected in store.root.arrays.items():
        key = f"{name}/{ROOT}"
        with writes(store.place):
            if key in shared.faults:
                keep_beside(store.place, [key])
                store.place.put({key: json.dumps(expected).encode()})
            if name in values and name in shared.faults:
                keep_beside(store.place, store.chunk_keys(name, ()))
                store.arrays[name][...] = np.array(values[name])


def note_files(store: Store) -> None:
    """Write the list of the files of a store, whose lock is held."""
    if isinstance(store.place, Folder):
        with writes(store.place):
            store.place.put({_SEEN: json.dumps(_files(store.place)).encode()})


def changed_chunks(store: Store) -> set[_Index] | None:
    """Chunks with a file that differs from the list in name, size or time; None without a list."""
    assert isinstance(store.place, Folder)
    with reaches(store.place):
        now, listed = _files(store.place), _document(store.place.read(_SEEN))
    if not listed:
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
    for array in [*os.scandir(folder.path)]:
        with suppress(NotADirectoryError), os.scandir(array) as entries:
            for entry in entries:
                if chunk_numbers(entry.name):
                    state = entry.stat()
                    files[f"{array.name}/{entry.name}"] = [state.st_size, state.st_mtime_ns]
    return files

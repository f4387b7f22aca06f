"""Damage of a store: points with wrong checksums, and damaged files that several points share.

`irg verify` names it. `irg run` computes such points again, and writes such files again.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pipeline.store.checksum import checksum
from pipeline.store.files import THREADS
from pipeline.store.layout import Slices, blocks, parts_of, slices_of
from pipeline.store.lock import locked
from pipeline.store.place import Bucket, DamagedError, PathLike, io_errors, place_of
from pipeline.store.progress import FailedPoint
from pipeline.store.root_file import find_root, read_root, require_same_scene
from pipeline.store.schema import AT_END, DONE, PENDING, RECORDS, STEPPED, is_coordinate
from pipeline.store.write import Index, Store
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.stages import Progress, Report, silent

_FLAGS = ("status", "asked")
_OF_FAILED = {*RECORDS} - {*_FLAGS, "steps"}  # variables that a failed point has, too


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of checking a whole store: the number of intact points, and what is damaged."""

    done: int  #: Points that are done and intact.
    damaged: tuple[FailedPoint, ...]  #: Points that are damaged.
    shared: tuple[str, ...]  #: Damaged coordinates and files, which several points share.
    tests: Verification | None = None  #: Result for the points of tests, if there are any.

    @property
    def is_clean(self) -> bool:
        """True if nothing was damaged."""
        return not (self.damaged or self.shared) and (self.tests is None or self.tests.is_clean)


def verified(store: Store, progress: Report) -> Verification:
    """Check an open store for damage."""
    damage = _find_damage(store, progress)
    return Verification(
        done=int(np.count_nonzero(store.flags == DONE))
        - sum(bool(store.flags[index] == DONE) for index in damage.points),
        damaged=tuple(damage.points.values()),
        shared=tuple(damage.files),
        tests=verified(store.tests, silent) if store.tests else None,
    )


def mend_store(path: PathLike, sweep: Sweep) -> int:
    """Mark damaged points of a store as pending, and repair files that points share.

    Returns the number of damaged points and files. On an object store nothing is done. Raises a
    `StoreMismatchError` if the store belongs to another scene, and a `StoreError` if another
    process writes to it, or it cannot be read or written.
    """
    place = place_of(path)
    if isinstance(place, Bucket) or not find_root(place):
        return 0
    with locked(place) as lock:
        root = read_root(place)
        require_same_scene(place, root, sweep)
        store, count = Store(place, root, lock, is_damaged=True), 0
        for group in filter(None, (store, store.tests)):
            damage = _find_damage(group, silent)
            # Statuses first, so that a done point is whole even after a kill in between.
            group.write({}, dict.fromkeys(damage.points, PENDING))
            with io_errors(place, "written"):
                place.put(group.encoder(damage.files.values()))
            count += len(damage.points) + len(damage.files)
    return count


class _Damage(NamedTuple):
    """Damaged points by index, and damaged files that several points share."""

    points: dict[Index, FailedPoint]
    files: dict[str, tuple[str, Any, Any]]  # by key: variable, slices of the chunk, right values


def _find_damage(store: Store, progress: Report) -> _Damage:
    """Read all data of a store to find damage, and its flags into `store`; nothing is written."""
    damage = _Damage({}, {})
    with io_errors(store.place):
        keys = store.place.keys()
        begun = [
            (chunk, block)
            for chunk, block in blocks(np.ones(store.flags.shape, bool), store.block)
            if any(store.key(name, chunk) in keys for name in RECORDS)
        ]
        for chunk, block in begun:
            _read_flags(store, damage, chunk, block)
        for count, (_, block) in enumerate(begun, 1):
            for part, values in read_block(store, block, keys):
                is_done = (store.flags[part] == DONE).any()
                for name, of_part in values.items():
                    of_name = store.block_of(name)
                    chunk = tuple(one.start // n for one, n in zip(part, of_name, strict=True))
                    is_lost = is_done and (key := store.key(name, chunk)) not in keys
                    if of_part is None or (is_lost and not store.place.has(key)):
                        _note_chunk(store, damage, name, chunk, slices_of(chunk, of_name))
                for index, point, entries in stored_entries(store, part, values):
                    if fault := fault_of(store, point, entries):
                        words = store.in_words(point)
                        damage.points[index] = FailedPoint(*point[:2], fault, point.variant, words)
            progress(Progress(done=count, total=len(begun)))
    # Other programs read coordinates that this one computes from the root. A kill while the store
    # grew leaves wrong ones.
    for name, values in sorted(store.root.coordinates().items()):
        found = _read(store, name, ...)
        right = np.asarray(values, store.arrays[name].dtype)
        if found is None or not np.array_equal(found, right, equal_nan=right.dtype.kind == "f"):
            damage.files[store.root.prefix + name] = name, ..., values
    return damage


def _read_flags(store: Store, damage: _Damage, chunk: Index, block: Slices) -> None:
    """Read a chunk of ``status`` and ``asked`` into `store`, or note it as damaged."""
    for name, marks in (("status", store.flags), ("asked", store.asked)):
        is_there = store.place.has(store.key(name, chunk))
        if is_there and (values := _read(store, name, block)) is not None:
            marks[block] = values
        elif is_there or name == "status" or store.flags[block].any():
            _note_chunk(store, damage, name, chunk, block)


def _note_chunk(store: Store, damage: _Damage, name: str, chunk: Index, block: Slices) -> None:
    """Add a damaged chunk of the variable `name` to `damage`: fill values will replace it."""
    damage.files[store.key(name, chunk)] = name, block, store.arrays[name].fill_value


def _read(store: Store, name: str, block: Any) -> Any:
    """Values of a variable at the slices `block`; fill values if missing, None if damaged."""
    with suppress(DamagedError):
        return store.read(name, block)
    return None


def read_block(
    store: Store, block: Slices, keys: Container[str] = ()
) -> Iterator[tuple[Slices, dict[str, Any]]]:
    """Yield the parts of a chunk of points at the slices `block`: slices, and arrays by variable.

    Each part lies in a single chunk of each field, as fields have smaller chunks. A part without a
    point that is done or failed is left out, unless a file of its fields is among `keys`.
    Coordinates, ``status`` and ``asked`` are left out. A damaged variable has None for an array.
    """
    names = [name for name in store.arrays if not (name in _FLAGS or is_coordinate(name))]
    fields = [name for name in names if name in AT_END]
    block = tuple(slice(*one.indices(n)) for one, n in zip(block, store.flags.shape, strict=True))
    with ThreadPoolExecutor(THREADS) as threads:  # an object store answers them side by side
        apply = threads.map if isinstance(store.place, Bucket) else map

        def read(names: Sequence[str], at: Slices) -> dict[str, Any]:
            return dict(zip(names, apply(lambda name: _read(store, name, at), names), strict=True))

        values = read([name for name in names if name not in AT_END], block)
        sizes = store.block_of(fields[0]) if fields else ()
        for part in parts_of(block, sizes) if fields else [block]:
            if fields and not store.flags[part].any():
                chunk = [one.start // n for one, n in zip(part, sizes, strict=True)]
                if not any(store.key(name, chunk) in keys for name in fields):
                    continue
            pairs = zip(part, block, strict=True)
            within = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in pairs)
            own = {k: None if one is None else one[within] for k, one in values.items()}
            yield part, own | read(fields, part)


def stored_entries(
    store: Store, part: Slices, values: Mapping[str, Any]
) -> Iterator[tuple[Index, Point, dict[str, Any]]]:
    """Yield index, point and values by variable of each point in a part, except pending points.

    The part is at the slices `part`; `values` are from `read_block`. A damaged value is None.
    """
    inside = np.argwhere(store.flags[part] != PENDING)
    indices = inside + [one.start for one in part]
    places = (map(tuple, numbers.tolist()) for numbers in (indices, inside))
    for index, within, point in zip(*places, store.points_at([*indices.T]), strict=True):
        is_done = store.flags[index] == DONE
        entries: dict[str, Any] = {
            name: None if of_part is None else of_part[within]
            for name, of_part in values.items()
            if is_done or name in _OF_FAILED
        }
        if is_done:
            steps = entries["steps"]
            for name in entries.keys() & STEPPED.keys():
                if steps is not None and entries[name] is not None:
                    entries[name] = entries[name][len(entries[name]) - int(steps) :]
        yield index, point, entries


def fault_of(store: Store, point: Point, entries: Mapping[str, Any]) -> str:
    """Describe the fault in a point's stored values, `entries` by variable; empty without fault."""
    if lost := sorted(name for name, entry in entries.items() if entry is None):
        return f"{', '.join(lost)} cannot be read"
    if "steps" not in entries:  # it failed
        return "" if entries["message"] else "the reason for its failure is lost"
    is_right = entries["checksum"] == checksum(store.root.scene_hash(point), point, entries)
    is_whole = is_right and np.isfinite(entries["wall_time"])  # which no checksum covers
    return "" if is_whole else "the data are not those that were computed"

"""The writer of a store: one process, which commits the results of many points together.

Data are written first, the status last: a status of done means that all of a point is on the disk.
Chunks hold some hundred points, and are replaced whole with their other points as they were. They
never move, so a reader sees each point either as it was or as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.storage import StorePath

from pipeline.store.identity import record_checksum
from pipeline.store.lock import Lock
from pipeline.store.packing import packed
from pipeline.store.place import (
    LOCK,
    ROOT,
    Bucket,
    Folder,
    Place,
    StoreError,
    is_lack_of_memory,
    unwritable,
)
from pipeline.store.points import Places, Slices
from pipeline.store.root import Root, root_document
from pipeline.store.schema import (
    DONE,
    FAILED,
    PENDING,
    STEPPED,
    chunk_name,
    chunks_of,
    is_coordinate,
)
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from tribo.types import Mask

_THREADS = 8  # that wait for the disk, which then writes several files in one go
_LONGEST = 2000  # characters of a message, which somebody is to read
ABOUT = ("message", "warning_flags", "wall_time", "finished_at")
"""Variables with what is told about a point."""
UNREADABLE = (RuntimeError, ValueError, OSError)
"""Errors of Zarr and its codecs on damaged chunks."""
DAMAGED = "{}: {} cannot be read; irg verify names what is damaged, and repairs it with --repair"

_Index = tuple[int, ...]


class Store(Places):
    """A store to which this process alone writes.

    Parameters
    ----------
    place : Folder or Bucket
    root : Root
    lock : Lock, optional
        Lock that this process holds on it; without, it is only read.
    is_damaged : bool, optional
        True to take statuses that cannot be read as pending.

    Attributes
    ----------
    flags : ndarray of int
        Status of each point.
    asked : ndarray of int
        1 for each point that the last run asked for.
    unreadable : dict of ndarray of bool
        Points of which these two cannot be read, by the names ``status`` and ``asked``.

    Raises
    ------
    StoreError
        If the statuses cannot be read.
    """

    def __init__(
        self,
        place: Place,
        root: Root,
        lock: Lock | None = None,
        is_damaged: bool = False,
    ) -> None:
        super().__init__(root)
        self.place, self.lock = place, lock
        is_written = lock is not None or isinstance(place, Bucket)
        self.arrays = arrays_of(place, root.arrays, read_only=not is_written)
        self.unreadable: dict[str, Mask] = {}
        self.flags = self._whole("status", is_damaged)
        self.asked = self._whole("asked", is_damaged)

    @property
    def names(self) -> list[str]:
        """Variables of points."""
        return [name for name in self.arrays if not is_coordinate(name)]

    def _whole(self, name: str, is_damaged: bool) -> NDArray[np.int8]:
        """All of a small variable; fill values where a chunk is damaged, if any may be."""
        self.unreadable[name] = np.zeros(self.shape, bool)
        try:
            values: NDArray[np.int8] = self.read(name, ...)
        except StoreError:
            if not is_damaged:
                raise
            values = np.zeros(self.shape, np.int8)
            for _, block in self.blocks(values == 0):
                try:
                    values[block] = self.read(name, block)
                except StoreError:
                    self.unreadable[name][block] = True
        return values

    def restore_flags(self) -> None:
        """Write anew where statuses and points that were asked for cannot be read."""
        self.asked[self.unreadable["asked"] & (self.flags != PENDING)] = 1
        for name, values in (("status", self.flags), ("asked", self.asked)):
            for _, block in self.blocks(self.unreadable[name]):
                self.arrays[name][block] = values[block]

    def read(self, name: str, key: Any) -> Any:
        """Read a part of a variable.

        Raises
        ------
        StoreError
            If a chunk is damaged.
        """
        try:
            return self.arrays[name][key]
        except UNREADABLE as error:
            if is_lack_of_memory(error):  # nothing is damaged
                raise
            raise StoreError(DAMAGED.format(self.place, name)) from error

    def is_done(self, point: Point) -> bool:
        """True if a point is complete."""
        return bool(self.flags[self.index(point)] == DONE)

    def pending(self) -> list[Point]:
        """Points that the last run asked for, and that are neither done nor failed."""
        return self.points_at(np.nonzero((self.asked == 1) & (self.flags == PENDING)))

    def message(self, point: Point) -> str:
        """Reason why a point failed, or its warnings."""
        return str(self.read("message", self.index(point)))

    def commit(self, records: Iterable[PointRecord]) -> None:
        """Put points on the disk: data first, then statuses.

        Raises
        ------
        StoreError
            If they cannot be written, or the lock was lost.
        """
        values = {self.index(record.point): self._values(record) for record in records}
        self.write(values, {index: data.pop("status") for index, data in values.items()})

    def note_worker(self, versions: Mapping[str, str]) -> None:
        """Note, once, the versions of packages that a worker has; raise as `commit` does."""
        noted = self.attributes.setdefault("worker_versions", [])
        if any(entry["versions"] == versions for entry in noted):
            return
        since = datetime.now(UTC).isoformat(timespec="seconds")
        noted.append({"since": since, "versions": dict(versions)})
        self._require_lock()
        try:
            self.place.put({ROOT: root_document(self.attributes, self.metadata)})
        except OSError as error:
            raise unwritable(self.place, error) from error

    def forget(self, points: Iterable[Point]) -> None:
        """Make points pending again; raise as `commit` does."""
        self.write({}, {self.index(point): PENDING for point in points})

    def ask(self, wanted: Mask) -> None:
        """Note which points this run asks for; raise as `commit` does."""
        changed = map(tuple, np.argwhere(self.asked != wanted).tolist())
        self.asked = wanted.astype(np.int8)
        self._put_all({"asked": {index: self.asked[index] for index in changed}})

    def write(
        self, values: Mapping[_Index, Mapping[str, Any]], flags: Mapping[_Index, int]
    ) -> None:
        """Write values of points by name, and once they are on the disk statuses."""
        by_name: dict[str, dict[_Index, Any]] = {}
        chunks: dict[str, bytes] = {}
        for index, record in values.items():
            for name, value in record.items():
                if isinstance(value, bytes):
                    chunks[f"{name}/{chunk_name((*index, 0, 0))}"] = value
                else:
                    by_name.setdefault(name, {})[index] = value
        self._put_all(by_name, chunks)
        self._put_all({"status": flags})
        self._require_lock()  # a driver that came meanwhile may have read the statuses before
        for index, flag in flags.items():
            self.flags[index] = flag

    def _values(self, record: PointRecord) -> dict[str, Any]:
        """All that is stored of a point by name, its status included."""
        # Names of files in a message may be no text.
        message = record.message[:_LONGEST].encode(errors="backslashreplace").decode()
        record = packed(replace(record, message=message))
        about = {name: getattr(record, name) for name in ABOUT}
        about["record_checksum"] = record_checksum(record)
        if record.data is None:
            return about | {"status": FAILED}
        return {**record.data, **about, "checksum": record.checksum, "status": DONE}

    def _put_all(
        self, by_name: Mapping[str, Mapping[_Index, Any]], chunks: Mapping[str, bytes] | None = None
    ) -> None:
        """Write values at the indices of points, chunk by chunk and side by side."""
        self._require_lock()
        jobs: dict[tuple[str, _Index], dict[_Index, Any]] = {}
        for name, entries in by_name.items():
            sizes = chunks_of(self.metadata[name])[: self.ndim]
            for index, value in entries.items():
                chunk = tuple(i // n for i, n in zip(index, sizes, strict=True))
                jobs.setdefault((name, chunk), {})[index] = value
        try:
            self.place.put(chunks or {})
            with ThreadPoolExecutor(_THREADS) as threads:  # which ends when all have
                list(threads.map(lambda job: self._put(job[0], job[1], jobs[job]), jobs))
        except OSError as error:
            raise StoreError(
                f"{self.place} cannot be written: {error.strerror or error}; what is finished is "
                "safe, go on when there is room and permission to write"
            ) from error

    def _put(self, name: str, chunk: _Index, entries: Mapping[_Index, Any]) -> None:
        """Write values into the points of one chunk, and leave the others as they are."""
        array = self.arrays[name]
        block = self.block(chunk, chunks_of(self.metadata[name]))
        shape = [part.stop - part.start for part in block] + list(array.shape[self.ndim :])
        if name == "status":
            part = self.flags[block].copy()
        elif name == "asked":
            part = self.asked[block]
        elif len(entries) == np.prod(shape[: self.ndim]):
            part = np.full(shape, array.fill_value, array.dtype)
        else:
            part = self.read(name, block)
        for index, value in entries.items():
            within = tuple(i - axis.start for i, axis in zip(index, block, strict=True))
            if name in STEPPED:
                part[within] = np.nan
                part[(*within, slice(len(value)))] = value
            else:
                part[within] = value
        array[block] = part

    def _require_lock(self) -> None:
        if not self.lock or not isinstance(self.place, Folder):
            return
        if not self.lock.is_in_place(self.place.path / LOCK):
            raise StoreError(
                f"{self.place}: its lock ({LOCK}) was deleted or replaced while this run wrote; it "
                "stops, since another one may write now. What is finished is safe, run it again"
            )

    def blocks(self, mask: Mask) -> Iterable[tuple[tuple[int, ...], Slices]]:
        """Numbers and slices of the chunks with any of the points of a mask."""
        sizes = chunks_of(self.metadata["status"])
        counts = [-(-n // size) for n, size in zip(mask.shape, sizes, strict=True)]
        for chunk in np.ndindex(*counts):
            block = self.block(chunk, sizes)
            if mask[block].any():
                yield chunk, block


def arrays_of(place: Place, metadata: Mapping[str, Any], read_only: bool = False) -> dict[str, Any]:
    """Open the arrays of a store by the metadata of its root, which may have changed since."""
    store = place.zarr(read_only)
    # An array takes this from the time when it is opened. A chunk of nothing but fill values that
    # is not written looks like one that was lost.
    with zarr.config.set({"array.write_empty_chunks": True}):
        return {
            name: zarr.Array.from_dict(StorePath(store, name), array)
            for name, array in metadata.items()
        }


def fill_new_steps(place: Place, points: Places) -> None:
    """Write empty chunks for the steps that a store was given, where it has points already.

    So a done point has all its chunks, and one that is missing was lost.

    Parameters
    ----------
    place : Folder or Bucket
    points : Places
        Its points, with metadata that the arrays have, but not yet the root.
    """
    for name, array in arrays_of(place, points.metadata).items():
        if name not in STEPPED:
            continue
        sizes, names = chunks_of(points.metadata[name]), place.names(name)
        for chunk in {_numbers(key)[: points.ndim] for key in names if key.startswith("c.")}:
            for step in range(sizes[points.ndim], array.shape[points.ndim], sizes[points.ndim]):
                numbers = (*chunk, step // sizes[points.ndim])
                tail = (0,) * (len(sizes) - len(numbers))
                if chunk_name((*numbers, *tail)) not in names:
                    steps = slice(step, step + sizes[points.ndim])
                    array[(*points.block(chunk, sizes), steps)] = np.nan


def _numbers(key: str) -> tuple[int, ...]:
    return tuple(map(int, key.split(".")[1:]))

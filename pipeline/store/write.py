"""A store, which one process writes: it commits the results of many points together.

Data are written first, the status last: done means that all of a point is on the disk.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.store.arrays import Encoder, open_arrays
from pipeline.store.checksum import packed
from pipeline.store.layout import Slices, blocks, points_at, slices_of
from pipeline.store.lock import Lock
from pipeline.store.place import (
    LOCK,
    Bucket,
    DamagedError,
    PathLike,
    StoreError,
    StorePlace,
    damaged,
    io_errors,
    place_of,
    read_errors,
)
from pipeline.store.root import Group
from pipeline.store.root_file import read_root
from pipeline.store.schema import (
    ASKED,
    AT_END,
    DONE,
    FAILED,
    LEFT_OUT,
    MADE,
    NOT_ASKED,
    PENDING,
    STEPPED,
    path_of,
)
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from tribo.types import Indices, Mask

_ABOUT = ("message", "warning_flags", "wall_time", "checksum")  # texts and facts of a point

_MOST_KEPT = 2**28  # bytes of chunks that are not full

Index = tuple[int, ...]


class Store:
    """An open store; it may be written if this process holds its lock.

    `tests` is the store of the points of tests, if there are any. `dims` are the dimensions of
    points. `block` is the number of points in a chunk along each, except in chunks of fields.
    `flags` has the status of each point, and `asked` whether the last run was to compute it. With
    `is_damaged`, these two are not read, since their chunks may be damaged; they are 0 then.
    """

    def __init__(
        self, place: StorePlace, root: Group, lock: Lock | None = None, is_damaged: bool = False
    ) -> None:
        self.place, self.root, self.lock = place, root, lock
        self.sweep, self.axes = root.sweep, root.axes
        self.arrays = open_arrays(place.zarr(), root.arrays, root.prefix)
        self.encoder = Encoder(root.arrays, root.prefix)  # for one thread at a time
        # Chunks that this process has written, until they are full: not to be read back.
        self._kept: dict[tuple[str, Index], Any] = {}
        self.dims = root.variables["status"].dims
        self.block = tuple(root.block[dim] for dim in self.dims)
        shape = [len(self.axes[dim]) for dim in self.dims]
        labels = {dim: self.axes[dim] for dim in self.dims}
        self._numbers = [{label: n for n, label in enumerate(labels[dim])} for dim in self.dims]
        self.flags, self.asked = (
            np.zeros(shape, np.int8) if is_damaged else self.read(name, ...)
            for name in ("status", "asked")
        )
        if not (is_damaged or self.flags.all() or isinstance(place, Bucket)):  # few requests
            self._require_statuses()

        tests = root.tests
        self.tests = Store(place, tests, lock, is_damaged) if tests else None

    def _require_statuses(self) -> None:
        """Raise a `DamagedError` if a chunk of statuses is lost; it is written before `asked`."""
        is_empty = np.ones(self.flags.shape, bool)
        for chunk, block in blocks(is_empty, self.block):
            if not self.flags[block].any() and self.asked[block].any():
                with io_errors(self.place):
                    if not self.place.has(self.key("status", chunk)):
                        raise DamagedError(damaged(self.place, "status"))

    # Indices of points

    def index(self, point: Point) -> Index:
        """Index of a point along `dims`."""
        labels = {"load": point.load, "velocity": point.velocity, **dict(point[2])}
        found = zip(self.dims, self._numbers, strict=True)
        return tuple(numbers[labels[dim]] for dim, numbers in found)

    def block_of(self, name: str) -> Index:
        """Number of points in a chunk of a variable, along each of `dims`."""
        return tuple(self.arrays[name].chunks[: len(self.dims)])

    def points_at(self, where: Sequence[Indices]) -> list[Point]:
        """Points at some indices; `where` has an array for each of `dims`, as from `nonzero`."""
        return points_at(self.sweep, self.axes, self.root.variables, where)

    def in_words(self, point: Point) -> str:
        """Write a point as text, with entries as in the scene file, such as ``2 mm``."""
        return self.root.in_words(point)

    def key(self, name: str, chunk: Sequence[int]) -> str:
        """Key of a chunk of a variable, such as ``time/c.0.2.0``.

        `chunk` has the chunk's indices along the dimensions of points. Along the other dimensions
        the index is 0, since one chunk has all values of a point.
        """
        within = [0] * (self.arrays[name].ndim - len(chunk))
        return f"{self.root.prefix}{path_of(name)}/" + ".".join(map(str, ("c", *chunk, *within)))

    # Reading

    def read(self, name: str, key: Any) -> Any:
        """Read a part of a variable, at the index `key`; `StoreError` if a chunk is damaged."""
        with read_errors(self.place, name):
            return self.arrays[name][key]

    def read_steps(self, box: tuple[slice, ...]) -> dict[str, Any]:
        """Read, by name, all variables that have a value at each step, of the points in a box.

        Time, load and sliding distance at each step are added, with the shape of these points and
        their steps.
        """
        columns = {name: self.read(name, box) for name in STEPPED if name in self.arrays}
        wanted, made = self.root.variables, self.root.coordinates()
        shape = *self.flags.shape, columns["max_rise"].shape[-1]
        sizes = dict(zip(wanted["max_rise"].dims, shape, strict=True))
        for name in MADE:
            values: Any = xr.Variable(wanted[name].dims, made[name])
            columns[name] = values.set_dims(sizes).values[box]
        return columns

    def blank_fields(self) -> dict[str, Any]:
        """Fields of a point whose fields are not kept, by name: NaN everywhere."""
        return {
            name: np.full(self.arrays[name].shape[len(self.dims) :], np.nan, np.float32)
            for name in AT_END
            if name in self.arrays
        }

    def pending(self) -> list[Point]:
        """Points that the last run was to compute, and that are neither done nor failed."""
        return self.points_at(np.nonzero((self.asked == ASKED) & (self.flags == PENDING)))

    # Writing: every method raises a `StoreError` if it fails, or the lock was lost

    def commit(self, records: Iterable[PointRecord]) -> None:
        """Write the records of points: data first, then statuses, so that done points have data."""
        values, statuses = {}, {}
        for record in records:
            record = packed(record, self.root.scene_hash(record.point))
            index = self.index(record.point)
            values[index] = {name: getattr(record, name) for name in _ABOUT}
            statuses[index] = FAILED
            if record.data is not None:
                values[index] |= {**record.data, "steps": len(record.data["max_rise"])}
                statuses[index] = DONE
        self.write(values, statuses)

    def forget(self, points: Iterable[Point]) -> None:
        """Mark points as pending, so that they are computed again."""
        self.write({}, {self.index(point): PENDING for point in points})

    def mark_asked(self, points: Iterable[Point]) -> None:
        """Mark `points` in the store as those that the present run is to compute."""
        wanted = np.full_like(self.asked, NOT_ASKED)
        for point in points:
            wanted[self.index(point)] = ASKED
        # Written together, so that a lost chunk of statuses is noticed.
        self._write_flags("status", self.flags, self.asked != wanted)
        self._write_asked(wanted)

    def leave_out_pending(self) -> None:
        """Mark pending points of the present run as left out, until `ask_for` asks for them."""
        is_left_out = (self.asked == ASKED) & (self.flags == PENDING)
        self._write_asked(np.where(is_left_out, LEFT_OUT, self.asked).astype(np.int8))

    def ask_for(self, points: Iterable[Point]) -> None:
        """Mark points as those that the present run is to compute, too."""
        wanted = self.asked.copy()
        for point in points:
            wanted[self.index(point)] = ASKED
        self._write_asked(wanted)

    def _write_asked(self, wanted: NDArray[np.int8]) -> None:
        changed, self.asked = self.asked != wanted, wanted
        self._write_flags("asked", wanted, changed)

    def write(
        self, values: Mapping[Index, Mapping[str, Any]], statuses: Mapping[Index, int]
    ) -> None:
        """Write the values of points by variable, and once these are on the disk, the statuses."""
        chunks: dict[tuple[str, Index], dict[Index, Any]] = {}
        for index, of_point in values.items():
            for name, value in of_point.items():
                block = self.block_of(name)
                chunk = tuple(i // n for i, n in zip(index, block, strict=True))
                chunks.setdefault((name, chunk), {})[index] = value
        parts = (self._changed(*place, of_points) for place, of_points in chunks.items())
        with self._writes():
            self.place.put(self.encoder(parts))
        flags, changed = self.flags.copy(), np.zeros(self.flags.shape, bool)
        for index, status in statuses.items():
            flags[index], changed[index] = status, True
        self._write_flags("status", flags, changed)
        self.flags = flags
        for name, chunk in chunks:
            if self.flags[slices_of(chunk, self.block_of(name))].all():
                del self._kept[name, chunk]
        if sum(kept.nbytes for kept in self._kept.values()) > _MOST_KEPT:
            self._kept.clear()  # chunks are read again when they are needed

    def _changed(
        self, name: str, chunk: Index, values: Mapping[Index, Any]
    ) -> tuple[str, Slices, Any]:
        """Part for the `Encoder`: a chunk with new `values`, by the index of the point."""
        block = slices_of(chunk, self.block_of(name))
        if (name, chunk) not in self._kept:
            self._kept[name, chunk] = self._found(name, block)
        kept = self._kept[name, chunk]
        for index, value in values.items():
            within = tuple(i - part.start for i, part in zip(index, block, strict=True))
            if name in STEPPED:
                kept[within] = self.arrays[name].fill_value
                kept[within][-len(value) :] = value
            else:
                kept[within] = value
        return name, block, kept

    def _found(self, name: str, block: Slices) -> Any:
        """Values of a chunk before new ones; without a point there is nothing to read."""
        if (flags := self.flags[block]).any():
            return self.read(name, block)
        array = self.arrays[name]
        within = array.shape[len(self.dims) :]
        return np.full(flags.shape + within, array.fill_value, array.dtype)

    def _write_flags(self, name: str, values: NDArray[np.int8], changed: Mask) -> None:
        """Write the chunks of ``status`` or ``asked`` in which a value has changed."""
        parts = [(name, block, values[block]) for _, block in blocks(changed, self.block)]
        with self._writes():
            self.place.put(self.encoder(parts))

    @contextmanager
    def _writes(self) -> Iterator[None]:
        """Context manager: check the lock before and after; errors of the disk as `StoreError`."""
        self._require_lock()
        with io_errors(self.place, "written"):
            yield
        self._require_lock()

    def _require_lock(self) -> None:
        if self.lock and not self.lock():
            raise StoreError(
                f"{self.place}: its lock ({LOCK}) was deleted or replaced during this run, which "
                "stops: another run may write now. Finished points are safe; run the command again"
            )


def opened(path: PathLike) -> Store:
    """Open a store to read it."""
    return Store(place := place_of(path), read_root(place))


_PAUSE = 1.0  # [s] between commits: as much work as a kill may cost
_PAUSE_OF_BUCKET = 10.0  # [s], since each commit to an object store is some 50 requests
_SHARE = 10.0  # durations of a commit, as pause after it: commits take a tenth of a core at most
_LONGEST_PAUSE = 10.0  # [s] between commits, however slow the disk or busy the machine


class Writer:
    """Writes records to a store in a thread, about once a second, on an object store every 10 s.

    Errors of the thread are raised by `written` and `flush`.
    """

    def __init__(self, store: Store) -> None:
        self.store = store
        self._least = _PAUSE_OF_BUCKET if isinstance(store.place, Bucket) else _PAUSE
        self._waiting: list[PointRecord] = []
        self._writing: Future[list[PointRecord]] | None = None
        self._next = 0.0  # time of the next commit
        self._thread = ThreadPoolExecutor(1, "writer")

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        with self._thread, suppress(StoreError):  # which `flush` has raised before
            self.flush()

    def add(self, records: Iterable[PointRecord]) -> None:
        """Add records to the queue of records to write."""
        self._waiting += records

    def written(self, at_once: bool = False) -> list[PointRecord]:
        """Return records written since the last call, and begin to write waiting records.

        Writing begins once the last writing has ended, and unless `at_once` after a pause.
        """
        records = []
        if self._writing and self._writing.done():
            records, self._writing = self._writing.result(), None
        is_due = at_once or time.monotonic() >= self._next
        if self._waiting and not self._writing and is_due:
            self._writing = self._thread.submit(self._commit, self._waiting)
            self._waiting = []
        return records

    def flush(self) -> list[PointRecord]:
        """Write all waiting records; return the records written since the last call."""
        records = []
        while self._writing or self._waiting:
            records += self.written(at_once=True)
            if self._writing:
                wait([self._writing])
        return records

    def _commit(self, records: list[PointRecord]) -> list[PointRecord]:
        began = time.monotonic()
        self.store.commit(records)
        ended = time.monotonic()
        self._next = ended + min(max(self._least, _SHARE * (ended - began)), _LONGEST_PAUSE)
        return records

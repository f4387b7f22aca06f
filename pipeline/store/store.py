"""An open store, which one process writes, many points at a time.

Data are written before the status: all data of a point that is done are on the disk.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store import schema
from pipeline.store.arrays import Part, open_arrays, write_arrays
from pipeline.store.layout import Group, Slices, block_at
from pipeline.store.location import (
    MEMORY,
    ROOT,
    DamagedError,
    PathLike,
    StoreError,
    damaged,
    io_errors,
    location_of,
    read_errors,
)
from pipeline.store.lock import Lock
from pipeline.store.root import Root, read_root
from pipeline.sweep.case_table import LOAD_FACTOR
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.sweep import Point
from tribo.types import Indices, Mask

_MOST_CHARACTERS = 2000  # of a message, which stays readable

Index = tuple[int, ...]


class Store:
    """A group of an open store: its plane, or tests; this process may write it with the lock.

    `groups` are all of the store, the plane first. `flags` has the status of each point. Statuses
    that cannot be read raise a `DamagedError`; if `may_be_damaged`, all points are pending instead.
    A store that `is_new` has no files yet, and all points are pending. `unreadable` has the paths
    of the chunks that could not be read.
    """

    def __init__(
        self,
        location: Path,
        root: Root,
        lock: Lock | None = None,
        group: Group | None = None,
        may_be_damaged: bool = False,
        is_new: bool = False,
    ) -> None:
        self.location, self.root, self.lock = location, root, lock
        self.group = group or root.groups[0]
        self.sweep, self.axes, self.dims = self.group.sweep, self.group.axes, self.group.dims
        self.unreadable = set[str]()
        self.arrays = open_arrays(location, self.group.arrays, self.group.prefix)
        self._numbers = [
            {label: number for number, label in enumerate(self.axes[dim])} for dim in self.dims
        ]
        self._stamp = self._read_stamp()
        self.flags: NDArray[np.int8] = np.full(self.group.shape, schema.PENDING, np.int8)
        if not is_new:
            self._read_flags(may_be_damaged)
        self.groups = [self]
        for tests in root.groups[1:] if group is None else ():
            self.groups.append(Store(location, root, lock, tests, may_be_damaged, is_new))

    def _read_flags(self, may_be_damaged: bool) -> None:
        flags = self.try_read("status", tuple(slice(0, n) for n in self.group.shape))
        if flags is not None and (flags >= 0).all():
            self.flags = flags
        elif not may_be_damaged:
            raise damaged(self.location, "status")

    def _read_stamp(self) -> tuple[int, int] | None:
        """A value that changes if the store is replaced, but not if points are written."""
        with suppress(FileNotFoundError, NotADirectoryError):
            status = (self.location / "status" / ROOT).stat()
            return status.st_ino, status.st_mtime_ns
        return None

    # Indices of points

    def index(self, point: Point) -> Index:
        """Index of a point along `dims`."""
        labels = {"load": point.load, "velocity": point.velocity, **dict(point.case)}
        if LOAD_FACTOR in self.dims:
            labels[LOAD_FACTOR] = self.sweep.case_table.load_factor(point.case, point.load)
        numbered_dims = zip(self.dims, self._numbers, strict=True)
        return tuple(numbers[labels[dim]] for dim, numbers in numbered_dims)

    def points_where(self, mask: Any) -> list[Point]:
        """Points where a mask of the shape of `flags` is True."""
        return self.group.points_at(np.nonzero(mask))

    def pending(self) -> list[Point]:
        """Points that are needed, and neither done nor failed."""
        return self.points_where(self.flags == schema.PENDING)

    def block_of(self, name: str) -> Index:
        """Number of points in a chunk of a variable, along each of its dimensions of points."""
        dims = self.group.variables[name].dims
        return tuple(self.arrays[name].chunks[: sum(map(schema.is_of_points, dims))])

    # Reading

    def read(self, name: str, key: Any) -> Any:
        """Read a part of a variable by outer indexing; `DamagedError` if a chunk is damaged."""
        try:
            with read_errors(self.location, name):
                return self.arrays[name].oindex[key]
        finally:
            if self._read_stamp() != self._stamp:
                raise StoreError(
                    f"{self.location} was enlarged or repaired since it was opened; open it again"
                )

    def try_read(self, name: str, block: Slices) -> Any:
        """Read a variable at `block`, the slices of a written chunk; None if it is damaged."""
        chunk = [part.start // n for part, n in zip(block, self.block_of(name), strict=False)]
        inner = [0] * (self.arrays[name].ndim - len(chunk))  # other dimensions are not split
        key = ".".join(map(str, ("c", *chunk, *inner)))
        file = f"{self.group.prefix}{schema.path_of(name)}/{key}"
        with suppress(DamagedError):
            values = self.read(name, block)
            if self.location == MEMORY or (self.location / file).is_file():
                return values
        self.unreadable.add(file)
        return None

    # Writing: every method raises a `StoreError` if it fails or the lock is lost

    def commit(self, records: Iterable[PointRecord]) -> None:
        """Write the data of points, then their statuses, so that points that are done have data."""
        if records := [*records]:
            indices = np.array([self.index(record.point) for record in records])
            states = [schema.FAILED if record.data is None else schema.DONE for record in records]
            self.write(indices, self._columns(records), np.array(states, np.int8))

    def _columns(self, records: Sequence[PointRecord]) -> dict[str, list[Any]]:
        """Values of records by variable; results are None at points without them."""
        tables = [record.data or {} for record in records]
        columns: dict[str, list[Any]] = {
            name: [getattr(record, name) for record in records]
            for name in ("warning_flags", "wall_time")
        }
        if any(tables):
            columns["steps"] = [len(table.get("max_rise", ())) for table in tables]
            columns |= {name: [table.get(name) for table in tables] for name in schema.DATA}
        typed = {
            name: [
                None if value is None else np.array(value, array.dtype, order="C")
                for value in column
            ]
            for name, array in self.arrays.items()
            if (column := columns.get(name))
        }
        # File names in a message may be invalid UTF-8.
        messages = [record.message[:_MOST_CHARACTERS] for record in records]
        encoded = [message.encode(errors="backslashreplace") for message in messages]
        return typed | {"message": [message.decode() for message in encoded]}

    def create(self) -> None:
        """Write coordinates and statuses of a new store."""
        values = {"status": self.flags} | self.group.coordinates
        self.put((name, ..., values[name]) for name in values)

    def write(self, indices: Indices, values: Mapping[str, Any], states: NDArray[np.int8]) -> None:
        """Write the values of points by variable, then their statuses once the values are on disk.

        `indices` has the index of each point, shape (n, n_dim). Values at steps are those of the
        last ones. A result is None at points without it.
        """
        is_done = states == schema.DONE
        has_fields, parts = self.group.with_fields[tuple(indices.T)], list[Part]()
        for name, column in values.items():
            rows_by_chunk = defaultdict[Index, list[int]](list)
            variable_indices = self.group.point_indices(name, indices)
            for row, chunk in enumerate((variable_indices // self.block_of(name)).tolist()):
                # A point that failed must not replace times that it shares with others.
                has_value = name not in schema.DATA or is_done[row]
                if name in schema.FIELDS:
                    has_value &= has_fields[row] and column[row] is not None
                if has_value:
                    rows_by_chunk[tuple(chunk)].append(row)
            parts += [
                self._part_of_chunk(
                    name, chunk, variable_indices[rows], [column[row] for row in rows]
                )
                for chunk, rows in rows_by_chunk.items()
            ]
        self.put(parts)
        flags = self.flags.copy()
        flags[tuple(indices.T)] = states
        self.set_flags(flags)

    def _part_of_chunk(
        self, name: str, chunk: Index, indices: Indices, new_values: Sequence[Any]
    ) -> Part:
        """Part for `write_arrays`: a chunk of a variable with new values at some indices."""
        array, block = self.arrays[name], block_at(chunk, self.block_of(name))
        was_written = self.group.values_at(name, np.isin(self.flags, (schema.DONE, schema.FAILED)))[
            block
        ]
        if name not in schema.FIELDS and was_written.any():
            values = self.read(name, block)
        else:  # the chunk has no results yet
            shape = was_written.shape + array.shape[len(block) :]
            values = np.full(shape, array.fill_value, array.dtype)
        for index, value in zip(indices - [part.start for part in block], new_values, strict=True):
            if self.group.is_stepped(name):
                steps = values[tuple(index)]
                count = min(len(value), len(steps))  # steps beyond the chunk have no values
                steps[:] = array.fill_value
                steps[-count:] = value[-count:]
            else:
                values[tuple(index)] = value
        return name, block, values

    # Statuses

    def forget(self, points: Iterable[Point]) -> None:
        """Mark points as pending, so that they are computed again."""
        self.set_flags(np.where(self._mask(points), np.int8(schema.PENDING), self.flags))

    def need_only(self, points: Iterable[Point]) -> None:
        """Mark `points` as needed, and all others that are not done as not needed."""
        self.need(points := [*points])
        is_unchanged = self._mask(points) | (self.flags == schema.DONE)
        self.set_flags(np.where(is_unchanged, self.flags, np.int8(schema.NOT_NEEDED)))

    def need(self, points: Iterable[Point]) -> None:
        """Mark further points as needed."""
        is_new = self._mask(points) & (self.flags == schema.NOT_NEEDED)
        self.set_flags(np.where(is_new, np.int8(schema.PENDING), self.flags))

    def leave_out_pending(self) -> None:
        """Mark pending points as not needed, until `need` is called with them."""
        self.set_flags(
            np.where(self.flags == schema.PENDING, np.int8(schema.NOT_NEEDED), self.flags)
        )

    def _mask(self, points: Iterable[Point]) -> Mask:
        """Mask of `points`, in the shape of `flags`."""
        mask = np.zeros(self.flags.shape, bool)
        for point in points:
            mask[self.index(point)] = True
        return mask

    def set_flags(self, flags: NDArray[np.int8]) -> None:
        """Write the statuses of all points."""
        if not np.array_equal(flags, self.flags):
            self.put([("status", ..., flags)])
        self.flags = flags

    def put(self, parts: Iterable[Part]) -> None:
        """Write parts of arrays; raise a `StoreError` if the lock is lost before or after."""
        self._require_lock()
        with io_errors(self.location, "written"):
            write_arrays(self.arrays, parts)
        self._require_lock()

    def _require_lock(self) -> None:
        if self.lock and not self.lock.is_in_place():
            raise StoreError(
                f"{self.location}: the lock file ({self.lock.path}) was deleted or replaced. The "
                "run stops, because another one may be writing; finished points are saved. Run the "
                "command again"
            )


def opened(path: PathLike) -> Store:
    """Open a store to read it."""
    return Store(location := location_of(path), read_root(location))


_PAUSE = 1.0  # least time between commits [s]; a kill loses the results of this time
_SHARE = 10.0  # least pause over the duration of a commit: commits take a tenth of the time


class Writer:
    """Collects records and writes them about once a second."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self._waiting: list[PointRecord] = []
        self._next = 0.0  # time of the next commit

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(StoreError):  # `flush` has raised it before
            self.flush()

    def add(self, records: Iterable[PointRecord]) -> None:
        """Add records to the waiting ones."""
        self._waiting += records

    def flush_if_due(self) -> list[PointRecord]:
        """Write and return the waiting records if a commit is due."""
        return self.flush() if time.monotonic() >= self._next else []

    def flush(self) -> list[PointRecord]:
        """Write and return the waiting records."""
        records, self._waiting, began = self._waiting, [], time.monotonic()
        if records:
            self.store.commit(records)
            now = time.monotonic()
            self._next = now + max(_PAUSE, _SHARE * (now - began))
        return records

"""An open store, which one process writes, many points at a time.

Data are written before the status: all data of a point that is done are on the disk.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store.arrays import open_arrays, write_arrays
from pipeline.store.layout import Group, Slices, checksums
from pipeline.store.lock import Lock
from pipeline.store.place import (
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
from pipeline.store.root import Root, read_root
from pipeline.store.schema import (
    DATA,
    DONE,
    FAILED,
    FIELDS,
    NOT_NEEDED,
    PENDING,
    is_of_points,
    path_of,
)
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.stored_steps import Fields
from pipeline.sweep.sweep import Point
from tribo.types import Indices, Mask

_LONGEST = 2000  # characters of a message, which stays readable
_THREADS = 8  # concurrent requests to an object store

Index = tuple[int, ...]


@dataclass
class Damage:
    """Damaged points with the fault of each, and damaged files by key.

    The entry of a file is a part for `write_arrays`, with values that replace it.
    """

    points: dict[Index, str] = field(default_factory=dict)
    files: dict[str, tuple[str, Any, Any]] = field(default_factory=dict)


class Store:
    """An open store, or its group of tests; this process may write it if it holds the lock.

    `tests` is the group of tests, if there is one. `flags` has the status of each point. `damage`
    collects damaged points and files; if it is None, damage raises a `DamagedError`.
    """

    def __init__(
        self,
        location: StorePlace,
        root: Root,
        lock: Lock | None = None,
        damage: Damage | None = None,
        group: Group | None = None,
    ) -> None:
        self.location, self.root, self.lock, self.damage = location, root, lock, damage
        self.group = layout = group or root.plane
        self.sweep, self.axes, self.dims = layout.sweep, layout.axes, layout.dims
        self.arrays = open_arrays(location.zarr, layout.arrays, layout.prefix)
        self._numbers = [
            {label: number for number, label in enumerate(self.axes[dim])} for dim in self.dims
        ]
        self._stamp = location.stamp()
        self.flags: NDArray[np.int8] = self._read_flags()
        self.tests: Store | None = None
        if root.tests and group is None:
            self.tests = Store(location, root, lock, damage and Damage(), root.tests)

    def _read_flags(self) -> Any:
        """Read the statuses; if they are lost and `damage` is collected, all points are pending."""
        shape = self.group.shape
        flags = self.try_read("status", tuple(slice(0, n) for n in shape))
        if flags is not None and (flags >= 0).all():
            return flags
        if self.damage is None:
            raise damaged(self.location, "status")
        lost = np.full(shape, PENDING, np.int8)
        self.damage.files[self.key("status", [0] * len(shape))] = "status", ..., lost
        return lost

    @property
    def groups(self) -> list[Store]:
        """The plane, and the tests if there are any."""
        return [self, *([self.tests] if self.tests else [])]

    # Indices of points

    def fields_of(self, case: CaseName) -> Fields:
        """Which fields of the points of a case are stored."""
        return self.sweep.fields if {*self.sweep.surface_with_fields} <= {*case} else False

    def index(self, point: Point) -> Index:
        """Index of a point along `dims`."""
        labels = {"load": point.load, "velocity": point.velocity, **dict(point[2])}
        numbered_dims = zip(self.dims, self._numbers, strict=True)
        return tuple(numbers[labels[dim]] for dim, numbers in numbered_dims)

    def points_where(self, mask: Any) -> list[Point]:
        """Points where a mask of the shape of `flags` is True."""
        return self.group.points_at(np.nonzero(mask))

    def pending(self) -> list[Point]:
        """Points that are needed, and neither done nor failed."""
        return self.points_where(self.flags == PENDING)

    def block_of(self, name: str) -> Index:
        """Number of points in a chunk of a variable, along each of its dimensions of points."""
        dims = self.group.variables[name].dims
        return tuple(self.arrays[name].chunks[: sum(map(is_of_points, dims))])

    def key(self, name: str, chunk: Sequence[int]) -> str:
        """Key of a chunk of a variable, such as ``time/c.0.2.0``.

        `chunk` has the chunk's indices along the dimensions of points; other dimensions are not
        split.
        """
        within = [0] * (self.arrays[name].ndim - len(chunk))
        path = f"{self.group.prefix}{path_of(name)}"
        return f"{path}/{'.'.join(map(str, ('c', *chunk, *within)))}"

    # Reading

    def read(self, name: str, key: Any) -> Any:
        """Read a part of a variable by outer indexing; `DamagedError` if a chunk is damaged."""
        try:
            with read_errors(self.location, name):
                return self.arrays[name].oindex[key]
        finally:
            if self.location.stamp() != self._stamp:
                raise StoreError(
                    f"{self.location} was enlarged or repaired since it was opened; open it again"
                )

    def try_read(self, name: str, block: Slices) -> Any:
        """Read a variable at `block`, the slices of a chunk; None if the chunk is damaged.

        A damaged chunk is added to `damage`, with values that replace it.
        """
        try:
            return self.read(name, block)
        except DamagedError:
            if self.damage is None:
                raise
            sizes, fill = self.block_of(name), self.arrays[name].fill_value
            chunk = [part.start // n for part, n in zip(block, sizes, strict=False)]
            self.damage.files[self.key(name, chunk)] = name, block, fill
            return None

    # Writing: every method raises a `StoreError` if it fails or the lock is lost

    def commit(self, records: Iterable[PointRecord]) -> None:
        """Write the data of points, then their statuses, so that points that are done have data."""
        if records := [*records]:
            where = np.array([self.index(record.point) for record in records])
            states = [FAILED if record.data is None else DONE for record in records]
            self.write(where, self._stacked(records), np.array(states, np.int8))

    def _stacked(self, records: Sequence[PointRecord]) -> dict[str, Any]:
        """Values of records by variable; a field is None at points without it."""
        values: dict[str, Any] = {
            name: np.array([getattr(record, name) for record in records], self.arrays[name].dtype)
            for name in ("warning_flags", "wall_time")
        }
        # File names in a message may be invalid UTF-8.
        values["message"] = [
            record.message[:_LONGEST].encode(errors="backslashreplace").decode()
            for record in records
        ]
        tables = [record.data or {} for record in records]
        if not any(tables):
            return values
        steps = np.array([len(data.get("max_rise", ())) for data in tables], np.int32)
        for name in DATA.keys() & self.arrays.keys():
            if name in FIELDS:
                values[name] = [data.get(name) for data in tables]
                continue
            array, step_shape = self.arrays[name], (steps.max(),) * self.group.is_stepped(name)
            shape = len(tables), *step_shape, *array.shape[len(self.dims) + len(step_shape) :]
            values[name] = stacked = np.full(shape, array.fill_value, array.dtype)
            for row, table in enumerate(tables):
                if table:
                    stacked[(row, slice(-steps[row], None)) if step_shape else row] = table[name]
        return values | {"steps": steps}

    def write(
        self,
        where: Indices,
        values: Mapping[str, Any],
        states: NDArray[np.int8],
        stored: Collection[str] = (),
    ) -> None:
        """Write the values of points by variable, then their statuses once the values are on disk.

        `where` has the index of each point, shape (n, n_dim). A field is None at points without
        it. The files of the variables `stored` have these values already.
        """
        values = {**values, "checksum": checksums(self.group, where, values, states == DONE)}
        has_fields, has_results = self.group.with_fields[tuple(where.T)], states == DONE
        chunks, before = [], np.isin(self.flags, (DONE, FAILED))
        for name in values.keys() - {*stored}:
            point_values, written = values[name], self.group.values_at(name, before)
            at, rows = self.group.point_indices(name, where), dict[Index, list[int]]()
            for row, chunk in enumerate((at // self.block_of(name)).tolist()):
                # A point that failed must not replace times that it shares with others.
                is_empty = name in DATA and not has_results[row]
                is_empty |= name in FIELDS and (not has_fields[row] or point_values[row] is None)
                if not is_empty:
                    rows.setdefault(tuple(chunk), []).append(row)
            chunks += [
                (name, chunk, rows_of_chunk, at, point_values, written)
                for chunk, rows_of_chunk in rows.items()
            ]
        with ThreadPoolExecutor(_THREADS) as threads:
            self.put([*threads.map(lambda part: self._changed(*part), chunks)])
        flags = self.flags.copy()
        flags[tuple(where.T)] = states
        self.set_flags(flags)

    def _changed(
        self, name: str, chunk: Index, rows: Sequence[int], at: Indices, values: Any, written: Mask
    ) -> tuple[str, Slices, Any]:
        """Part for `write_arrays`: a chunk of a variable with new values of the points `rows`.

        `written` is True at values of the variable that have been written before.
        """
        array, sizes = self.arrays[name], self.block_of(name)
        block = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
        if name not in FIELDS and written[block].any():
            chunk_values = self.read(name, block)
        else:  # the chunk has no results yet, and may be damaged
            ends = [min(part.stop, n) for part, n in zip(block, array.shape, strict=False)]
            shape = [end - part.start for end, part in zip(ends, block, strict=True)]
            chunk_values = np.full(
                (*shape, *array.shape[len(block) :]), array.fill_value, array.dtype
            )
        within = tuple((at[rows] - [part.start for part in block]).T)
        new_values = np.array([values[row] for row in rows], array.dtype)
        if self.group.is_stepped(name):
            # Steps beyond the chunk have no values.
            n = min(new_values.shape[1], chunk_values.shape[len(block)])
            chunk_values[within] = array.fill_value
            chunk_values[(*within, slice(-n, None))] = new_values[:, -n:]
        else:
            chunk_values[within] = new_values
        return name, block, chunk_values

    # Statuses

    def forget(self, points: Iterable[Point]) -> None:
        """Mark points as pending, so that they are computed again."""
        self.set_flags(np.where(self._mask(points), np.int8(PENDING), self.flags))

    def ask(self, points: Iterable[Point]) -> None:
        """Mark `points` as needed, and all others that are not done as not needed."""
        self.ask_for(points := [*points])
        is_left = self._mask(points) | (self.flags == DONE)
        self.set_flags(np.where(is_left, self.flags, np.int8(NOT_NEEDED)))

    def ask_for(self, points: Iterable[Point]) -> None:
        """Mark further points as needed."""
        is_new = self._mask(points) & (self.flags == NOT_NEEDED)
        self.set_flags(np.where(is_new, np.int8(PENDING), self.flags))

    def leave_out_pending(self) -> None:
        """Mark pending points as not needed, until `ask_for` is called with them."""
        self.set_flags(np.where(self.flags == PENDING, np.int8(NOT_NEEDED), self.flags))

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

    def put(self, parts: Iterable[tuple[str, Any, Any]]) -> None:
        """Write parts of arrays; raise a `StoreError` if the lock is lost before or after."""
        self._require_lock()
        with io_errors(self.location, "written"):
            write_arrays(self.location, self.arrays, parts)
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
    return Store(location := place_of(path), read_root(location))


_PAUSE, _PAUSE_OF_BUCKET = 1.0, 10.0  # [s] between commits; a kill loses the results of this time
_SHARE = 10.0  # pause over duration of a commit: commits take a tenth of the time
_LONGEST_PAUSE = 10.0  # [s] between commits, even if the disk is slow
_MOST_AT_ONCE = 2**26  # bytes of waiting results, which bound the memory


class Writer:
    """Collects records and writes them about once a second; to an object store, every 10 s."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self._min_pause = _PAUSE_OF_BUCKET if isinstance(store.location, Bucket) else _PAUSE
        self._waiting: list[PointRecord] = []
        self._bytes = 0  # of the waiting results
        self._next = 0.0  # time of the next commit

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(StoreError):  # `flush` has raised it before
            self.flush()

    def add(self, records: Iterable[PointRecord]) -> None:
        """Add records to the waiting ones."""
        for record in records:
            self._waiting.append(record)
            self._bytes += sum(np.asarray(values).nbytes for values in (record.data or {}).values())

    def written(self) -> list[PointRecord]:
        """Write and return the waiting records if a commit is due or they are large."""
        is_due = time.monotonic() >= self._next or self._bytes >= _MOST_AT_ONCE
        return self.flush() if is_due else []

    def flush(self) -> list[PointRecord]:
        """Write and return the waiting records."""
        records, self._waiting, self._bytes, began = self._waiting, [], 0, time.monotonic()
        if records:
            self.store.commit(records)
            pause = _SHARE * (time.monotonic() - began)
            self._next = time.monotonic() + min(max(self._min_pause, pause), _LONGEST_PAUSE)
        return records

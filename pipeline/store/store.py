"""An open store: one process writes it, and commits the results of many points together.

Data are written first, the status last: done means that all of a point is on the disk.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.progress import Progress, Report, silent
from pipeline.store.arrays import KEYS, is_unwritten, open_arrays, write_arrays
from pipeline.store.layout import Group, Root, Slices, blocks, read_root, stale_documents
from pipeline.store.lock import Lock, holder_of
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
from pipeline.store.schema import (
    COLUMNS,
    DONE,
    FAILED,
    FIELDS,
    NOT_ASKED,
    PENDING,
    is_coordinate,
    path_of,
)
from pipeline.sweep.case import TEST
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.points_of_tests import NO_TEST
from pipeline.sweep.sweep import Point, Sweep
from pipeline.sweep.variants import Variant

_LONGEST = 2000  # characters of a message, so that somebody can read it
_OF_POINT = ("message", "warning_flags", "wall_time")  # of a record, beside its data
_THREADS = 8  # an object store answers them side by side

Index = tuple[int, ...]


@dataclass
class Damage:
    """Points with damaged values, with the fault of each, and damaged files by key.

    A file comes as a part for `write_arrays`, with values that replace it.
    """

    points: dict[Index, str] = field(default_factory=dict)
    files: dict[str, tuple[str, Any, Any]] = field(default_factory=dict)


class Store:
    """An open store, or its group of tests; it may be written if this process holds its lock.

    `tests` is the group of tests, if there is one. `flags` has the status of each point. `damage`
    has what is damaged; without it, damage raises a `DamagedError`.
    """

    def __init__(
        self,
        place: StorePlace,
        root: Root,
        lock: Lock | None = None,
        damage: Damage | None = None,
        group: Group | None = None,
    ) -> None:
        self.place, self.root, self.lock, self.damage = place, root, lock, damage
        self.group = own = group or root.plane
        self.sweep, self.axes, self.dims = own.sweep, own.axes, own.dims
        self.arrays = open_arrays(place.zarr, own.arrays, own.prefix)
        self._numbers = [
            {label: number for number, label in enumerate(self.axes[dim])} for dim in self.dims
        ]
        self._stamp = place.stamp()
        self.flags: NDArray[np.int8] = self._found_flags()
        self.tests: Store | None = None
        if root.tests and group is None:
            self.tests = Store(place, root, lock, damage and Damage(), root.tests)

    def _found_flags(self) -> Any:
        """Statuses in the store. No store has none: where they are lost, all points are pending."""
        shape = tuple(self.group.sizes[dim] for dim in self.dims)
        found = self._try("status", tuple(slice(0, n) for n in shape))
        if found is not None and (found >= 0).all():
            return found
        if self.damage is None:
            raise damaged(self.place, "status")
        lost = np.full(shape, PENDING, np.int8)
        self.damage.files[self.key("status", [0] * len(shape))] = "status", ..., lost
        return lost

    @property
    def groups(self) -> list[Store]:
        """The plane, and the tests if there are any."""
        return [self, *([self.tests] if self.tests else [])]

    # Indices of points

    def index(self, point: Point) -> Index:
        """Index of a point along `dims`."""
        labels = {"load": point.load, "velocity": point.velocity, **dict(point[2])}
        found = zip(self.dims, self._numbers, strict=True)
        return tuple(numbers[labels[dim]] for dim, numbers in found)

    def points_where(self, mask: Any) -> list[Point]:
        """Points where a mask of the shape of `flags` is True."""
        return self.group.points_at(np.nonzero(mask))

    def block_of(self, name: str) -> Index:
        """Number of points in a chunk of a variable, along each of `dims`."""
        return tuple(self.arrays[name].chunks[: len(self.dims)])

    def key(self, name: str, chunk: Sequence[int]) -> str:
        """Key of a chunk of a variable, such as ``time/c.0.2.0``.

        `chunk` has the chunk's indices along `dims`. One chunk has all values of a point.
        """
        within = [0] * (self.arrays[name].ndim - len(chunk))
        path = f"{self.group.prefix}{path_of(name)}"
        head = ["c"] if self.group.keys == KEYS[0] else []
        return f"{path}/" + ".".join(map(str, (*head, *chunk, *within)))

    # Reading

    def read(self, name: str, key: Any) -> Any:
        """Read a part of a variable by outer indexing; `DamagedError` if a chunk is damaged."""
        try:
            with read_errors(self.place, name):
                return self.arrays[name].oindex[key]
        finally:
            if self.place.stamp() != self._stamp:
                raise StoreError(f"{self.place} was enlarged since it was opened; open it again")

    def blank_fields(self) -> dict[str, Any]:
        """Fields of a point whose fields are not kept, by name: NaN everywhere."""
        return {
            name: np.full(self.arrays[name].shape[len(self.dims) :], np.nan, np.float32)
            for name in FIELDS
            if name in self.arrays
        }

    def pending(self) -> list[Point]:
        """Points that were asked for, and are neither done nor failed."""
        return self.points_where(self.flags == PENDING)

    def checked(self, progress: Report = silent) -> Iterator[tuple[Index, PointRecord, str]]:
        """Yield index, record, and fault of each done or failed point; empty if it is sound.

        All chunks are read, one after the other; those that cannot be read are added to `damage`.
        """
        names = [name for name in self.arrays if not (name == "status" or is_coordinate(name))]
        others = [name for name in names if name not in FIELDS]
        everywhere = [*blocks(np.ones(self.flags.shape, bool), self.block_of("message"))]
        with ThreadPoolExecutor(_THREADS) as threads:

            def read(names: Sequence[str], block: Slices) -> dict[str, Any]:
                found = threads.map(lambda name: self._try(name, block), names)
                return dict(zip(names, found, strict=True))

            for count, (_, block) in enumerate(everywhere, 1):
                values = read(others, block)
                for within in np.argwhere(np.isin(self.flags[block], (DONE, FAILED))):
                    index = tuple(int(i) + at.start for i, at in zip(within, block, strict=True))
                    own = {k: None if v is None else v[tuple(within)] for k, v in values.items()}
                    here = tuple(slice(i, i + 1) for i in index)
                    fields = read([name for name in names if name in FIELDS], here)
                    own |= {k: None if v is None else v.squeeze() for k, v in fields.items()}
                    yield index, *self._record(index, own)
                progress(Progress(done=count, total=len(everywhere)))

    def _record(self, index: Index, values: dict[str, Any]) -> tuple[PointRecord, str]:
        """Record of a point from its stored values, None if damaged; and what is wrong with it."""
        (point,) = self.group.points_at([np.array([number]) for number in index])
        is_done, about = self.flags[index] == DONE, [values.pop(name) for name in _OF_POINT]
        steps = values.pop("steps")
        lost = [name for name, one in values.items() if one is None] if is_done else []
        lost += [name for name, one in zip(_OF_POINT, about, strict=True) if one is None]
        if lost or (is_done and steps is None):
            return PointRecord(point, None), f"{', '.join(lost) or 'steps'} cannot be read"
        if not is_done:
            fault = "" if about[0] else "the reason for its failure is lost"
            return PointRecord(point, None, *about), fault
        fault = "" if bool(about[0]) == bool(about[1]) else "its warnings are lost"
        for name, one in values.items():
            end = one[-1] if name in COLUMNS else one
            if is_unwritten(end, self.arrays[name]).any():
                fault = f"{name} is missing"
        if not (steps and np.isfinite(values["contact_fraction"][-1])):
            fault = "it has no values"
        data = {k: one[-int(steps) :] if k in COLUMNS else one for k, one in values.items()}
        return PointRecord(point, data, str(about[0]), int(about[1]), float(about[2])), fault

    def _try(self, name: str, block: Slices) -> Any:
        """Values of a variable at `block`; None, and a note of its chunk, if it is damaged."""
        try:
            return self.read(name, block)
        except DamagedError:
            if self.damage is None:
                raise
            sizes = self.block_of(name)
            chunk = [part.start // n for part, n in zip(block, sizes, strict=True)]
            place = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
            fill = self.arrays[name].fill_value
            self.damage.files[self.key(name, chunk)] = name, place, fill
            return None

    def find_damage(self, progress: Report = silent) -> Damage:
        """Read all data to find what is damaged; the store must have been opened with `damage`."""
        assert self.damage is not None
        for index, _, fault in self.checked(progress):
            if fault:
                self.damage.points[index] = fault
        for name, values in sorted(self.group.coordinates.items()):
            found = self._try(name, tuple(slice(0, n) for n in self.arrays[name].shape))
            right = np.asarray(values, self.arrays[name].dtype)
            if found is None or not np.array_equal(found, right, equal_nan=right.dtype.kind == "f"):
                self.damage.files.pop(self.key(name, [0] * right.ndim), None)
                self.damage.files[f"{self.group.prefix}{path_of(name)}"] = name, ..., values
        return self.damage

    # Writing: every method raises a `StoreError` if it fails, or the lock was lost

    def commit(self, records: Iterable[PointRecord]) -> None:
        """Write the records of points: data first, then statuses, so that done points have data."""
        values, statuses = {}, {}
        for record in records:
            index = self.index(record.point)
            # Names of files in a message may not be valid UTF-8.
            message = record.message[:_LONGEST].encode(errors="backslashreplace").decode()
            values[index] = {name: getattr(record, name) for name in _OF_POINT}
            values[index]["message"] = message
            statuses[index] = FAILED
            if record.data is not None:
                values[index] |= {**record.data, "steps": len(record.data["max_rise"])}
                statuses[index] = DONE
        self.write(values, statuses)

    def forget(self, points: Iterable[Point]) -> None:
        """Mark points as pending, so that they are computed again."""
        self.write({}, {self.index(point): PENDING for point in points})

    def ask(self, points: Iterable[Point]) -> None:
        """Mark `points` as asked for, and others that are not done as not asked for."""
        wanted = np.zeros(self.flags.shape, bool)
        for point in points:
            wanted[self.index(point)] = True
        flags = np.where(wanted & (self.flags == NOT_ASKED), np.int8(PENDING), self.flags)
        self._write_flags(np.where(wanted | (flags == DONE), flags, np.int8(NOT_ASKED)))

    def leave_out_pending(self) -> None:
        """Mark pending points as not asked for, until `ask_for` asks for them."""
        self._write_flags(np.where(self.flags == PENDING, np.int8(NOT_ASKED), self.flags))

    def ask_for(self, points: Iterable[Point]) -> None:
        """Mark points as asked for, too."""
        flags = self.flags.copy()
        for index in map(self.index, points):
            flags[index] = PENDING if flags[index] == NOT_ASKED else flags[index]
        self._write_flags(flags)

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
        with ThreadPoolExecutor(_THREADS) as threads:
            parts = [*threads.map(lambda key: self._changed(key[0], key[1], chunks[key]), chunks)]
        self._put(parts)
        flags = self.flags.copy()
        for index, status in statuses.items():
            flags[index] = status
        self._write_flags(flags)

    def mend(self) -> int:
        """Mark damaged points as pending, and replace damaged files; return their number."""
        damage = self.find_damage()
        # Statuses first, so that a done point is whole even after a kill in between.
        self.write({}, dict.fromkeys(damage.points, PENDING))
        self._put(damage.files.values())
        return len(damage.points) + len(damage.files)

    def _changed(
        self, name: str, chunk: Index, values: Mapping[Index, Any]
    ) -> tuple[str, Slices, Any]:
        """Part for `write_arrays`: a chunk with new `values`, by the index of the point."""
        sizes, array = self.block_of(name), self.arrays[name]
        block = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, sizes, strict=True))
        if np.isin(flags := self.flags[block], (DONE, FAILED)).any():
            whole = self.read(name, block)
        else:  # what is there may be damaged
            shape = flags.shape + array.shape[len(self.dims) :]
            whole = np.full(shape, array.fill_value, array.dtype)
        for index, value in values.items():
            within = tuple(i - part.start for i, part in zip(index, block, strict=True))
            if name in COLUMNS:
                whole[within] = array.fill_value
                whole[within][-len(value) :] = value
            else:
                whole[within] = value
        return name, block, whole

    def _write_flags(self, flags: NDArray[np.int8]) -> None:
        if not np.array_equal(flags, self.flags):
            self._put([("status", ..., flags)])
        self.flags = flags

    def _put(self, parts: Iterable[tuple[str, Any, Any]]) -> None:
        """Write parts of arrays; the lock must be in its place before and after."""
        self._require_lock()
        with io_errors(self.place, "written"):
            write_arrays(self.place, self.arrays, parts)
        self._require_lock()

    def _require_lock(self) -> None:
        if self.lock and not self.lock.is_in_place():
            raise StoreError(
                f"{self.place}: its lock ({LOCK}) was deleted or replaced during this run, which "
                "stops: another run may write now. Finished points are safe; run the command again"
            )


_PAUSE, _PAUSE_OF_BUCKET = 1.0, 10.0  # [s] between commits: as much work as a kill may cost
_SHARE = 10.0  # durations of a commit, as pause after it: commits take a tenth of the driver
_LONGEST_PAUSE = 10.0  # [s] between commits, however slow the disk or busy the machine


class Writer:
    """Collects records, and writes them about once a second, to an object store every 10 s.

    Points are to be computed with fields if `with_fields`; unless `keeps_fields` the fields of the
    store are NaN.
    """

    def __init__(self, store: Store, keeps_fields: bool = True) -> None:
        self.store = store
        self.with_fields = keeps_fields and "pressure" in store.arrays
        self._blank = {} if keeps_fields else store.blank_fields()
        self._least = _PAUSE_OF_BUCKET if isinstance(store.place, Bucket) else _PAUSE
        self._waiting: list[PointRecord] = []
        self._next = 0.0  # time of the next commit

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(StoreError):  # which `flush` has raised before
            self.flush()

    def add(self, records: Iterable[PointRecord]) -> None:
        """Add records to those that wait."""
        for record in records:
            if self._blank and record.data is not None:
                record = replace(record, data={**record.data, **self._blank})
            self._waiting.append(record)

    def written(self) -> list[PointRecord]:
        """Write the waiting records if it is time to, and return them."""
        return self.flush() if time.monotonic() >= self._next else []

    def flush(self) -> list[PointRecord]:
        """Write the waiting records, and return them."""
        records, self._waiting, began = self._waiting, [], time.monotonic()
        if records:
            self.store.commit(records)
            pause = _SHARE * (time.monotonic() - began)
            self._next = time.monotonic() + min(max(self._least, pause), _LONGEST_PAUSE)
        return records


# What users ask of a store


@dataclass(frozen=True, slots=True)
class FailedPoint:
    """A point that failed or is damaged: load [N], velocity [m/s], reason and variant.

    `place` describes the point in words, with entries in the user's units.
    """

    load: float
    velocity: float
    message: str
    variant: Variant = ()
    place: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.place or Point(self.load, self.velocity, self.variant)}: {self.message}"


@dataclass(frozen=True, slots=True)
class Summary:
    """Progress of a sweep: number of points by state, failed points, and the writing process."""

    #: Name and title of the scene.
    name: str
    title: str
    #: Number of points that were asked for; of these that are done and to do.
    total: int
    done: int
    pending: int
    failed: tuple[FailedPoint, ...]  #: Points that could not be computed.
    warned: int = 0  #: Number of done points with a warning.
    running: str | None = None  #: Process that computes points now; None if there is none.
    tests: Summary | None = None  #: Progress of the points of tests; None if there are none.


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


def opened(path: PathLike) -> Store:
    """Open a store to read it."""
    return Store(place := place_of(path), read_root(place))


def summary(path: PathLike) -> Summary:
    """Count the points of a store by state, and those with warnings, without reading results.

    Parameters
    ----------
    path : str or path
        Folder or address of the store.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> summary = pipeline.summary("results/first_try.zarr")
    >>> summary.done, summary.pending, summary.failed
    (24, 0, ())
    """
    return states(path)[0]


def states(path: PathLike) -> tuple[Summary, Sweep]:
    """Progress of a store, and its sweep."""
    store = opened(path)
    return summary_of(store), store.sweep


def summary_of(store: Store) -> Summary:
    """Count the points of an open store by state, and the points with a warning."""
    flags = store.flags
    if TEST in store.axes:  # points of earlier tests do not count
        flags = np.where(np.equal(store.axes[TEST], NO_TEST), np.int8(NOT_ASKED), flags)
    failed = [*zip(*np.nonzero(flags == FAILED), strict=True)]
    messages = store.read("message", ...) if failed else {}
    return Summary(
        name=store.sweep.name,
        title=store.sweep.title,
        total=int(np.count_nonzero(flags != NOT_ASKED)),
        done=int(np.count_nonzero(flags == DONE)),
        pending=int(np.count_nonzero(flags == PENDING)),
        failed=_told(store, {index: str(messages[index]) for index in failed}),
        warned=int(np.count_nonzero((flags == DONE) & (store.read("warning_flags", ...) != 0))),
        running=holder_of(store.place),
        tests=summary_of(store.tests) if store.tests and store.sweep.tests else None,
    )


def _told(store: Store, faults: Mapping[Index, str]) -> tuple[FailedPoint, ...]:
    """Points by index, each with what is wrong with it."""
    points = store.group.points_at([*np.array([*faults], int).reshape(-1, len(store.dims)).T])
    return tuple(
        FailedPoint(*point[:2], fault, point.variant, store.group.in_words(point))
        for point, fault in zip(points, faults.values(), strict=True)
    )


def verify_store(path: PathLike, progress: Report | None = None) -> Verification:
    """Check a whole store for damage; nothing is written.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use.
    progress : callable, optional
        Called now and then with a `Progress` that counts chunks of points.

    Raises
    ------
    StoreError
        If there is no readable store, or one of its files cannot be read now.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """
    place = place_of(path)
    store = Store(place, read_root(place), damage=Damage())
    found = _verified(store, progress or silent)
    with io_errors(place):
        return replace(found, shared=(*found.shared, *stale_documents(place, store.root)))


def _verified(store: Store, progress: Report) -> Verification:
    damage = store.find_damage(progress)
    of_done = sum(bool(store.flags[index] == DONE) for index in damage.points)
    return Verification(
        done=int(np.count_nonzero(store.flags == DONE)) - of_done,
        damaged=_told(store, damage.points),
        shared=tuple(damage.files),
        tests=_verified(store.tests, silent) if store.tests else None,
    )

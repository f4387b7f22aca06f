"""Damage of a store: points whose data are not those that their checksums were taken of.

Repair makes damaged points pending, so that the next run computes them again. Where only what is
told about a point was lost, its data stay: the kinds of its warnings are restored from its
checksum, a message from these kinds, and times are unknown.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.store.create import repairing
from pipeline.store.identity import checksum, record_checksum
from pipeline.store.place import ROOT, PathLike, StoreError, place_of
from pipeline.store.points import Slices, missing_chunks
from pipeline.store.root import Root, read_root
from pipeline.store.schema import AT_END, DONE, PENDING, STEPPED, is_coordinate
from pipeline.store.write import ABOUT, Store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from tribo import WarningKind
from tribo.types import Mask

_OTHER = "the data are not those that were computed"
_LOST = "the message was damaged; kinds of warnings: {}"
_LOST_REASON = "the reason why it failed was damaged; try again with irg run --retry-failed"


@dataclass(frozen=True, slots=True)
class Damage:
    """A damaged point: load [N], velocity [m/s], reason, and which variant."""

    load: float
    velocity: float
    reason: str
    realization: int | None = None
    sample: int | None = None

    def __str__(self) -> str:
        return f"{Point(self.load, self.velocity, self.realization, self.sample)}: {self.reason}"


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of reading a whole store.

    Attributes
    ----------
    done : int
        Points that are done and intact.
    damaged : tuple of Damage
        Points that are damaged; repair makes them pending.
    records : tuple of Damage
        Points whose data are intact, but not what is told about them; repair keeps their data.
    shared : tuple of str
        Faults of coordinates and metadata, which belong to no point.
    without_status : tuple of Point
        Points that are complete, but have no readable status; repair makes them done.
    repaired : bool
        Whether all of that was repaired.
    """

    done: int
    damaged: tuple[Damage, ...]
    records: tuple[Damage, ...]
    shared: tuple[str, ...]
    without_status: tuple[Point, ...]
    repaired: bool

    @property
    def is_clean(self) -> bool:
        """Return whether nothing was damaged."""
        return not (self.damaged or self.records or self.shared)


def verify_store(
    path: PathLike, repair: bool = False, progress: Callable[[int, int], None] | None = None
) -> Verification:
    """Read everything in a store and name what is damaged.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use unless it is to be repaired.
    repair : bool
        Whether to make damaged points pending, and to restore what is shared.
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
    if repair:
        with repairing(path) as store:
            return examined(store, True, progress)
    place = place_of(path)
    return examined(Store(place, read_root(place), is_damaged=True), False, progress)


def examined(
    store: Store, repair: bool, progress: Callable[[int, int], None] | None = None
) -> Verification:
    """Read all of an open store; see `verify_store`."""
    shared = [*_shared_faults(store, repair)]
    missing = missing_chunks(store.place, Root(store.attributes, store.metadata), store.flags)
    asked_lost = missing.pop("asked", None) is not None or not store.is_readable("asked", ...)
    if asked_lost:
        shared.append("the points that the last run asked for are damaged")
    total, count = int(np.count_nonzero(store.flags == DONE)), 0
    blocks = []
    unknown = _without_status(store)
    for _, block in store.blocks((store.flags != PENDING) | unknown):
        blocks.append(_examined_block(store, block, unknown[block], missing))
        count += int(np.count_nonzero(store.flags[block] == DONE))
        if progress:
            progress(count, total)
    if repair:
        for each in blocks:
            _repair(store, each)
        if asked_lost:
            store.ask((store.asked == 1) | (store.flags != PENDING))
    damaged = _damages(each.damaged for each in blocks)
    return Verification(
        done=total - len(damaged) + (sum(len(each.complete) for each in blocks) if repair else 0),
        damaged=damaged,
        records=_damages(each.records for each in blocks),
        shared=tuple(shared),
        without_status=tuple(point for each in blocks for point in each.complete),
        repaired=repair,
    )


class _Examination(NamedTuple):
    """Damage of points that share chunks, by their reasons; and points that lack their status."""

    damaged: dict[Point, str]
    records: dict[Point, str]
    complete: list[Point]
    about: dict[str, NDArray[Any]]
    block: Slices


def _without_status(store: Store) -> Mask:
    """Points of chunks that are on the disk, while their statuses are missing or unreadable."""
    written, flagged = store.place.names("checksum"), store.place.names("status")
    mask = np.zeros(store.shape, bool)
    for chunk, block in store.blocks(np.ones(store.shape, bool)):
        key = ".".join(map(str, ("c", *chunk)))
        if key in written:
            try:
                store.read("status", block)
                mask[block] = key not in flagged
            except StoreError:
                mask[block] = True
    return mask


def _examined_block(
    store: Store, block: Slices, unknown: Mask, missing: Mapping[str, Mask]
) -> _Examination:
    flags = store.flags[block]
    values: dict[str, NDArray[Any]] = {}
    unreadable = []
    for name in store.names:
        if name not in AT_END and name not in ("status", "asked"):
            try:
                values[name] = store.read(name, block)
            except StoreError:
                unreadable.append(name)
    about = {name: values[name] for name in (*ABOUT, "record_checksum") if name in values}
    examination = _Examination({}, {}, [], about, block)
    places = np.argwhere((flags != PENDING) | unknown)
    first = [part.start for part in block]
    for within, point in zip(places.tolist(), store.points_at((places + first).T), strict=True):
        index = tuple(within)
        lacks = [name for name, mask in missing.items() if mask[block][index]]
        flag = DONE if unknown[index] else flags[index]
        record = _fault_of_record(point, index, values, unreadable, lacks)
        data = (
            _fault_of_data(store, point, index, values, unreadable, lacks) if flag == DONE else None
        )
        if unknown[index]:
            if not (data or record):
                examination.complete.append(point)
        elif data or record == _OTHER:
            examination.damaged[point] = data or _OTHER
        elif record:
            examination.records[point] = record
    return examination


def _fault_of_record(
    point: Point,
    index: tuple[int, ...],
    values: Mapping[str, NDArray[Any]],
    unreadable: list[str],
    missing: list[str],
) -> str | None:
    names = (*ABOUT, "record_checksum")
    if fault := _fault_of_chunks(
        [n for n in names if n in unreadable], [n for n in names if n in missing]
    ):
        return fault
    message, kinds, *times = (values[name][index] for name in ABOUT)
    record = PointRecord(point, None, str(message), int(kinds), *map(float, times))
    return None if values["record_checksum"][index] == record_checksum(record) else _OTHER


def _fault_of_data(
    store: Store,
    point: Point,
    index: tuple[int, ...],
    values: Mapping[str, NDArray[Any]],
    unreadable: list[str],
    missing: list[str],
) -> str | None:
    data: dict[str, NDArray[Any]] = {}
    fields_unreadable = []
    for name in AT_END:
        if name in store.arrays:
            try:
                data[name] = store.read(name, store.index(point))
            except StoreError:
                fields_unreadable.append(name)
    broken = [name for name in unreadable if name in STEPPED or name == "checksum"]
    lacks = [name for name in missing if name in STEPPED | AT_END or name == "checksum"]
    if fault := _fault_of_chunks(broken + fields_unreadable, lacks):
        return fault
    steps = np.count_nonzero(np.isfinite(values["time"][index]))
    data |= {name: values[name][index][:steps] for name in values if name in STEPPED}
    return None if values["checksum"][index] == checksum(point, data) else _OTHER


def _fault_of_chunks(unreadable: list[str], missing: list[str]) -> str | None:
    if unreadable:
        return f"{', '.join(unreadable)} cannot be read"
    return f"{', '.join(missing)} is missing" if missing else None


def _damages(reasons: Iterable[Mapping[Point, str]]) -> tuple[Damage, ...]:
    return tuple(
        Damage(point.load, point.velocity, reason, *point[2:])
        for each in reasons
        for point, reason in each.items()
    )


def _repair(store: Store, examination: _Examination) -> None:
    """Make damaged points pending, and write anew what is told of the others."""
    values = {}
    for point in examination.records:
        index = store.index(point)
        within = tuple(i - part.start for i, part in zip(index, examination.block, strict=True))
        told = {name: each[within] for name, each in examination.about.items()}
        record = _restored(point, told, store.is_done(point))
        if record is None:
            examination.damaged[point] = examination.records[point]
        else:
            about = {name: getattr(record, name) for name in ABOUT}
            values[index] = about | {"record_checksum": record_checksum(record)}
    store.discard_unreadable(examination.block, examination.damaged)
    store.write(values, {store.index(point): DONE for point in examination.complete})
    store.forget(examination.damaged)


def _restored(point: Point, told: Mapping[str, Any], is_done: bool) -> PointRecord | None:
    """Record of a point, as far as it can be read or follows from the rest; None if too little."""
    times = (float(told.get(name, np.nan)) for name in ("wall_time", "finished_at"))
    kinds = int(told.get("warning_flags", 0))
    labels = ", ".join(kind.label for kind in WarningKind if kind & kinds)
    lost = _LOST.format(labels) if labels else "" if is_done else _LOST_REASON
    record = PointRecord(point, None, str(told.get("message", lost)), kinds, *times)
    if not record.message or "warning_flags" in told:
        return record
    of_any_kinds = (replace(record, warning_flags=n) for n in range(2 * max(WarningKind)))
    expected = told.get("record_checksum")
    return next((each for each in of_any_kinds if record_checksum(each) == expected), None)


def _shared_faults(store: Store, repair: bool) -> Iterator[str]:
    """Faults of coordinates and metadata, which are restored from the root if so desired."""
    for name, expected in store.metadata.items():
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
    """Return whether metadata are as in the root, but for a growth that was cut short."""
    try:
        return bool(json.loads(content or b"") | {"shape": expected["shape"]} == expected)
    except (ValueError, TypeError, RecursionError):
        return False

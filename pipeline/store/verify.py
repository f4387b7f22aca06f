"""Damage of a store: points whose data are not those that their checksums were taken of.

Repair makes damaged points pending, so that the next run computes them again. Where only what is
told about a point was lost, its data stay: the kinds of its warnings are restored from its
checksum, a message from these kinds, and times are unknown.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.store.create import repairing
from pipeline.store.identity import checksum, record_checksum
from pipeline.store.place import ROOT, PathLike, StoreError, place_of
from pipeline.store.points import Slices, missing_chunks
from pipeline.store.root import Root, read_root
from pipeline.store.schema import AT_END, DONE, PENDING, STEPPED, chunk_name, is_coordinate
from pipeline.store.write import ABOUT, Store
from pipeline.sweep.model import Point
from pipeline.sweep.over import Variant
from pipeline.sweep.plan import PointRecord
from tribo import WarningKind
from tribo.types import Mask

_OTHER = "the data are not those that were computed"
_LOST = "the message was damaged; kinds of warnings: {}"
_LOST_REASON = "the reason why it failed was damaged; try again with irg run --retry-failed"


@dataclass(frozen=True, slots=True)
class Damage:
    """A damaged point: load [N], velocity [m/s], reason, and which variant.

    Examples
    --------
    >>> import pipeline
    >>> print(pipeline.Damage(400.0, 2.2, "its rise is not readable"))
    400 N, 2.2 m/s: its rise is not readable
    """

    load: float
    velocity: float
    reason: str
    variant: Variant = ()

    def __str__(self) -> str:
        return f"{Point(self.load, self.velocity, self.variant)}: {self.reason}"


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
        True if all of that was repaired.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.shared
    (24, (), ())
    """

    done: int
    damaged: tuple[Damage, ...]
    records: tuple[Damage, ...]
    shared: tuple[str, ...]
    without_status: tuple[Point, ...]
    repaired: bool

    @property
    def is_clean(self) -> bool:
        """True if nothing was damaged."""
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
    unknown = _on_disk(store, "checksum")
    unknown &= ~_on_disk(store, "status") | store.unreadable["status"]
    is_there = (store.flags != PENDING) | unknown
    missing = missing_chunks(
        store.place,
        Root(store.attributes, store.metadata),
        np.where(is_there, DONE, PENDING).astype(np.int8),
    )
    if "asked" in missing:
        store.unreadable["asked"] |= missing["asked"]
    for name, kind in (("status", "statuses"), ("asked", "points that the last run asked for")):
        if store.unreadable[name].any():
            shared.append(f"the {kind} are damaged")
    total, count, examinations = int(np.count_nonzero(store.flags == DONE)), 0, []
    for _, block in store.blocks(is_there | _on_disk(store, "message")):
        gone = {name: mask[block] for name, mask in missing.items() if mask[block].any()}
        examinations.append(_examined_block(store, block, unknown[block], gone))
        count += int(np.count_nonzero(store.flags[block] == DONE))
        if progress:
            progress(count, total)
    damaged = [point for examination in examinations for point in examination.damaged]
    done = total - sum(map(store.is_done, damaged))
    if repair:
        for examination in examinations:
            _repair(store, examination)
        store.restore_flags()
        done = int(np.count_nonzero(store.flags == DONE))
    return Verification(
        done=done,
        damaged=_damages(examination.damaged for examination in examinations),
        records=_damages(examination.records for examination in examinations),
        shared=tuple(shared),
        without_status=tuple(
            point for examination in examinations for point in examination.complete
        ),
        repaired=repair,
    )


class _Examination(NamedTuple):
    """Points that share chunks: their damage by its reason, and those that lack a status alone."""

    block: Slices
    lost: list[str]
    damaged: dict[Point, str]
    records: dict[Point, str]
    restored: dict[Point, PointRecord]
    complete: list[Point]


def _on_disk(store: Store, name: str) -> Mask:
    """Points whose chunk of a small variable is on the disk."""
    names = store.place.names(name)
    mask = np.zeros(store.shape, bool)
    for chunk, block in store.blocks(~mask):
        mask[block] = chunk_name(chunk) in names
    return mask


def _examined_block(
    store: Store, block: Slices, unknown: Mask, missing: Mapping[str, Mask]
) -> _Examination:
    values: dict[str, NDArray[Any]] = {}
    lost = []
    for name in set(store.names) - set(AT_END) - {"status", "asked"}:
        try:
            if name in missing:
                raise StoreError
            values[name] = store.read(name, block)
        except StoreError:
            lost.append(name)
    examination = _Examination(block, lost, {}, {}, {}, [])
    flags = np.where(unknown, DONE, store.flags[block])
    places = np.argwhere(flags != PENDING)
    first = [part.start for part in block]
    for within, point in zip(places.tolist(), store.points_at((places + first).T), strict=True):
        index = tuple(within)
        entries = {name: array[index] for name, array in values.items()}
        gone = {name for name in AT_END if name in missing and missing[name][index]}
        is_done = flags[index] == DONE
        record, fault = _record(point, entries, is_done)
        fault_of_data = _fault_of_data(store, point, entries, gone) if is_done else None
        if unknown[index]:
            if not (fault or fault_of_data):
                examination.complete.append(point)
        elif fault_of_data or (fault and record is None):
            examination.damaged[point] = fault_of_data or fault or ""
        elif fault and record:
            examination.records[point], examination.restored[point] = fault, record
    return examination


def _record(
    point: Point, entries: Mapping[str, Any], is_done: bool
) -> tuple[PointRecord | None, str | None]:
    """Record of a point, as far as it can be read or follows from the rest, and its fault."""
    if fault := _unreadable(name for name in (*ABOUT, "record_checksum") if name not in entries):
        return _restored(point, entries, is_done), fault
    message, kinds, *times = (entries[name] for name in ABOUT)
    record = PointRecord(point, None, str(message), int(kinds), *map(float, times))
    is_sound = entries["record_checksum"] == record_checksum(record)
    return (record, None) if is_sound else (None, _OTHER)


def _restored(point: Point, entries: Mapping[str, Any], is_done: bool) -> PointRecord | None:
    message, kinds = entries.get("message"), int(entries.get("warning_flags", -1))
    times = [float(entries.get(name, np.nan)) for name in ("wall_time", "finished_at")]
    if kinds < 0 and message != "":
        every = (
            PointRecord(point, None, str(message or ""), number, *times)
            for number in range(2 * max(WarningKind))
        )
        expected = entries.get("record_checksum")
        return next((record for record in every if record_checksum(record) == expected), None)
    if message is None:
        labels = ", ".join(kind.label for kind in WarningKind if kind & kinds)
        message = _LOST.format(labels) if labels else "" if is_done else _LOST_REASON
    return PointRecord(point, None, str(message), max(kinds, 0), *times)


def _fault_of_data(
    store: Store, point: Point, entries: Mapping[str, Any], gone: set[str]
) -> str | None:
    data: dict[str, NDArray[Any]] = {}
    lost = [name for name in (*STEPPED, "checksum") if name in store.arrays.keys() - entries.keys()]
    for name in store.arrays.keys() & AT_END.keys():
        try:
            if name in gone:
                raise StoreError
            data[name] = store.read(name, store.index(point))
        except StoreError:
            lost.append(name)
    if lost:
        return _unreadable(sorted(lost))
    steps = np.count_nonzero(np.isfinite(entries["time"]))
    data |= {name: entries[name][:steps] for name in STEPPED if name in entries}
    return None if entries["checksum"] == checksum(point, data) else _OTHER


def _unreadable(names: Iterable[str]) -> str | None:
    lost = ", ".join(names)
    return f"{lost} cannot be read" if lost else None


def _damages(reasons: Iterable[Mapping[Point, str]]) -> tuple[Damage, ...]:
    return tuple(
        Damage(point.load, point.velocity, reason, point.variant)
        for damage in reasons
        for point, reason in damage.items()
    )


def _repair(store: Store, examination: _Examination) -> None:
    """Make damaged points pending, and write anew what is told of the others."""
    for name in examination.lost:
        store.arrays[name][examination.block] = store.arrays[name].fill_value
    for point in examination.damaged:
        for name in store.arrays.keys() & AT_END.keys():
            store.arrays[name][store.index(point)] = store.arrays[name].fill_value
    values = {
        store.index(point): {name: getattr(record, name) for name in ABOUT}
        | {"record_checksum": record_checksum(record)}
        for point, record in examination.restored.items()
    }
    store.write(values, {store.index(point): DONE for point in examination.complete})
    store.forget(examination.damaged)


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
    """True if metadata are as in the root, but for a growth that was cut short."""
    try:
        return bool(json.loads(content or b"") | {"shape": expected["shape"]} == expected)
    except (ValueError, TypeError, RecursionError):
        return False

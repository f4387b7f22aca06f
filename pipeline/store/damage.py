"""Faults of the points of a store, found by reading all of its files."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store.layout import blocks, checksums
from pipeline.store.schema import DATA, DONE, FAILED, FIELDS, PENDING, is_coordinate, path_of
from pipeline.store.store import Damage, Store
from tribo.types import Indices

_MAX_FIELD_BYTES = 2**25  # bytes of fields read at once
_THREADS = 8  # concurrent requests to an object store


class Checked(NamedTuple):
    """A batch of points with their values by variable and the fault of each."""

    where: Indices  # index along each dimension, shape (n, n_dim)
    values: dict[str, Any]  # None if a chunk is damaged
    faults: list[str]  # empty for sound points


def checked_points(store: Store, progress: Report = silent) -> Iterator[Checked]:
    """Yield the done and failed points in batches, with the fault of each.

    All chunks are read in turn; those that cannot be read are added to `store.damage`.
    """
    names = [name for name in store.arrays if not (name == "status" or is_coordinate(name))]
    fields = [name for name in names if name in FIELDS]
    columns = [name for name in names if name not in FIELDS]
    max_points = _MAX_FIELD_BYTES // max(
        1, *(4 * math.prod(store.arrays[name].chunks) for name in fields), 1
    )
    everywhere = [*blocks(np.ones(store.flags.shape, bool), store.block_of("message"))]
    for count, (_, block) in enumerate(everywhere, 1):
        parts = [tuple(itertools.compress(block, store.group.has_dims(name))) for name in columns]
        with ThreadPoolExecutor(_THREADS) as threads:
            read = dict(zip(columns, threads.map(store.try_read, columns, parts), strict=True))
        within = np.argwhere(np.isin(store.flags[block], (DONE, FAILED)))
        for indices in np.split(within, range(max(max_points, 1), len(within), max(max_points, 1))):
            if not len(indices):
                continue
            values = {
                name: None if v is None else v[tuple(store.group.point_indices(name, indices).T)]
                for name, v in read.items()
            }
            where = indices + [part.start for part in block]
            values |= {name: _read_fields(store, name, where) for name in fields}
            yield Checked(where, values, _faults(store, where, values))
        progress(Progress(done=count, total=len(everywhere)))


def _read_fields(store: Store, name: str, where: Indices) -> list[Any]:
    """A field of each point; None if it is lost, or the point is not done or has no fields."""
    fields: list[Any] = [None] * len(where)
    rows = np.flatnonzero((store.group.with_fields & (store.flags == DONE))[tuple(where.T)])
    chunk_indices = store.group.point_indices(name, where)[rows].tolist()
    chunks = [tuple(slice(i, i + 1) for i in chunk_index) for chunk_index in chunk_indices]
    with ThreadPoolExecutor(_THREADS) as threads:
        read = threads.map(lambda chunk: store.try_read(name, chunk), chunks)
        for row, chunk_index, values in zip(rows.tolist(), chunk_indices, read, strict=True):
            fields[row] = None if values is None else values[(0,) * len(chunk_index)]
    return fields


def _faults(store: Store, where: Indices, values: Mapping[str, Any]) -> list[str]:
    """Fault of each point, from its stored values; empty for sound points."""
    group, done = store.group, store.flags[tuple(where.T)] == DONE
    has_fields = group.with_fields[tuple(where.T)]
    lost = [name for name, array in values.items() if array is None]
    of_all = {*lost} - {*DATA, "steps"}  # points that failed have no results
    right = values["checksum"] if lost else checksums(group, where, values, done)

    def fault(row: int) -> str:
        if lost:
            return f"{', '.join(lost)} cannot be read" if done[row] or of_all else ""
        for name in values if done[row] else ():
            if name not in DATA or (name in FIELDS and not has_fields[row]):
                continue
            if (stored := values[name][row]) is None:
                return f"{name} cannot be read"
            end = stored[-1] if group.is_stepped(name) else stored
            if end.dtype.kind == "f" and np.isnan(end).any():
                return f"{name} is missing"
        is_whole = right[row] == values["checksum"][row]
        return "" if is_whole else "its values are not those that were written"

    return [fault(row) for row in range(len(where))]


def find_damage(store: Store, progress: Report = silent) -> Damage:
    """Read all data to find what is damaged; the store must have been opened with `damage`."""
    assert store.damage is not None
    for checked in checked_points(store, progress):
        for index, fault in zip(checked.where.tolist(), checked.faults, strict=True):
            if fault:
                store.damage.points[tuple(index)] = fault
    for name, values in sorted(store.group.coordinates.items()):
        stored = store.try_read(name, tuple(slice(0, n) for n in store.arrays[name].shape))
        right = np.asarray(values, store.arrays[name].dtype)
        if stored is None or not np.array_equal(stored, right, equal_nan=right.dtype.kind == "f"):
            store.damage.files.pop(store.key(name, [0] * right.ndim), None)
            store.damage.files[f"{store.group.prefix}{path_of(name)}"] = name, ..., values
    return store.damage


def mend(store: Store) -> int:
    """Mark damaged points as pending, and replace damaged files; return their number."""
    damage, flags = find_damage(store), store.flags.copy()
    for index in damage.points:
        flags[index] = PENDING
    store.set_flags(flags)  # before the files: after a kill, points marked as done are sound
    store.put(damage.files.values())
    return len(damage.points) + len(damage.files)

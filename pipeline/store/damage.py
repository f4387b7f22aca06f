"""Faults of the points of a store, found by reading all of its files."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store.layout import block_at, checksums
from pipeline.store.schema import DATA, DONE, FAILED, FIELDS, PENDING, is_coordinate, path_of
from pipeline.store.store import Damage, Store
from tribo.types import Indices

_MAX_FIELD_BYTES = 2**25  # bytes of fields read at once
_THREADS = 8  # concurrent requests to an object store


class Checked(NamedTuple):
    """A batch of points with their values by variable and the fault of each."""

    indices: Indices  # index along each dimension, shape (n, n_dim)
    values: dict[str, Any]  # by variable; None if a chunk is damaged
    faults: list[str]  # empty for sound points


def checked_points(store: Store, progress: Report = silent) -> Iterator[Checked]:
    """Yield the done and failed points in batches, with the fault of each.

    All chunks are read in turn; those that cannot be read are added to `store.damage`.
    """
    names = [name for name in store.arrays if not (name == "status" or is_coordinate(name))]
    fields = [name for name in names if name in FIELDS]
    columns = [name for name in names if name not in FIELDS]
    field_bytes = sum(4 * math.prod(store.arrays[name].chunks) for name in fields)
    max_points = max(_MAX_FIELD_BYTES // max(field_bytes, 1), 1)
    sizes = store.block_of("message")
    chunks = [*np.ndindex(*np.ceil(np.divide(store.flags.shape, sizes)).astype(int))]
    for count, chunk in enumerate(chunks, 1):
        block = block_at(chunk, sizes)
        parts = [tuple(itertools.compress(block, store.group.has_dims(name))) for name in columns]
        with ThreadPoolExecutor(_THREADS) as threads:
            values_of_chunk = [*threads.map(store.try_read, columns, parts)]
        within = np.argwhere(np.isin(store.flags[block], (DONE, FAILED)))
        for chunk_indices in np.split(within, range(max_points, len(within), max_points)):
            values = dict[str, Any]()
            for name, chunk_values in zip(columns, values_of_chunk, strict=True):
                positions = tuple(store.group.point_indices(name, chunk_indices).T)
                values[name] = None if chunk_values is None else chunk_values[positions]
            indices = chunk_indices + [part.start for part in block]
            values |= {name: _read_fields(store, name, indices) for name in fields}
            yield Checked(indices, values, _faults(store, indices, values))
        progress(Progress(done=count, total=len(chunks)))


def _read_fields(store: Store, name: str, indices: Indices) -> list[Any]:
    """A field of each point; None if it is lost, or the point is not done or has no fields."""
    fields: list[Any] = [None] * len(indices)
    rows = np.flatnonzero((store.group.with_fields & (store.flags == DONE))[tuple(indices.T)])
    chunks = store.group.point_indices(name, indices[rows]).tolist()  # a chunk has one point
    parts = [block_at(chunk, [1] * len(chunk)) for chunk in chunks]
    with ThreadPoolExecutor(_THREADS) as threads:
        read_parts = threads.map(store.try_read, [name] * len(parts), parts)
        for row, part, values in zip(rows.tolist(), parts, read_parts, strict=True):
            fields[row] = None if values is None else values[(0,) * len(part)]
    return fields


def _faults(store: Store, indices: Indices, values: Mapping[str, Any]) -> list[str]:
    """Fault of each point, from its stored values; empty for sound points."""
    group, done = store.group, store.flags[tuple(indices.T)] == DONE
    lost = [name for name, array in values.items() if array is None]
    if lost:
        fault = f"{', '.join(lost)} cannot be read"
        is_of_all = bool({*lost} - {*DATA, "steps"})  # points that failed have no results
        return [fault if is_done or is_of_all else "" for is_done in done]
    faults, has_fields = [], done & group.with_fields[tuple(indices.T)]
    is_written = checksums(group, indices, values, done) == values["checksum"]
    names = [name for name in values if name in DATA]
    for row, is_done in enumerate(done):
        fault = "" if is_written[row] else "its values are not those that were written"
        for name in reversed(names) if is_done else ():  # the fault of the first one is stated
            stored = values[name][row]
            if stored is None:
                fault = f"{name} cannot be read" if has_fields[row] else fault
            elif np.isnan(stored[-1] if group.is_stepped(name) else stored).any():
                fault = f"{name} is missing"
        faults.append(fault)
    return faults


def find_damage(store: Store, progress: Report = silent) -> Damage:
    """Read all data to find what is damaged."""
    for checked in checked_points(store, progress):
        for index, fault in zip(checked.indices.tolist(), checked.faults, strict=True):
            if fault:
                store.damage.points[tuple(index)] = fault
    for name, values in sorted(store.group.coordinates.items()):
        stored = store.try_read(name, tuple(slice(0, n) for n in store.arrays[name].shape))
        expected = np.asarray(values, store.arrays[name].dtype)
        has_nan = expected.dtype.kind == "f"
        if stored is None or not np.array_equal(stored, expected, equal_nan=has_nan):
            store.damage.files.pop(store.key(name, [0] * expected.ndim), None)
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

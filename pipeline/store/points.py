"""The points of a store, read in batches: to find damaged ones, and to copy sound ones."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store import schema
from pipeline.store.layout import block_at
from pipeline.store.store import Index, Store
from pipeline.sweep.plan import choose_stored_steps
from tribo.types import Indices

_MAX_FIELD_BYTES = 2**25  # bytes of fields read at once
_OF_DONE = {*schema.DATA, "steps"}  # variables that points that failed do not have


class Batch(NamedTuple):
    """Some points with their values by variable and the fault of each."""

    indices: Indices  # index along each dimension, shape (n, n_dim)
    values: dict[str, Any]  # by variable; None if a chunk, or the field of a point, is missing
    faults: list[str]  # empty for sound points


def batches(store: Store, progress: Report = silent) -> Iterator[Batch]:
    """Yield all done and failed points; chunks that cannot be read go to `store.unreadable`."""
    names = [name for name in store.arrays if not (name == "status" or schema.is_coordinate(name))]
    fields = [name for name in names if name in schema.FIELDS]
    columns = [name for name in names if name not in schema.FIELDS]
    field_bytes = sum(4 * math.prod(store.arrays[name].chunks) for name in fields)
    max_points = max(_MAX_FIELD_BYTES // max(field_bytes, 1), 1)
    sizes = store.block_of("message")
    chunks = [*np.ndindex(*np.ceil(np.divide(store.flags.shape, sizes)).astype(int))]
    for count, chunk in enumerate(chunks, 1):
        block = block_at(chunk, sizes)
        within = np.argwhere(np.isin(store.flags[block], (schema.DONE, schema.FAILED)))
        has_results = bool((store.flags[block] == schema.DONE).any())
        chunk_values = {
            name: store.try_read(name, tuple(itertools.compress(block, store.group.has_dims(name))))
            for name in columns
            if has_results or (len(within) and name not in _OF_DONE)
        }
        for chunk_indices in np.split(within, range(max_points, len(within), max_points)):
            values = dict[str, Any]()
            for name, read in chunk_values.items():
                positions = tuple(store.group.point_indices(name, chunk_indices).T)
                values[name] = None if read is None else read[positions]
            indices = chunk_indices + [part.start for part in block]
            values |= {name: _read_fields(store, name, indices) for name in fields if has_results}
            yield Batch(indices, values, _faults(store, indices, values))
        progress(Progress(done=count, total=len(chunks)))


def _read_fields(store: Store, name: str, indices: Indices) -> list[Any]:
    """A field of each point; None if it is lost, or the point is not done or has no fields."""
    fields: list[Any] = [None] * len(indices)
    has_fields = (store.group.with_fields & (store.flags == schema.DONE))[tuple(indices.T)]
    for row in np.flatnonzero(has_fields).tolist():
        (chunk,) = store.group.point_indices(name, indices[[row]]).tolist()  # of a single point
        values = store.try_read(name, block_at(chunk, [1] * len(chunk)))
        fields[row] = None if values is None else values[(0,) * len(chunk)]
    return fields


def _faults(store: Store, indices: Indices, values: dict[str, Any]) -> list[str]:
    """Fault of each point, from its stored values; empty for sound points.

    A point that is done has a number at its end in each result. One that failed has no results.
    """
    at = tuple(indices.T)
    is_done, has_fields = store.flags[at] == schema.DONE, store.group.with_fields[at]
    faults = [""] * len(indices)
    for name, column in values.items():
        has_value = (
            is_done & has_fields if name in schema.FIELDS else is_done | (name not in _OF_DONE)
        )
        if name == "message":  # which a point that is done does not have
            has_value = ~is_done
        if column is None:
            is_lost, problem = has_value, "cannot be read"
        elif name in schema.FIELDS:
            is_lost, problem = has_value & [field is None for field in column], "cannot be read"
        elif name in schema.DATA:
            ends = column[:, -1] if store.group.is_stepped(name) else column
            is_nan = np.isnan(ends).reshape(len(ends), -1).any(axis=1)
            is_lost, problem = has_value & is_nan, "is missing"
        else:
            continue
        for row in np.flatnonzero(is_lost):
            faults[row] = faults[row] or f"{name} {problem}"
    return faults


class Damage(NamedTuple):
    """Damaged points with the fault of each, and damaged files by path."""

    points: dict[Index, str]
    files: list[str]


def find_damage(store: Store, progress: Report = silent) -> Damage:
    """Read all data of a store, without those of its tests, to find what is damaged."""
    points = {
        tuple(index): fault
        for batch in batches(store, progress)
        for index, fault in zip(batch.indices.tolist(), batch.faults, strict=True)
        if fault
    }
    files = {*store.unreadable}
    for name, values in store.group.coordinates.items():
        stored = store.try_read(name, tuple(slice(0, n) for n in store.arrays[name].shape))
        expected = np.asarray(values, store.arrays[name].dtype)
        has_nan = expected.dtype.kind == "f"
        if stored is None or not np.array_equal(stored, expected, equal_nan=has_nan):
            files.add(f"{store.group.prefix}{schema.path_of(name)}")
    return Damage(points, sorted(files))


def copy_points(target_store: Store, source_store: Store) -> int:
    """Copy done points of `source_store` that are pending in `target_store`; return their number.

    Points of the two stores are the same if scene, load and velocity are the same, whatever their
    cases are called. Damaged points are not copied. Nothing is copied if the stores have results
    at different times, or `source_store` lacks a variable of `target_store`.
    """
    return sum(
        transfer(target, source, (schema.DONE,))[0]
        for target, source in zip(target_store.groups, source_store.groups, strict=False)
        if choose_stored_steps(target.sweep) == choose_stored_steps(source.sweep)
        and target.arrays.keys() & schema.DATA.keys() <= source.arrays.keys()
        and target.sweep.fields in (False, source.sweep.fields)
    )


def transfer(target: Store, source: Store, states: Collection[int]) -> tuple[int, int]:
    """Copy pending points that have one of the `states` in `source`.

    Returns the number of points copied, and that of damaged points, which are not.
    """
    pending = defaultdict[tuple[Any, ...], list[Index]](list)
    for point in target.pending():
        pending[target.group.scene_hash(point), *point[:2]].append(target.index(point))
    copied, damaged = 0, 0
    for indices, columns, faults in batches(source):
        rows, target_indices, flags = list[int](), list[Index](), source.flags[tuple(indices.T)]
        for row, point in enumerate(source.group.points_at(tuple(indices.T))):
            needing_indices = pending.get((source.group.scene_hash(point), *point[:2]), [])
            if faults[row]:
                damaged += bool(needing_indices)
                continue
            lacks_fields = flags[row] == schema.DONE and any(
                columns[name][row] is None for name in schema.FIELDS.keys() & columns.keys()
            )
            for index in needing_indices if flags[row] in states else ():
                # A point is simulated again if `source` lacks its fields.
                if not (lacks_fields and target.group.with_fields[index]):
                    rows.append(row)
                    target_indices.append(index)
        if rows:
            values = {
                name: [column[row] for row in rows]
                for name, column in columns.items()
                if name in target.arrays and column is not None
            }
            values.setdefault("message", [""] * len(rows))
            target.write(np.array(target_indices), values, flags[rows])
        copied += len(rows)
    return copied, damaged

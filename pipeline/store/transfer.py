"""Copy points of one store into another."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from pipeline.store.damage import checked_points
from pipeline.store.schema import DATA, DONE, FIELDS
from pipeline.store.store import Index, Store
from pipeline.sweep.plan import choose_stored_steps


class Transfer(NamedTuple):
    """Numbers of points that were copied, damaged, and sound but not pending in the target."""

    copied: int
    damaged: int
    left_over: int


def copy_points(target_store: Store, source_store: Store) -> int:
    """Copy done points of `source_store` that are pending in `target_store`; return their number.

    Points of the two stores are the same if scene, load and velocity are the same, whatever their
    cases are called. Damaged points are not copied. Nothing is copied if the stores have results
    at different times, or `source_store` lacks a variable of `target_store`.
    """
    return sum(
        transfer(target, source, (DONE,)).copied
        for target, source in zip(target_store.groups, source_store.groups, strict=False)
        if choose_stored_steps(target.sweep) == choose_stored_steps(source.sweep)
        and target.arrays.keys() & DATA.keys() <= source.arrays.keys()
        and target.sweep.fields in (False, source.sweep.fields)
    )


def transfer(
    target: Store, source: Store, states: Collection[int], stored: Collection[str] = ()
) -> Transfer:
    """Copy pending points that have one of the `states` in `source`.

    The files of the variables `stored` are in place.
    """
    pending = defaultdict[tuple[Any, ...], list[Index]](list)
    for point in target.pending():
        pending[target.group.scene_hash(point), *point[:2]].append(target.index(point))
    copied, damaged, left_over = 0, 0, 0
    for indices, columns, faults in checked_points(source):
        rows, target_indices, flags = list[int](), list[Index](), source.flags[tuple(indices.T)]
        for row, point in enumerate(source.group.points_at(tuple(indices.T))):
            needing_indices = pending.get((source.group.scene_hash(point), *point[:2]), [])
            if faults[row]:
                damaged += bool(needing_indices)
                continue
            left_over += not needing_indices
            lacks_fields = flags[row] == DONE and any(
                columns[name][row] is None for name in FIELDS.keys() & columns.keys()
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
                if name in target.arrays.keys() - {"checksum"} and column is not None
            }
            target.write(np.array(target_indices), values, flags[rows], stored)
        copied += len(rows)
    return Transfer(copied, damaged, left_over)

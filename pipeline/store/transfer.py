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


def copy_points(store: Store, other: Store) -> int:
    """Copy done points of `other` that are pending in `store`; return their number.

    Points of the two stores are the same if scene, load and velocity are the same, whatever their
    cases are called. Damaged points are not copied. Nothing is copied if the stores have results
    at different times, or `other` lacks a variable of `store`.
    """
    return sum(
        transfer(target, source, (DONE,)).copied
        for target, source in zip(store.groups, other.groups, strict=False)
        if choose_stored_steps(target.sweep) == choose_stored_steps(source.sweep)
        and target.arrays.keys() & DATA.keys() <= source.arrays.keys()
        and target.sweep.fields in (False, source.sweep.fields)
    )


def transfer(
    store: Store, other: Store, states: Collection[int], stored: Collection[str] = ()
) -> Transfer:
    """Copy pending points that have one of the `states` in `other`.

    The files of the variables `stored` are in place.
    """
    pending = defaultdict[tuple[Any, ...], list[Index]](list)
    for point in store.pending():
        pending[store.group.scene_hash(point), *point[:2]].append(store.index(point))
    copied, damaged, left_over = 0, 0, 0
    for where, columns, faults in checked_points(other):
        rows, indices, flags = list[int](), list[Index](), other.flags[tuple(where.T)]
        for row, point in enumerate(other.group.points_at(tuple(where.T))):
            targets = pending.get((other.group.scene_hash(point), *point[:2]), [])
            if faults[row]:
                damaged += bool(targets)
                continue
            left_over += not targets
            lacks_fields = flags[row] == DONE and any(
                columns[name][row] is None for name in FIELDS.keys() & columns.keys()
            )
            for index in targets if flags[row] in states else ():
                # A point is simulated again if `other` lacks its fields.
                if not (lacks_fields and store.group.with_fields[index]):
                    rows.append(row)
                    indices.append(index)
        if rows:
            values = {
                name: [column[row] for row in rows]
                for name, column in columns.items()
                if name in store.arrays.keys() - {"checksum"} and column is not None
            }
            store.write(np.array(indices), values, flags[rows], stored)
        copied += len(rows)
    return Transfer(copied, damaged, left_over)

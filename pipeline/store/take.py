"""Points that a new store takes from another one, where they are the same."""

from __future__ import annotations

from typing import Any

from pipeline.store.checksum import checksum
from pipeline.store.layout import blocks
from pipeline.store.schema import DATA, DONE
from pipeline.store.verify import fault_of, read_block, stored_entries
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord, choose_stations


def take_points(store: Store, other: Store) -> int:
    """Copy done points of `other` that are pending in `store`; return their number.

    Points of the two stores are the same if scene, load and velocity are the same, whatever their
    variants are called. Points with a wrong checksum are not copied. Nothing is copied if the
    stores keep results at different times, or `other` lacks a variable of `store`.
    """
    of_tests = 0
    if store.tests and other.tests:
        of_tests = take_points(store.tests, other.tests)
    data = store.arrays.keys() & DATA.keys()
    if choose_stations(store.sweep) != choose_stations(other.sweep) or data - other.arrays.keys():
        return of_tests
    wanted: dict[tuple[Any, ...], list[Point]] = {}
    for point in store.pending():
        wanted.setdefault((store.root.scene_hash(point), *point[:2]), []).append(point)
    count = of_tests
    for _, block in blocks(other.flags == DONE, other.block):
        for part, values in read_block(other, block):
            records = []
            for index, here, entries in stored_entries(other, part, values):
                if other.flags[index] != DONE or fault_of(other, here, entries):
                    continue
                records += [
                    PointRecord(
                        point,
                        {name: entries[name] for name in data},
                        entries["message"],
                        entries["warning_flags"],
                        entries["wall_time"],
                        checksum=checksum(store.root.scene_hash(point), point, entries),
                    )
                    for point in wanted.get((other.root.scene_hash(here), *here[:2]), ())
                ]
            store.commit(records)
            count += len(records)
    return count

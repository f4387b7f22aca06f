"""Points that a new store takes from another one, where they are the same."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.store.checksum import checksum
from pipeline.store.layout import blocks
from pipeline.store.schema import AT_END, DONE, OF_POINT, STEPPED
from pipeline.store.verify import fault_of, read_block, stored_entries
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.station_choice import choose_stations


def take_points(store: Store, other: Store) -> int:
    """Commit points of another store that are pending in this one, and count them.

    They have the same scene, load and velocity, whatever their rows are called. Points that do not
    have their checksum stay where they are.
    """
    data = store.arrays.keys() & {*STEPPED, *AT_END, *OF_POINT}
    if choose_stations(store.sweep) != choose_stations(other.sweep) or data - other.arrays.keys():
        return 0
    wanted: dict[tuple[Any, ...], list[Point]] = {}
    for point in store.pending():
        wanted.setdefault((store.simulated.at(point), *point[:2]), []).append(point)
    count = 0
    for block in _sound_blocks(other):
        records = [
            PointRecord(
                point,
                {name: entries[name] for name in data},
                entries["message"],
                entries["warning_flags"],
                entries["wall_time"],
                checksum=checksum(store.simulated.at(point), point, entries),
            )
            for here, entries in block
            for point in wanted.get((other.simulated.at(here), *here[:2]), ())
        ]
        store.commit(records)
        count += len(records)
    return count


def _sound_blocks(store: Store) -> Iterator[list[tuple[Point, dict[str, Any]]]]:
    """Done points of each chunk with their entries, as far as these have their checksum."""
    for _, block in blocks(store.flags == DONE, store.block):
        found = stored_entries(store, block, read_block(store, block))
        yield [
            (point, entries)
            for index, point, entries in found
            if store.flags[index] == DONE and not fault_of(store, point, entries)
        ]

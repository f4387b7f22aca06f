"""Whether what is done in a store is intact: points by their checksums, and coordinates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.store.chunks import Place
from pipeline.store.folder import StoreError
from pipeline.store.identity import checksum
from pipeline.store.snapshot import Snapshot
from pipeline.store.variables import (
    BULK_COLUMNS,
    BULK_FIELDS,
    COLUMNS,
    FIELDS,
    HASHED,
    is_coordinate,
)
from pipeline.sweep.model import Point
from tribo.types import Array


class Checked(Snapshot):
    """A snapshot that tells what in its store is damaged."""

    def is_intact(self, point: Point) -> bool:
        """Whether all of a point can be read, and its data are those that were computed."""
        return self.fault(point) is None

    def fault(self, point: Point) -> str | None:
        """What is wrong with a point that should be done, if anything is."""
        missing: set[tuple[str, Place]] = set()
        names = [name for name in self.names if name != "status"]
        try:
            found = self.at(point, names, missing)
        except StoreError:
            return f"{', '.join(self.unreadable(point))} cannot be read"
        steps = np.count_nonzero(np.isfinite(found["time"]))
        data = {name: found[name][:steps] for name in (*COLUMNS, *BULK_COLUMNS) if name in found}
        if "pressure" in found and not self.lacks_fields(point):
            fields = (name for name in (*FIELDS, *BULK_FIELDS) if name in found)
            data |= {name: found[name] for name in fields}
        is_as_computed = found["checksum"] == self._checksum(point, data)
        lost = {
            name for name, place in missing if not (is_as_computed and self.is_later(name, place))
        }
        if lost:
            return f"{', '.join(name for name in names if name in lost)} is missing"
        return None if is_as_computed else "the data are not those that were computed"

    def unreadable(self, point: Point) -> list[str]:
        """Variables with damaged files at a point."""
        return [name for name in self.names if not self._is_readable(name, point)]

    def lacks_fields(self, point: Point) -> bool:
        """Whether a point has none of the fields that the store has room for."""
        return "pressure" in self._arrays and not self.has("pressure", point)

    def lost(self) -> list[Point]:
        """Points that are complete, but without a status that can be read."""
        _, known = self.flags()
        there = np.zeros_like(known)
        for place in self.places_of_chunks("checksum"):
            there[self.block(place)] = True
        points = self.points_at(np.nonzero(there & ~known))
        return [point for point in points if self.has("checksum", point) and self.is_intact(point)]

    def damaged_coordinates(self) -> list[str]:
        """Coordinates that cannot be read, or are not what was committed."""
        names = [name for name in self._arrays if is_coordinate(name)]
        return [name for name in names if not self.has_coordinate(name)]

    def _is_lost(self, name: str, place: Place) -> bool:
        """Whether a missing chunk of points of which some are done was lost.

        Where another point with more steps is on its way to the same chunks, or was when it was
        killed, some of the variables have chunks of later steps. Those that are done may need none.
        """
        if not self._may_be_lost(name, place):
            return False
        if not self.is_later(name, place):
            return True
        points = self.points_in(place[: len(self._places)])
        return any(self.is_done(point) and not self.is_intact(point) for point in points)

    def _is_readable(self, name: str, point: Point) -> bool:
        try:
            self.at(point, [name])
        except StoreError:
            return False
        return True

    def _checksum(self, point: Point, data: Mapping[str, Array]) -> np.uint64:
        is_old = self.attributes["format"] < HASHED
        return checksum(data, None if is_old else point)

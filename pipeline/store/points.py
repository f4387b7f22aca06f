"""Writes the points of a store: a Zarr group that any reader of Zarr opens.

The data of points are written first, with their checksums, then their status; a status of done
means that all of a point is on the disk. Points that share chunks are written together, by one
process at a time: it reads what the chunks hold, puts its points in, and replaces their files, in
each of which the others are as they were. The shape is committed likewise: arrays and coordinates
first, then the root ``zarr.json``, whose consolidated metadata is what readers go by. Whatever is
killed, and when, the store opens, and each point is either done or not.
"""

from __future__ import annotations

import functools
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np

from pipeline.store.checked import Checked
from pipeline.store.chunks import Place, chunks_with
from pipeline.store.folder import DAMAGED, UNREADABLE, PathLike, StoreError, part_held
from pipeline.store.shape import coordinate_chunks
from pipeline.store.soundness import sound
from pipeline.store.variables import (
    BULK_COLUMNS,
    COLUMNS,
    DONE,
    FAILED,
    PENDING,
)
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointResult
from tribo.types import Array


class Store(Checked):
    """An open store to which points can be written. It is pickled as its path.

    A process opens it once, and again only after its shape has changed.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (self.path, self.revision)

    def commit(self, *results: PointResult) -> None:
        """Put points on the disk, their status last, unless they are done already.

        Raises
        ------
        StoreError
            If they cannot be written.
        """
        self._write({each.point: self._values(each) for each in results}, {"status": DONE})

    def fail(self, point: Point, message: str) -> None:
        """Record why a point failed, unless it is done after all; raise as `commit` does."""
        self._write({point: {"message": message}}, {"status": FAILED})

    def forget(self, *points: Point) -> None:
        """Make points pending again, and what is damaged in their chunks; raise as `commit` does.

        Whatever cannot be read there was lost to all points that share it.
        """
        pending = {point: {"status": PENDING} for point in (*points, *self._damaged_beside(points))}
        self._write(pending, {"message": ""}, also_done=True)

    def heal(self) -> None:
        """Mark points as done that lost nothing but their status, and restore coordinates."""
        self._write({point: {} for point in self.lost()}, {"status": DONE}, also_done=True)
        for name in self.damaged_coordinates():
            self.restore(name)

    def discard(self, point: Point, names: Iterable[str]) -> None:
        """Remove what is stored in some variables of a point, and of others in the same chunks."""
        self._kept.clear()
        keys = []
        for name in names:
            array, place = self._arrays[name], self.place(name, self.index(point))
            further = np.ndindex(*array.counts(len(place)))
            keys += [array.key((*place, *along)) for along in further]
        self._files.remove(keys)

    def restore(self, coordinate: str) -> None:
        """Write a coordinate as it was committed."""
        self._files.put_all(coordinate_chunks(self.metadata, self.axes, [coordinate]))

    def _padded(self, name: str, values: Array) -> Array:
        """Values padded to the length of the store's axis of steps, to fill whole chunks."""
        if name not in COLUMNS and name not in BULK_COLUMNS:
            return values
        rows = np.full(self._arrays[name].shape[len(self._places) :], np.nan)
        rows[: len(values)] = values
        return rows

    def _values(self, result: PointResult) -> dict[str, Any]:
        """What is stored of a point, but for its status."""
        data = result.columns | (result.fields if "pressure" in self._arrays else {})
        about = {
            "wall_time": result.wall_time,
            "message": "; ".join(map(str, result.warnings)),
            "warning_flags": sum({int(warning.kind) for warning in result.warnings}),
            "finished_at": result.finished_at,
            "checksum": self._checksum(result.point, data),
        }
        # Older stores lack some of these.
        about = {name: value for name, value in about.items() if name in self._arrays}
        return {name: self._padded(name, values) for name, values in data.items()} | about

    def _write(
        self,
        values: Mapping[Point, Mapping[str, Any]],
        then: Mapping[str, Any],
        also_done: bool = False,
    ) -> None:
        """Write values of points, then what all of them have; return when they are on the disk.

        Points that share chunks are written together, and what else these chunks hold is written
        as it is, while nobody else writes to them. Points that are done are left alone if not asked
        for.
        """
        for place, points in self._by_place(values).items():
            try:
                with self._alone_at(place):
                    self._kept.clear()
                    flags = self._flags_at(place)
                    wanted = {
                        self.index(point): values[point]
                        for point in points
                        if also_done or flags[self.within("status", self.index(point))] != DONE
                    }
                    first, last = wanted, dict.fromkeys(wanted, then)
                    self._files.put_all(self._chunks(first, flags), self._chunks(last, flags))
            except OSError as error:
                others = f" and {len(points) - 1} more" if len(points) > 1 else ""
                raise StoreError(
                    f"{self.path}: the point at {points[0]}{others} cannot be recorded: "
                    f"{error.strerror or error}; what is finished is safe, go on when there is "
                    "room and permission to write"
                ) from error
            finally:
                self._kept.clear()

    def _by_place(self, points: Iterable[Point]) -> dict[Place, list[Point]]:
        """Points by the chunks that they share."""
        found: dict[Place, list[Point]] = {}
        for point in points:
            found.setdefault(self.place("status", self.index(point)), []).append(point)
        return found

    def _alone_at(self, place: Place) -> AbstractContextManager[None]:
        """Be the only one to write to the chunks at a place, as far as points share them."""
        return part_held(self.path, place) if self.is_shared else nullcontext()

    def _flags_at(self, place: Place) -> Array:
        """Status of the points of a chunk; where it was lost, that of what is intact is done."""
        array = self._arrays["status"]
        try:
            if (content := self._files.content(array.key(place))) is not None:
                return array.decoded(content)
        except UNREADABLE as error:
            if isinstance(error, OSError) and error.errno:  # that of the disk may pass
                raise
        flags = np.full(array.chunks, PENDING, array.dtype)
        if self.is_shared:
            for point in self.points_in(place):
                if self.has("checksum", point) and self.is_intact(point):
                    flags[self.within("status", self.index(point))] = DONE
            if flags.any():
                self._files.put_all([(array.key(place), array.encoded(flags))])
        return flags

    def _damaged_beside(self, points: Iterable[Point]) -> list[Point]:
        """Points in the same chunks as others, and not pending, of which something is damaged."""
        if not self.is_shared:
            return []
        flags, _ = self.flags()
        beside = np.zeros(flags.shape, bool)
        for place in self._by_place(points):
            beside[self.block(place)] = True
        for point in points:
            beside[self.index(point)] = False
        doubtful = beside & ((flags == FAILED) | (flags == DONE) & ~sound(self, flags, beside))
        found = self.points_at(np.nonzero(doubtful))
        return [each for each in found if self._is_lost_at(each, flags[self.index(each)])]

    def _is_lost_at(self, point: Point, flag: int) -> bool:
        """Whether something cannot be read that there has to be of a point."""
        if flag == DONE:
            return not self.is_intact(point)
        return "message" in self.unreadable(point) or not self.has("message", point)

    def _chunks(
        self, values: Mapping[Place, Mapping[str, Any]], flags: Array
    ) -> Iterator[tuple[str, bytes]]:
        """Keys and contents of the files with values at some indices that share chunks.

        `flags` are the statuses there so far.
        """
        by_name: dict[str, dict[Place, dict[Place, Any]]] = {}
        for index, own in values.items():
            for name, value in own.items():
                places = by_name.setdefault(name, {})
                places.setdefault(self.place(name, index), {})[index] = value
        for name, places in by_name.items():
            for place, entries in places.items():
                others = flags.copy()
                for index in values:
                    others[self.within("status", index)] = PENDING
                yield from chunks_with(
                    self._arrays[name], place, entries, self._there(name, flags, others)
                )

    def _there(self, name: str, flags: Array, others: Array) -> Callable[[str, Place], Any]:
        """A function that reads what the chunks of a variable hold now, for the sake of others.

        Raises
        ------
        StoreError
            If other points than those that are written need it, and it cannot be read.
        """
        array = self._arrays[name]
        needed = (others != PENDING if name == "message" else others == DONE).any()

        def there(key: str, place: Place) -> Any:
            if name == "status":
                return flags
            if not array.is_shared(len(self._places)):
                return None
            try:
                if (content := self._files.content(key)) is not None:
                    return array.decoded(content)
            except UNREADABLE as error:
                if needed:
                    raise StoreError(DAMAGED.format(self.path, name)) from error
                return None
            if needed and self._is_lost(name, place):
                raise StoreError(DAMAGED.format(self.path, name))
            return None

        return there


@functools.lru_cache(maxsize=4)
def _opened(path: PathLike, revision: str) -> Store:
    """The store at `path`; opened anew only after its root was replaced."""
    store = Store(path)
    if store.revision != revision:
        raise StoreError(
            f"{path} is not the same store, or not as it is now, on {socket.gethostname()}; every "
            "worker must see the store under the same path"
        )
    return store

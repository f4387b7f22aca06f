"""The store of a sweep: a Zarr group that any reader of Zarr opens, with every point committed.

Each chunk file belongs to one point, so that processes never meet in one. A point's data are
written first, with their checksum, then its status; a status of done means that all of it is on
the disk. The shape is committed likewise: arrays and coordinates first, then the root
``zarr.json``, whose consolidated metadata is what readers go by. Whatever is killed, and when,
the store opens, and each point is either done or not.
"""

from __future__ import annotations

import functools
import socket
import time
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.store.chunks import chunks_of
from pipeline.store.folder import (
    PathLike,
    StoreError,
    StoreMismatchError,
    folder_of,
    locked,
)
from pipeline.store.identity import checksum, describe, differences, stored_scene
from pipeline.store.root import begin, read_metadata, renew_copy
from pipeline.store.shape import commit_shape, coordinate_chunks
from pipeline.store.snapshot import Snapshot
from pipeline.store.variables import (
    COLUMNS,
    COORDINATES,
    DONE,
    FAILED,
    FIELDS,
    HASHED,
    PENDING,
    grown,
    lasting_attributes,
)
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointResult
from tribo import QUANTILES
from tribo.types import Array

__all__ = [
    "DONE",
    "FAILED",
    "PENDING",
    "Store",
    "StoreError",
    "StoreMismatchError",
    "locked",
    "prepare",
]


class Store(Snapshot):
    """An open store, to write points too. It crosses process borders as its path.

    A process opens it once, and again only after its shape has changed.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (self.path, self.revision)

    def commit(self, result: PointResult) -> None:
        """Put a point on the disk, its status last.

        Raises
        ------
        StoreError
            If it cannot be written.
        """
        data = result.columns | (result.fields if "pressure" in self._arrays else {})
        about = {
            "wall_time": result.wall_time,
            "message": "; ".join(map(str, result.warnings)),
            "warning_flags": sum({int(warning.kind) for warning in result.warnings}),
            "finished_at": time.time(),
            "checksum": self._checksum(result.point, data),
        }
        # Older stores lack some of these.
        about = {name: value for name, value in about.items() if name in self._arrays}
        padded = {name: self._padded(name, values) for name, values in data.items()}
        self._write(result.point, padded | about, {"status": DONE})

    def fail(self, point: Point, message: str) -> None:
        """Record why a point failed, unless it is done after all; raise as `commit` does."""
        if not self.is_done(point):
            self._write(point, {"message": message}, {"status": FAILED})

    def forget(self, point: Point) -> None:
        """Make a point pending again; raise as `commit` does."""
        self._write(point, {"status": PENDING}, {"message": ""})

    def is_intact(self, point: Point) -> bool:
        """Whether all of a point can be read, and its data are those that were computed."""
        return self.fault(point) is None

    def fault(self, point: Point) -> str | None:
        """What is wrong with a point that should be done, if anything is."""
        missing: set[str] = set()
        names = [name for name in self.names if name != "status"]
        try:
            found = self.at(point, names, missing)
        except StoreError:
            return f"{', '.join(self.unreadable(point))} cannot be read"
        if missing:
            return f"{', '.join(name for name in names if name in missing)} is missing"
        steps = np.count_nonzero(np.isfinite(found["time"]))
        data = {name: found[name][:steps] for name in COLUMNS}
        if "pressure" in found and not self.lacks_fields(point):
            data |= {name: found[name] for name in FIELDS}
        if found["checksum"] != self._checksum(point, data):
            return "the data are not those that were computed"
        return None

    def unreadable(self, point: Point) -> list[str]:
        """Variables with damaged files at a point."""
        return [name for name in self.names if not self._is_readable(name, point)]

    def lacks_fields(self, point: Point) -> bool:
        """Whether a point has none of the fields that the store has room for."""
        return "pressure" in self._arrays and not self.has("pressure", point)

    def lost(self) -> list[Point]:
        """Points that are complete, but without a status that can be read."""
        _, known = self.flags()
        unknown = np.ravel(~known)
        points = (point for point, is_so in zip(self.places(), unknown, strict=True) if is_so)
        return [point for point in points if self.has("checksum", point) and self.is_intact(point)]

    def heal(self) -> None:
        """Take points as done that lost nothing but their status, and restore coordinates."""
        if lost := self.lost():
            flags, _ = self.flags()
            for point in lost:
                flags[self.index(point)] = DONE
            array = self._arrays["status"]
            blocks = {self.place("status", self.index(point)) for point in lost}
            chunks = (chunks_of(array, place, flags[self.block(place)]) for place in blocks)
            self._files.put_many(chunk for found in chunks for chunk in found)
            self._kept.clear()
        for name in self.damaged_coordinates():
            self.restore(name)

    def discard(self, point: Point, names: Iterable[str]) -> None:
        """Remove what is stored in some variables of a point that is not done."""
        self._kept.clear()
        keys = []
        for name in names:
            array, place = self._arrays[name], self.place(name, self.index(point))
            further = np.ndindex(*array.counts(len(place)))
            keys += [array.key((*place, *along)) for along in further]
        self._files.remove(keys)

    def damaged_coordinates(self) -> list[str]:
        """Coordinates that are not, or cannot be read, as they were committed."""
        names = [name for name in COORDINATES if name in self._arrays]
        return [name for name in names if not self.has_coordinate(name)]

    def restore(self, coordinate: str) -> None:
        """Write a coordinate as it was committed."""
        self._files.put_all(coordinate_chunks(self.metadata, self.axes, [coordinate]))

    def _is_readable(self, name: str, point: Point) -> bool:
        try:
            self.at(point, [name])
        except StoreError:
            return False
        return True

    def _checksum(self, point: Point, data: Mapping[str, Array]) -> np.uint64:
        is_old = self.attributes["format"] < HASHED
        return checksum(data, None if is_old else point)

    def _padded(self, name: str, values: Array) -> Array:
        """Values as long as the store's axis of steps, which keeps whole chunks to one point."""
        if name not in COLUMNS:
            return values
        rows = np.full(self._arrays[name].shape[len(self._places) :], np.nan)
        rows[: len(values)] = values
        return rows

    def _write(self, point: Point, values: Mapping[str, Any], then: Mapping[str, Any]) -> None:
        """Write values of a point, then others; return when they are on the disk."""
        self._kept.clear()
        index = self.index(point)
        try:
            self._files.put_all(self._chunks(index, values), self._chunks(index, then))
        except OSError as error:
            raise StoreError(
                f"{self.path}: the point at {point} cannot be recorded: "
                f"{error.strerror or error}; what is finished is safe, go on when there is room "
                "and permission to write"
            ) from error

    def _chunks(self, index: tuple[int, ...], values: Mapping[str, Any]) -> Iterator[Any]:
        """Keys and contents of the files with values at an index."""
        for name, value in values.items():
            array, place = self._arrays[name], self.place(name, index)
            if max(array.chunks[: len(index)]) == 1:
                yield from chunks_of(array, place, value)
            else:
                block = self.block(place)
                try:
                    picks = [range(along.start, along.stop) for along in block]
                    picks += [range(n) for n in array.shape[len(index) :]]
                    there = self.pick(name, picks)
                except StoreError:
                    there = np.full([len(pick) for pick in picks], array.fill, array.dtype)
                there[tuple(i - along.start for i, along in zip(index, block, strict=True))] = value
                yield from chunks_of(array, place, there)


def prepare(path: PathLike, sweep: Sweep) -> Store:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    To be called while `locked`. What is in the store stays, whether or not the sweep still asks
    for it; what can be healed is.

    Raises
    ------
    StoreMismatchError
        If the store belongs to another scene; the message says how that differs.
    StoreError
        If there is something else in its place, or it cannot be written.
    """
    folder = folder_of(path)
    try:
        if begin(folder):
            commit_shape(folder, lasting_attributes(sweep), {}, grown({}, sweep), sweep)
            return Store(folder)
        store = Store(folder)
        axes = store.axes
        if ("realization" in axes) != bool(sweep.realizations):
            raise StoreMismatchError(f"{folder} {_OTHER_SURFACES[bool(sweep.realizations)]}")
        if different := [
            *differences(stored_scene(store.attributes), describe(sweep)),
            *differences(axes["quantile"], list(QUANTILES), "quantile"),
        ]:
            reason = f"{folder} belongs to another scene; write to another store"
            raise StoreMismatchError("\n  ".join([reason, *different]))
        renew_copy(folder)
        store.heal()
        commit_shape(folder, *read_metadata(folder), grown(axes, sweep), sweep)
        return Store(folder)
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error}") from error


_OTHER_SURFACES = {
    True: "has no axis for sweep.realizations, and the dimensions of a store stay what they were "
    "at its creation; write to another store",
    False: "has an axis for sweep.realizations, which the scene does not give; give the seeds "
    "that are wanted, or write to another store",
}


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

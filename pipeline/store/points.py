"""Writes the points of a store: a Zarr group that any reader of Zarr opens.

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

from pipeline.store.checked import Checked
from pipeline.store.chunks import chunks_of
from pipeline.store.folder import PathLike, StoreError
from pipeline.store.shape import coordinate_chunks
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

    def heal(self) -> None:
        """Mark points as done that lost nothing but their status, and restore coordinates."""
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

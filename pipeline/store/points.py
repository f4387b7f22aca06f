"""The store of a sweep: a Zarr group that any reader of Zarr opens, with every point committed.

Each chunk file belongs to one point, so that processes never meet in one. A point's data are
written first, then their checksum, then its status; a status of done means that all of it is on
the disk. The shape is committed likewise: arrays and coordinates first, then the root
``zarr.json``, whose consolidated metadata is what readers go by. Whatever is killed, and when,
the store opens, and each point is either done or not.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal

import numpy as np
import zarr
from zarr.api.asynchronous import open_group

from pipeline.store.chunks import chunks_of, values_at
from pipeline.store.files import Files, RemoteFiles, files_in
from pipeline.store.folder import (
    DAMAGED,
    UNREADABLE,
    PathLike,
    StoreError,
    StoreMismatchError,
    begin,
    folder_of,
    locked,
    read_metadata,
)
from pipeline.store.identity import checksum, describe, differences, stored_scene
from pipeline.store.shape import commit_shape
from pipeline.store.together import together
from pipeline.store.variables import (
    COLUMNS,
    COMPACT,
    COORDINATES,
    DONE,
    FAILED,
    FIELDS,
    PENDING,
    RECORDS,
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


_KEPT = 3  # chunks of each variable, if they hold many points


class Store:
    """An open store. It crosses process borders as its path; a process opens it once.

    Parameters
    ----------
    path : str or path
        Of a store that `prepare` has made.
    mode : {"r+", "r"}
        To write points too, or to read only.

    Attributes
    ----------
    path : Path or Remote
    attributes : dict
        Of the root group.
    axes : dict of list
        Values along each dimension, in the order of the store.

    Raises
    ------
    StoreError
        If there is no readable store.
    """

    def __init__(self, path: PathLike, mode: Literal["r+", "r"] = "r+") -> None:
        self.path = folder_of(path)
        self.attributes, arrays = read_metadata(self.path)
        self._revision = hashlib.sha256(json.dumps(arrays).encode()).hexdigest()
        self._files = files_in(self.path)
        (self._arrays,) = together([_opened_arrays(self._files, mode)])
        self.axes: dict[str, list[float]] = self.attributes.get("axes") or self._coordinates()
        self._kept: dict[tuple[str, tuple[int, ...]], Any] = {}
        self._places = {
            name: {value: index for index, value in enumerate(self.axes[name])}
            for name in ("realization", "load", "velocity")
            if name in self.axes
        }

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (self.path, self._revision)

    @property
    def is_compact(self) -> bool:
        """Whether a chunk holds many points."""
        return bool(self._arrays["status"].metadata.chunk_key_encoding.separator == COMPACT)

    def asked(self) -> list[Point]:
        """Points of the scene that was run last."""
        chosen = self.attributes.get("chosen")
        if chosen is not None:
            return [Point(*point) for point in chosen]
        surfaces = self.attributes.get("realizations") or [None]
        loads, velocities = self.attributes["loads"], self.attributes["velocities"]
        places = itertools.product(surfaces, velocities, loads)
        return [Point(load, velocity, surface) for surface, velocity, load in places]

    def status(self, points: Iterable[Point] | None = None) -> dict[Point, int]:
        """Status of some points, or of every point there is room for."""
        if points is not None:
            return {point: int(self._read(["status"], point)["status"]) for point in points}
        flags = self.values("status")
        return dict(zip(self.places(), flags.ravel().tolist(), strict=True))

    def is_done(self, point: Point) -> bool:
        """Whether a point is complete."""
        return bool(self._read(["status"], point)["status"] == DONE)

    def message(self, point: Point) -> str:
        """Why a point failed, or what to know of it."""
        return str(self._read(["message"], point)["message"])

    def finished_at(self) -> Array:
        """When points were finished [s], in no order; those of which it is known."""
        if "finished_at" not in self._arrays:
            return np.empty(0)
        times: Array = self.values("finished_at")
        return times[np.isfinite(times)]

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
            "checksum": checksum(data),
        }
        # Older stores lack some of these.
        about = {name: value for name, value in about.items() if name in self._arrays}
        with self._writing(result.point) as write:
            write({name: self._padded(name, values) for name, values in data.items()} | about)
            write({"status": DONE})

    def fail(self, point: Point, message: str) -> None:
        """Record why a point failed, unless it is done after all; raise as `commit` does."""
        with self._writing(point) as write:
            if not self.is_done(point):
                write({"message": message})
                write({"status": FAILED})

    def forget(self, point: Point) -> None:
        """Make a point pending again; raise as `commit` does."""
        with self._writing(point) as write:
            write({"status": PENDING})
            write({"message": ""})

    def discard(self, point: Point, names: Iterable[str]) -> None:
        """Remove what is stored in some variables of a point that is not done."""
        self._kept.clear()
        together(self._files.delete(self._key(name, point)) for name in names)

    def damaged_coordinates(self) -> list[str]:
        """Coordinates that are not, or cannot be read, as they were committed."""
        names = [name for name in COORDINATES if name in self._arrays]
        return [name for name in names if self._coordinate(name) != self.axes[name]]

    def restore(self, coordinate: str) -> None:
        """Write a coordinate as it was committed."""
        values = np.array(self.axes[coordinate])
        together([self._arrays[coordinate].setitem(slice(None), values)])
        self._files.sync()

    @property
    def axes_of_points(self) -> dict[str, list[float]]:
        """Values along the dimensions that tell points apart."""
        return {name: self.axes[name] for name in self._places}

    def values(self, name: str) -> Any:
        """All of a variable."""
        return self._read([name])[name]

    def places(self) -> list[Point]:
        """Every point there is room for."""
        surfaces: Iterable[Any] = self.axes.get("realization", [None])
        places = itertools.product(surfaces, self.axes["load"], self.axes["velocity"])
        return [Point(load, velocity, surface) for surface, load, velocity in places]

    def unreadable(self, point: Point) -> list[str]:
        """Variables with damaged files at a point."""
        names = [name for name in self._arrays if name not in COORDINATES]
        return [name for name in names if not self._is_readable(name, point)]

    def lacks_fields(self, point: Point) -> bool:
        """Whether a point has none of the fields that the store has room for."""
        if "pressure" not in self._arrays:
            return False
        (exists,) = together([self._files.exists(self._key("pressure", point))])
        return not exists

    def missing(self, point: Point) -> list[str]:
        """Variables without a file at a point, of those that each point writes on its way."""
        names = [name for name in RECORDS if name in self._arrays]
        there = together(self._files.exists(self._key(name, point)) for name in names)
        return [name for name, exists in zip(names, there, strict=True) if not exists]

    def is_intact(self, point: Point) -> bool:
        """Whether the data of a point are those that its checksum was taken of."""
        names = [name for name in (*COLUMNS, *FIELDS, "checksum") if name in self._arrays]
        try:
            found = self._read(names, point)
        except StoreError:
            return False
        steps = np.count_nonzero(np.isfinite(found["time"]))
        data = {name: found[name][:steps] for name in COLUMNS}
        fields = {name: found[name] for name in FIELDS if name in found}
        data |= {name: field for name, field in fields.items() if np.isfinite(field).any()}
        return bool(found["checksum"] == checksum(data))

    def _index(self, point: Point) -> tuple[int, ...]:
        return tuple(index[getattr(point, name)] for name, index in self._places.items())

    def _coordinates(self) -> dict[str, list[float]]:
        names = [name for name in COORDINATES if name in self._arrays]
        return {name: values.tolist() for name, values in self._read(names).items()}

    def _coordinate(self, name: str) -> list[float] | None:
        try:
            values: list[float] = self._read([name])[name].tolist()
        except StoreError:
            return None
        return values

    def _key(self, name: str, point: Point) -> str:
        """Name of the file with a variable at a point, the first of them along the steps."""
        array, index = self._arrays[name], self._index(point)
        place = tuple(i // size for i, size in zip(index, array.chunks, strict=False))
        place += (0,) * (len(array.shape) - len(index))
        return f"{name}/{array.metadata.encode_chunk_key(place)}"

    def _is_readable(self, name: str, point: Point) -> bool:
        try:
            self._read([name], point)
        except StoreError:
            return False
        return True

    def _read(self, names: Iterable[str], point: Point | None = None) -> dict[str, Any]:
        """Values by variable, all of them or those of a point."""
        names, index = list(names), () if point is None else self._index(point)
        with self._reading(names):
            if self.is_compact or isinstance(self._files, RemoteFiles):
                values = together(self._part(name, index) for name in names)
            else:
                content = self._files.content
                values = [values_at(self._arrays[name], index, content) for name in names]
        return {name: np.asarray(array)[()] for name, array in zip(names, values, strict=True)}

    @contextmanager
    def _reading(self, names: Iterable[str]) -> Iterator[None]:
        try:
            yield
        except UNREADABLE as error:
            raise StoreError(DAMAGED.format(self.path, " or ".join(names))) from error

    async def _part(self, name: str, index: tuple[int, ...]) -> Any:
        """Values of a variable at a point; what else its chunk holds is kept for the next ones."""
        array = self._arrays[name]
        sizes = array.chunks[: len(index)]
        if max(sizes, default=1) == 1:
            return await array.getitem((*index, ...))
        begins = tuple(i // size * size for i, size in zip(index, sizes, strict=True))
        if (name, begins) not in self._kept:
            block = tuple(slice(i, i + size) for i, size in zip(begins, sizes, strict=True))
            self._kept[name, begins] = np.asarray(await array.getitem(block))
            while len(self._kept) > _KEPT * len(self._arrays):
                del self._kept[next(iter(self._kept))]
        return self._kept[name, begins][tuple(i - j for i, j in zip(index, begins, strict=True))]

    def _padded(self, name: str, values: Array) -> Array:
        """Values as long as the store's axis of steps, which keeps whole chunks to one point."""
        if name not in COLUMNS:
            return values
        rows = np.full(self._arrays[name].shape[len(self._places) :], np.nan)
        rows[: len(values)] = values
        return rows

    @contextmanager
    def _writing(self, point: Point) -> Iterator[Callable[[Mapping[str, Any]], None]]:
        """Give a function that writes values of a point, and returns when they are on the disk."""
        index = self._index(point)

        def write(values: Mapping[str, Any]) -> None:
            self._kept.clear()
            arrays = ((self._arrays[name], value) for name, value in values.items())
            if self.is_compact:
                together(array.setitem(index, value) for array, value in arrays)
                self._files.sync()
            else:
                parts = (chunks_of(array, index, value) for array, value in arrays)
                self._files.put_all(itertools.chain.from_iterable(parts))

        try:
            yield write
        except OSError as error:
            raise StoreError(
                f"{self.path}: the point at {point} cannot be recorded: "
                f"{error.strerror or error}; what is finished is safe, go on when there is room "
                "and permission to write"
            ) from error


def prepare(path: PathLike, sweep: Sweep) -> Store:
    """Create the store of a sweep, or open it and make room for what the sweep adds.

    To be called while `locked`. What is in the store stays, whether or not the sweep still asks
    for it.

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
        attributes, arrays = read_metadata(folder)
        axes = Store(folder, mode="r").axes
        if ("realization" in axes) != bool(sweep.realizations):
            raise StoreMismatchError(f"{folder} {_OTHER_SURFACES[bool(sweep.realizations)]}")
        if different := [
            *differences(stored_scene(attributes), describe(sweep)),
            *differences(axes["quantile"], list(QUANTILES), "quantile"),
        ]:
            reason = f"{folder} belongs to another scene; write to another store"
            raise StoreMismatchError("\n  ".join([reason, *different]))
        commit_shape(folder, attributes, arrays, grown(axes, sweep), sweep)
        return Store(folder)
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error}") from error


_OTHER_SURFACES = {
    True: "has no axis for sweep.realizations, and the dimensions of a store stay what they were "
    "at its creation; write to another store",
    False: "has an axis for sweep.realizations, which the scene does not give; give the seeds "
    "that are wanted, or write to another store",
}


async def _opened_arrays(files: Files | RemoteFiles, mode: Literal["r+", "r"]) -> dict[str, Any]:
    """Arrays of a store by name, as its consolidated metadata has them."""
    with zarr.config.set({"array.write_empty_chunks": True}):
        group = await open_group(store=files, mode=mode, use_consolidated=True)
        return {name: array async for name, array in group.arrays()}


@functools.lru_cache(maxsize=4)
def _opened(path: PathLike, revision: str) -> Store:
    """The store at `path`; opened anew only after it has grown."""
    return Store(path)

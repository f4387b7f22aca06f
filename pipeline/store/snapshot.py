"""A store as its root describes it at one time, to be read.

A chunk that is missing where there must be one is damage, never a fill value. While the layout of
a store changes, what a root describes is removed only after that root was replaced: who reads asks
afterwards whether the snapshot is current, and takes another if it is not (`read_whole`).
"""

from __future__ import annotations

import functools
import itertools
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np

from pipeline.store.chunks import ChunkedArray, Place, keys_at, picked, values_at
from pipeline.store.files import RemoteFiles, files_in
from pipeline.store.folder import DAMAGED, UNREADABLE, PathLike, StoreError, folder_of
from pipeline.store.root import hash_of, read_metadata
from pipeline.store.variables import COLUMNS, COMPACT, COORDINATES, DONE, FAILED, FIELDS, PENDING
from pipeline.sweep.model import Point
from tribo.types import Array

_T = TypeVar("_T")
_S = TypeVar("_S", bound="Snapshot")
_KEPT = 3  # chunks of each variable, if they hold many points
_ATTEMPTS = 20
_LOOKS = 3  # at what cannot be read, since a point may just be written anew
A_COMMIT = 0.1
"""Time in which a point is mostly committed [s]."""


class Snapshot:
    """A store as it was committed last.

    Parameters
    ----------
    path : str or path

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

    def __init__(self, path: PathLike) -> None:
        self.path = folder_of(path)
        self.attributes, self.metadata = read_metadata(self.path)
        self._files = files_in(self.path)
        self._arrays = {name: ChunkedArray.of(name, each) for name, each in self.metadata.items()}
        self.axes: dict[str, list[float]] = self.attributes.get("axes") or {
            name: self.values(name).tolist() for name in COORDINATES if name in self._arrays
        }
        self._kept: dict[tuple[str, Place], Any] = {}
        self._places = {
            name: {value: index for index, value in enumerate(self.axes[name])}
            for name in ("realization", "load", "velocity")
            if name in self.axes
        }

    @functools.cached_property
    def revision(self) -> str:
        """What tells this state of the store from others, of a store that was here before, too."""
        return hash_of(self.attributes, self.metadata)

    def is_current(self) -> bool:
        """Whether nothing was committed to the root since; what was read since is whole then."""
        return read_metadata(self.path) == (self.attributes, self.metadata)

    @property
    def is_compact(self) -> bool:
        """Whether a chunk holds many points."""
        return self._arrays["status"].separator == COMPACT

    @property
    def names(self) -> list[str]:
        """Variables of the store, but its coordinates."""
        return [name for name in self._arrays if name not in COORDINATES]

    def array(self, name: str) -> ChunkedArray:
        """How a variable lies in chunks."""
        return self._arrays[name]

    @property
    def axes_of_points(self) -> dict[str, list[float]]:
        """Values along the dimensions that tell points apart."""
        return {name: self.axes[name] for name in self._places}

    def asked(self) -> list[Point]:
        """Points of the scene that was run last."""
        chosen = self.attributes.get("chosen")
        if chosen is not None:
            return [Point(*point) for point in chosen]
        surfaces = self.attributes.get("realizations") or [None]
        loads, velocities = self.attributes["loads"], self.attributes["velocities"]
        places = itertools.product(surfaces, velocities, loads)
        return [Point(load, velocity, surface) for surface, velocity, load in places]

    def places(self) -> list[Point]:
        """Every point there is room for."""
        surfaces: Iterable[Any] = self.axes.get("realization", [None])
        places = itertools.product(surfaces, self.axes["load"], self.axes["velocity"])
        return [Point(load, velocity, surface) for surface, load, velocity in places]

    def status(self) -> dict[Point, int]:
        """Status of every point there is room for; pending if not readable."""
        flags, _ = self.flags()
        return dict(zip(self.places(), flags.ravel().tolist(), strict=True))

    def flag(self, point: Point) -> int:
        """Status of a point; pending if not readable."""
        try:
            flag = int(self.at(point, ["status"])["status"])
        except StoreError:
            return PENDING
        return flag if flag in (DONE, FAILED) else PENDING

    def flags(self) -> tuple[Any, Any]:
        """Status by place, and where it is known: there is one, and it can be read."""
        array = self._arrays["status"]
        flags = np.full(array.shape, PENDING, array.dtype)
        known = np.zeros(array.shape, bool)
        places = list(np.ndindex(*array.counts()))
        try:
            contents = list(self._files.contents(map(array.key, places)))
        except OSError as error:
            raise StoreError(f"{self.path} cannot be read: {error}") from error
        for place, content in zip(places, contents, strict=True):
            with suppress(*UNREADABLE):
                if content is not None:
                    block = self.block(place)
                    part = array.decoded(content)
                    flags[block] = part[tuple(slice(n) for n in flags[block].shape)]
                    known[block] = True
        known &= np.isin(flags, (PENDING, DONE, FAILED))
        return np.where(known, flags, PENDING), known

    def block(self, place: Place) -> tuple[slice, ...]:
        """The points of a chunk."""
        array = self._arrays["status"]
        return tuple(
            slice(i * size, min((i + 1) * size, end))
            for i, size, end in zip(place, array.chunks, array.shape, strict=True)
        )

    def is_done(self, point: Point) -> bool:
        """Whether a point is complete."""
        return self.flag(point) == DONE

    def message(self, point: Point) -> str:
        """Why a point failed, or what to know of it."""
        return str(self.at(point, ["message"])["message"])

    def finished_at(self) -> Array:
        """When points were finished [s], in no order; those of which it is known."""
        if "finished_at" not in self._arrays:
            return np.empty(0)
        times: Array = self.values("finished_at")
        return times[np.isfinite(times)]

    def values(self, name: str) -> Any:
        """All of a variable, with fill values where nothing was written."""
        return self.pick(name, [np.arange(n) for n in self._arrays[name].shape])

    def has_coordinate(self, name: str) -> bool:
        """Whether a coordinate is as it was committed."""
        try:
            values: list[float] = self.values(name).tolist()
        except StoreError:
            return False
        return values == self.axes[name]

    def pick(self, name: str, picks: Sequence[Any], needed: Any = None) -> Any:
        """Read a part of a variable.

        Parameters
        ----------
        name : str
        picks : sequence of array_like of int
            Which entries, along each dimension.
        needed : ndarray of bool, optional
            By place, which points must be there; the others are not read. All are read, as far as
            they are there, if not given.

        Raises
        ------
        StoreError
            If something cannot be read, or is missing and needed.
        """

        def is_wanted(into: tuple[Any, ...]) -> Any:
            return needed is None or needed[into[: needed.ndim]].any()

        def lacks(key: str, place: Place) -> None:
            if needed is not None and self._is_lost(name, place):
                raise FileNotFoundError(key)

        try:
            return picked(self._arrays[name], picks, self._files.contents, is_wanted, lacks)
        except UNREADABLE as error:
            raise StoreError(DAMAGED.format(self.path, name)) from error

    def at(self, point: Point, names: Iterable[str], missing: set[str] | None = None) -> Any:
        """Values of variables at a point; a name whose file is lost is added to `missing`.

        Raises
        ------
        StoreError
            If something cannot be read.
        """
        index, values = self.index(point), {}
        content = self._contents(names, index)

        def lacks(name: str) -> Callable[[str, Place], None]:
            def note(_: str, place: Place) -> None:
                if missing is not None and self._is_lost(name, place):
                    missing.add(name)

            return note

        for name in names:
            array, note = self._arrays[name], lacks(name)
            try:
                if max(array.chunks[: len(index)]) == 1:
                    values[name] = values_at(array, index, content, note)[()]
                else:
                    values[name] = self._in_block(array, index, note)
            except UNREADABLE as error:
                raise StoreError(DAMAGED.format(self.path, name)) from error
        return values

    def index(self, point: Point) -> Place:
        """Place of a point along the leading dimensions."""
        return tuple(index[getattr(point, name)] for name, index in self._places.items())

    def place(self, name: str, index: Place) -> Place:
        """Leading numbers of the chunks with a variable at an index."""
        sizes = self._arrays[name].chunks
        return tuple(i // size for i, size in zip(index, sizes, strict=False))

    def has(self, name: str, point: Point) -> bool:
        """Whether there is a file with a variable at a point, the first along the steps."""
        array, place = self._arrays[name], self.place(name, self.index(point))
        (there,) = self._files.exist([array.key(place + (0,) * (len(array.shape) - len(place)))])
        return there

    def _contents(self, names: Iterable[str], index: Place) -> Callable[[str], bytes | None]:
        """What gives the contents of the files of a point."""
        if not isinstance(self._files, RemoteFiles) or self.is_compact:
            return self._files.content
        keys = [key for name in names for key in keys_at(self._arrays[name], index)]
        return dict(zip(keys, self._files.contents(keys), strict=True)).get

    def _in_block(
        self, array: ChunkedArray, index: Place, lacks: Callable[[str, Place], None]
    ) -> Any:
        """Values at an index, of a chunk that is kept for the next ones that it holds."""
        place = self.place(array.name, index)
        block = self.block(place)
        if (array.name, place) not in self._kept:
            ranges = [range(along.start, along.stop) for along in block]
            picks = [*ranges, *map(range, array.shape[len(index) :])]
            lost: list[tuple[str, Place]] = []
            values = picked(
                array, picks, self._files.contents, lambda _: True, lambda *each: lost.append(each)
            )
            if lost:
                for each in lost:
                    lacks(*each)
                return values[tuple(i - along.start for i, along in zip(index, block, strict=True))]
            self._kept[array.name, place] = values
            while len(self._kept) > _KEPT * len(self._arrays):
                del self._kept[next(iter(self._kept))]
        within = tuple(i - along.start for i, along in zip(index, block, strict=True))
        return self._kept[array.name, place][within]

    def _is_lost(self, name: str, place: Place) -> bool:
        """Whether a chunk that is missing at a point that is done was lost.

        A point has no fields that were asked for after it was done, and no further chunks along
        steps that the store was given later; then none of its variables has.
        """
        siblings = FIELDS if name in FIELDS else COLUMNS
        lead = len(self._places)
        if name not in siblings or (name in COLUMNS and place[lead] == 0):
            return True
        keys = []
        for other in siblings:
            if other in self._arrays:
                rest = len(self._arrays[other].shape) - lead - 1
                keys.append(self._arrays[other].key((*place[: lead + 1], *(0,) * rest)))
        return any(self._files.exist(keys))


def read_whole(
    path: PathLike, read: Callable[[_S], _T], opened: Callable[[PathLike], _S]
) -> tuple[_S, _T]:
    """Read from a store, `opened` as a snapshot; again if it or a point of it is being written.

    Returns
    -------
    Snapshot
        That was current throughout.
    object
        What `read` gave of it.

    Raises
    ------
    StoreError
        If there is no readable store, or it changes all the time.
    """
    for attempt in range(_ATTEMPTS):
        snapshot = opened(path)
        try:
            found = read(snapshot)
        except StoreError:
            if snapshot.is_current():
                if attempt >= _LOOKS:
                    raise
                time.sleep(A_COMMIT)
            continue
        if snapshot.is_current():
            return snapshot, found
    raise StoreError(f"{path} is being rewritten all the time; try again when that has ended")

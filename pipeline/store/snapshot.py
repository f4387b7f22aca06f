"""A snapshot of a store, to read from: what its root describes at one time.

A missing chunk of a point that is done is damage, never a fill value. When the layout of a store
changes, files are removed only after the root that describes them has been replaced. So a reader
asks afterwards whether its snapshot is still current, and takes another if it is not
(`pipeline.store.whole`).
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from pipeline.store.chunks import ChunkedArray, Place, keys_at, picked, values_at
from pipeline.store.files import RemoteFiles, files_in
from pipeline.store.folder import DAMAGED, UNREADABLE, PathLike, StoreError, folder_of
from pipeline.store.places import Places
from pipeline.store.root import hash_of, read_metadata
from pipeline.store.variables import (
    BULK_COLUMNS,
    BULK_FIELDS,
    COLUMNS,
    COMPACT,
    COORDINATES,
    DONE,
    FAILED,
    FIELDS,
    KEPT_COMPACT,
    PENDING,
    is_coordinate,
)
from pipeline.sweep.model import Point
from tribo.types import Array

_KEPT = 3  # chunks of each variable, if they hold many points


class Snapshot(Places):
    """A store as of its last commit.

    Parameters
    ----------
    path : str or path
        Folder or address of the store.

    Attributes
    ----------
    path : Path or Remote
        Absolute folder, or address, of the store.
    attributes : dict
        Attributes of the root group.
    axes : dict of list
        Values along each dimension, in the order of the store.

    Raises
    ------
    StoreError
        If there is no readable store.
    """

    def __init__(self, path: PathLike) -> None:
        self.path = folder_of(path)
        attributes, self.metadata = read_metadata(self.path)
        self._files = files_in(self.path)
        self._arrays = {name: ChunkedArray.of(name, each) for name, each in self.metadata.items()}
        axes: dict[str, list[float]] = attributes.get("axes") or {
            name: self.values(name).tolist() for name in COORDINATES if name in self._arrays
        }
        self._kept: dict[tuple[str, Place], Any] = {}
        super().__init__(attributes, axes)

    @functools.cached_property
    def revision(self) -> str:
        """Identifier of this state of the store; no other has it, nor any earlier store here."""
        return hash_of(self.attributes, self.metadata)

    def is_current(self) -> bool:
        """Whether nothing was committed to the root since; if so, what was read since is whole."""
        return read_metadata(self.path) == (self.attributes, self.metadata)

    @property
    def is_compact(self) -> bool:
        """Whether the chunks hold as many points as is good to read, and none can be written."""
        return self._arrays["status"].separator == COMPACT

    @property
    def is_shared(self) -> bool:
        """Whether the chunks hold several points each."""
        return self._arrays["status"].is_shared(len(self._places))

    @property
    def is_kept_compact(self) -> bool:
        """Whether it is compact, or is to be so again."""
        return self.is_compact or KEPT_COMPACT in self.attributes

    @property
    def names(self) -> list[str]:
        """Variables of the store, without its coordinates."""
        return [name for name in self._arrays if not is_coordinate(name)]

    def array(self, name: str) -> ChunkedArray:
        """How a variable lies in chunks."""
        return self._arrays[name]

    def points_in(self, place: Place) -> list[Point]:
        """Points that share a chunk."""
        return self.points_at([along.ravel() for along in np.mgrid[self.block(place)]])

    def status(self) -> dict[Point, int]:
        """Status of every point that the store has room for; pending if not readable."""
        flags, _ = self.flags()
        return dict(zip(self.places(), flags.ravel().tolist(), strict=True))

    def flag(self, point: Point) -> int:
        """Status of a point; pending if not readable."""
        return next(self.flags_along([point]))

    def flags_along(self, points: Iterable[Point]) -> Iterator[int]:
        """Status of points one by one, as they are asked for; pending if not readable.

        Points that share a chunk and follow each other are read at one time.
        """
        array = self._arrays["status"]
        indices = map(self.index, points)
        for place, alike in itertools.groupby(indices, functools.partial(self.place, "status")):
            self._kept.clear()  # data of a point that is done are read after its status
            part = None
            with suppress(*UNREADABLE):
                content = self._files.content(array.key(place))
                part = None if content is None else array.decoded(content)
            for index in alike:
                flag = PENDING if part is None else int(part[self.within("status", index)])
                yield flag if flag in (DONE, FAILED) else PENDING

    def flags(self) -> tuple[Any, Any]:
        """Status by place, and whether it is known: whether there is one, and it can be read."""
        self._kept.clear()
        array = self._arrays["status"]
        flags = np.full(array.shape, PENDING, array.dtype)
        known = np.zeros(array.shape, bool)
        try:
            places, same = itertools.tee(self.places_of_chunks("status"))
            contents = self._files.contents(map(array.key, same))
            for place, content in zip(places, contents, strict=True):
                with suppress(*UNREADABLE):
                    if content is not None:
                        block = self.block(place)
                        part = array.decoded(content)
                        flags[block] = part[tuple(slice(n) for n in flags[block].shape)]
                        known[block] = True
        except OSError as error:
            raise StoreError(f"{self.path} cannot be read: {error}") from error
        known &= np.isin(flags, (PENDING, DONE, FAILED))
        return np.where(known, flags, PENDING), known

    def places_of_chunks(self, name: str) -> Iterator[Place]:
        """Places of a variable's chunks: of those that there are, where these can be listed.

        Of a search over samples few are there of all that the store has room for.
        """
        array = self._arrays[name]
        counts = array.counts()
        listed = None if array.separator == COMPACT else self._files.listed(name)
        if listed is None:
            yield from np.ndindex(*counts)
            return
        for each in listed:
            first, *numbers = each.split(array.separator)
            if first == "c" and len(numbers) == len(counts) and all(map(str.isdecimal, numbers)):
                place = tuple(map(int, numbers))
                if all(i < n for i, n in zip(place, counts, strict=True)):
                    yield place

    def block(self, place: Place) -> tuple[slice, ...]:
        """Points that share a chunk."""
        array = self._arrays["status"]
        return tuple(
            slice(i * size, min((i + 1) * size, end))
            for i, size, end in zip(place, array.chunks, array.shape, strict=True)
        )

    def is_done(self, point: Point) -> bool:
        """Whether a point is complete."""
        return self.flag(point) == DONE

    def message(self, point: Point) -> str:
        """Why a point failed, or what to know before relying on it."""
        return str(self.at(point, ["message"])["message"])

    def finished_at(self) -> Array:
        """Times at which points were finished [s], in no order, as far as they are known."""
        if "finished_at" not in self._arrays:
            return np.empty(0)
        times: Array = self.values("finished_at")
        return times[np.isfinite(times)]

    def values(self, name: str) -> Any:
        """Values of a whole variable; fill values where nothing was written."""
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
            Name of the variable.
        picks : sequence of array_like of int
            Indices of the entries along each dimension.
        needed : ndarray of bool, optional
            Whether each point must be there, by place; the others are not read. If not given, all
            that are there are read.

        Raises
        ------
        StoreError
            If something cannot be read, or a needed point is missing.
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

    def at(
        self, point: Point, names: Iterable[str], missing: set[tuple[str, Place]] | None = None
    ) -> Any:
        """Values of variables at a point; chunks that may have been lost are added to `missing`.

        Raises
        ------
        StoreError
            If something cannot be read.
        """
        index, values = self.index(point), {}
        content = self._contents(names, index)

        def lacks(name: str) -> Callable[[str, Place], None]:
            def note(_: str, place: Place) -> None:
                if missing is not None and self._may_be_lost(name, place):
                    missing.add((name, place))

            return note

        for name in names:
            array, note = self._arrays[name], lacks(name)
            try:
                if array.is_shared(len(index)):
                    values[name] = self._in_block(array, index, note)
                else:
                    values[name] = values_at(array, index, content, note)[()]
            except UNREADABLE as error:
                raise StoreError(DAMAGED.format(self.path, name)) from error
        return values

    def place(self, name: str, index: Place) -> Place:
        """Leading numbers of the chunks with a variable at an index."""
        sizes = self._arrays[name].chunks
        return tuple(i // size for i, size in zip(index, sizes, strict=False))

    def within(self, name: str, index: Place) -> Place:
        """Place of an index in its chunk."""
        sizes = self._arrays[name].chunks
        return tuple(i % size for i, size in zip(index, sizes, strict=False))

    def has(self, name: str, point: Point) -> bool:
        """Whether there is a file with a variable at a point, the first along the steps."""
        array, place = self._arrays[name], self.place(name, self.index(point))
        (there,) = self._files.exist([array.key(place + (0,) * (len(array.shape) - len(place)))])
        return there

    def _contents(self, names: Iterable[str], index: Place) -> Callable[[str], bytes | None]:
        """A function that gives the contents of the files of a point."""
        if not isinstance(self._files, RemoteFiles):
            return self._files.content
        arrays = [self._arrays[name] for name in names]
        own = (array for array in arrays if not array.is_shared(len(index)))
        keys = [key for array in own for key in keys_at(array, index)]
        return dict(zip(keys, self._files.contents(keys), strict=True)).get

    def _in_block(
        self, array: ChunkedArray, index: Place, lacks: Callable[[str, Place], None]
    ) -> Any:
        """Values at an index, from a chunk that is kept, since it holds the next ones too."""
        place, within = self.place(array.name, index), self.within(array.name, index)
        values = self._kept.get((array.name, place))
        if values is None:
            ranges = [range(along.start, along.stop) for along in self.block(place)]
            picks = [*ranges, *map(range, array.shape[len(index) :])]
            lost: list[tuple[str, Place]] = []
            values = picked(
                array, picks, self._files.contents, lambda _: True, lambda *each: lost.append(each)
            )
            for each in lost:
                lacks(*each)
            if not lost:
                self._kept[array.name, place] = values
            while len(self._kept) > _KEPT * len(self._arrays):
                self._kept.pop(next(iter(self._kept)), None)
        return values[within]

    def _is_lost(self, name: str, place: Place) -> bool:
        """Whether a missing chunk of points of which some are done was lost."""
        return self._may_be_lost(name, place)

    def _may_be_lost(self, name: str, place: Place) -> bool:
        """Whether a point that is done may need a missing chunk.

        None does where fields were asked for only after the point was done, or where the store was
        given more steps later; then none of the point's variables has these chunks.
        """
        fields, columns = FIELDS | BULK_FIELDS, COLUMNS | BULK_COLUMNS
        siblings = fields if name in fields else columns
        lead = len(self._places)
        if name not in siblings or not (name in fields or self.is_later(name, place)):
            return True
        keys = []
        for other in siblings:
            if other in self._arrays:
                rest = len(self._arrays[other].shape) - lead - 1
                keys.append(self._arrays[other].key((*place[: lead + 1], *(0,) * rest)))
        return any(self._files.exist(keys))

    def is_later(self, name: str, place: Place) -> bool:
        """Whether a chunk holds steps that a store may have been given later."""
        return name in COLUMNS | BULK_COLUMNS and place[len(self._places)] > 0

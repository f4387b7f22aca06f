"""Read all of a store, and say what of it is damaged.

A point that is done is damaged if one of its files cannot be read or is missing, or if its data
are not those that its checksum was taken of. To repair it is to make it pending, so that the next
run computes it again; coordinates and metadata are restored from the root of the store.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store.folder import (
    ROOT,
    PathLike,
    Place,
    StoreError,
    folder_of,
    locked,
    read_json,
    write_json,
)
from pipeline.store.identity import scene_hash
from pipeline.store.points import Store
from pipeline.store.root import (
    DamagedRootError,
    has_copy,
    read_metadata,
    renew_copy,
    restore_root,
)
from pipeline.store.soundness import sound
from pipeline.store.variables import DONE, FAILED, HASHED
from pipeline.store.whole import A_COMMIT, read_whole
from pipeline.sweep.model import Point
from tribo.types import Mask


@dataclass(frozen=True, slots=True)
class Damage:
    """A damaged point: load [N], velocity [m/s], what is wrong with it, and which variant."""

    load: float
    velocity: float
    reason: str
    realization: int | None = None
    sample: int | None = None

    @property
    def point(self) -> Point:
        """Where it is."""
        return Point(self.load, self.velocity, self.realization, self.sample)

    def __str__(self) -> str:
        return f"{self.point}: {self.reason}"


@dataclass(frozen=True, slots=True)
class Verification:
    """What reading a whole store found.

    Attributes
    ----------
    done : int
        Points that are done and intact.
    damaged : tuple of Damage
        Points with damaged files.
    shared : tuple of str
        What is wrong with coordinates and metadata, which belong to no point.
    found : tuple of Point
        Points that are complete, but without a status: it was lost, or a run was killed before it
        wrote it. The next run takes them as done.
    is_protected : bool
        Whether conditions, axes and metadata are protected by a hash, which stores of format 1
        lack.
    repaired : bool
        Whether all of that was repaired.
    """

    done: int
    damaged: tuple[Damage, ...]
    shared: tuple[str, ...]
    found: tuple[Point, ...]
    repaired: bool
    is_protected: bool = True

    @property
    def is_clean(self) -> bool:
        """Whether nothing was damaged."""
        return not (self.damaged or self.shared)


def verify_store(
    path: PathLike, repair: bool = False, progress: Callable[[int, int], None] | None = None
) -> Verification:
    """Read everything in a store and name what is damaged.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use unless it is to be repaired.
    repair : bool
        Whether to make damaged points pending, and to restore what is shared.
    progress : callable, optional
        Called now and then with how many points are read, and how many there are.

    Raises
    ------
    StoreError
        If there is no readable store, or it is to be repaired while in use.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.verify_store("results/first_try.zarr")
    >>> found.done, found.is_clean
    (24, True)
    """
    folder = folder_of(path)
    with ExitStack() as stack:
        if repair:
            with suppress(DamagedRootError):
                read_metadata(folder)  # before a lock is laid beside what is no store
            stack.enter_context(locked(path))
        shared = list(_root_faults(folder, repair))
        if shared and not repair:
            return Verification(0, (), tuple(shared), (), repaired=False)
        try:
            if repair:
                return _examined(Store(path), shared, repair, progress)

            def examined(store: Store) -> Verification:
                return _examined(store, shared, repair, progress)

            return read_whole(path, examined, Store)[1]
        except OSError as error:
            raise StoreError(f"{folder} cannot be repaired: {error}") from error


def _examined(
    store: Store,
    shared: list[str],
    repair: bool,
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """Examine a store whose root has these faults."""
    shared = [*shared, *_shared_faults(store, repair)]
    found = tuple(store.lost())
    if repair:
        store.heal()
    flags, _ = store.flags()
    damaged = _damaged(store, flags, np.ones(flags.shape, bool), progress)
    if damaged and not repair:  # a run may just be writing these anew
        time.sleep(A_COMMIT)
        damaged = _damaged(store, store.flags()[0], _places(store, damaged))
    if repair:
        _reset(store, [each.point for each in damaged])
    done = (flags == DONE) & ~_places(store, damaged)
    is_protected = store.attributes["format"] >= HASHED
    return Verification(
        int(np.count_nonzero(done)), tuple(damaged), tuple(shared), found, repair, is_protected
    )


def _places(store: Store, damaged: Iterable[Damage]) -> Mask:
    """Whether each place is one of some damaged points."""
    found = np.zeros(store.array("status").shape, bool)
    for each in damaged:
        found[store.index(each.point)] = True
    return found


def _damaged(
    store: Store,
    flags: NDArray[np.int8],
    places: Mask,
    progress: Callable[[int, int], None] | None = None,
) -> list[Damage]:
    """What is wrong with any of the points at some places, by their status."""
    total, read = int(np.count_nonzero(places)), 0

    def count(number: int) -> None:
        nonlocal read
        read += number
        if progress:
            progress(read, total)

    doubtful = (places & ~sound(store, flags, places, count)) | (places & (flags == FAILED))
    damaged = []
    for point in store.points_at(np.nonzero(doubtful)):
        reason = _reason(store, point, int(flags[store.index(point)]))
        if reason is not None:
            damaged.append(Damage(point.load, point.velocity, reason, *point[2:]))
    return damaged


_CHANGING = ("shape", "chunk_grid", "chunk_key_encoding")
_REWRITTEN = {"status", "message"}  # when a point is made pending


def _reason(store: Store, point: Point, status: int) -> str | None:
    """What is wrong with a point, if anything is."""
    if status == DONE:
        return store.fault(point)
    if unreadable := store.unreadable(point):
        return f"{', '.join(unreadable)} cannot be read"
    if status == FAILED and not store.has("message", point):
        return "message is missing"
    return None


def _reset(store: Store, points: list[Point]) -> None:
    """Make damaged points pending."""
    broken = {point: set(store.unreadable(point)) for point in points}
    for point, names in broken.items():
        store.discard(point, _REWRITTEN & names)
    store.forget(*points)
    for point, names in broken.items():
        store.discard(point, names - _REWRITTEN)


def _root_faults(folder: Place, repair: bool) -> Iterator[str]:
    """What is wrong with the root of a store, which is restored from its copy if so desired."""
    try:
        read_metadata(folder)
    except DamagedRootError as error:
        yield str(error).removeprefix(f"{folder} ").removeprefix(f"{folder}: ")
        if repair:
            restore_root(folder)


def _shared_faults(store: Store, repair: bool) -> Iterator[str]:
    """What is wrong with metadata and coordinates; they are restored if so desired."""
    if scene_hash(store.attributes["scene"]) != store.attributes["scene_hash"]:
        yield "the description of the scene is damaged, and cannot be repaired"
    if store.attributes["format"] >= HASHED and not has_copy(store.path):
        yield f"the copy of {ROOT} is damaged"
        if repair:
            renew_copy(store.path)
    for name, expected in store.metadata.items():
        if not _is_same(store.path / name / ROOT, expected):
            yield f"the metadata of {name} are damaged"
            if repair:
                write_json(store.path / name / ROOT, expected)
    for name in store.damaged_coordinates():
        yield f"the coordinate {name} is damaged"
        if repair:
            store.restore(name)


def _is_same(file: Place, expected: dict[str, Any]) -> bool:
    """Whether metadata are as they were committed, but for a change that was cut short."""
    try:
        return read_json(file) | {name: expected[name] for name in _CHANGING} == expected
    except (OSError, ValueError, RecursionError):
        return False

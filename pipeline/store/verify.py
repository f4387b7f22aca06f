"""Read all of a store, and say what of it is damaged.

A point that is done is damaged if one of its files cannot be read or is missing, or if its data
are not those that its checksum was taken of. To repair it is to make it pending, so that the next
run computes it again; coordinates and metadata are restored from the root of the store.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from pipeline.store.folder import (
    ROOT,
    PathLike,
    Place,
    folder_of,
    locked,
    read_json,
    read_metadata,
    write_json,
)
from pipeline.store.identity import scene_hash
from pipeline.store.points import Store
from pipeline.sweep.model import Point

__all__ = ["Damage", "Verification", "verify_store"]


@dataclass(frozen=True, slots=True)
class Damage:
    """A damaged point: load [N], velocity [m/s], what is wrong with it, and on which surface."""

    load: float
    velocity: float
    reason: str
    realization: int | None = None

    @property
    def point(self) -> Point:
        """Where it is."""
        return Point(self.load, self.velocity, self.realization)

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
    repaired : bool
        Whether all of that was repaired.
    """

    done: int
    damaged: tuple[Damage, ...]
    shared: tuple[str, ...]
    repaired: bool

    @property
    def is_clean(self) -> bool:
        """Whether nothing was damaged."""
        return not (self.damaged or self.shared)


def verify_store(path: PathLike, repair: bool = False) -> Verification:
    """Read everything in a store and name what is damaged.

    Parameters
    ----------
    path : str or path
        Of the store, which may be in use unless it is repaired.
    repair : bool
        Whether to make damaged points pending, and to restore what is shared.

    Raises
    ------
    StoreError
        If there is no readable store, or it is in use and to be repaired.
    """
    with ExitStack() as stack:
        if repair:
            read_metadata(folder_of(path))  # before a lock is laid beside what is no store
            stack.enter_context(locked(path))
        shared = tuple(_shared(path, repair))
        store = Store(path, mode="r+" if repair else "r")
        done, damaged = 0, []
        broken: dict[Point, list[str]] = {}
        for point in store.places():
            unreadable = store.unreadable(point)
            is_done = "status" not in unreadable and store.is_done(point)
            reason = _reason(store, point, is_done, unreadable)
            if reason is None:
                done += is_done
                continue
            damaged.append(Damage(point.load, point.velocity, reason, point.realization))
            broken[point] = unreadable
        if repair:
            for point, names in broken.items():
                store.discard(point, _REWRITTEN & set(names))
                store.forget(point)
            for point, names in broken.items():
                store.discard(point, set(names) - _REWRITTEN)
    return Verification(done, tuple(damaged), shared, repaired=repair)


_CHANGING = ("shape", "chunk_grid", "chunk_key_encoding")
_REWRITTEN = {"status", "message"}  # when a point is made pending


def _reason(store: Store, point: Point, is_done: bool, unreadable: list[str]) -> str | None:
    """What is wrong with a point, if anything is."""
    if unreadable:
        return f"{', '.join(unreadable)} cannot be read"
    if is_done:
        if missing := store.missing(point):
            return f"{', '.join(missing)} is missing"
        if not store.is_intact(point):
            return "the data are not those that were computed"
    return None


def _shared(path: PathLike, repair: bool) -> Iterator[str]:
    """What is wrong with metadata and coordinates; they are restored if so desired."""
    folder = folder_of(path)
    attributes, arrays = read_metadata(folder)
    if scene_hash(attributes["scene"]) != attributes["scene_hash"]:
        yield "the description of the scene is damaged, and cannot be repaired"
    for name, expected in arrays.items():
        if not _is_same(folder / name / ROOT, expected):
            yield f"the metadata of {name} are damaged"
            if repair:
                write_json(folder / name / ROOT, expected)
    store = Store(path, mode="r+" if repair else "r")
    for name in store.damaged_coordinates():
        yield f"the coordinate {name} is damaged"
        if repair:
            store.restore(name)


def _is_same(file: Place, expected: dict[str, Any]) -> bool:
    """Whether metadata are as they were committed, but for a change that was cut short."""
    try:
        return read_json(file) | {name: expected[name] for name in _CHANGING} == expected
    except (OSError, ValueError):
        return False

"""Soundness of single points of a store that is read: their data against their checksums.

Chunks are read and decoded here, and not by Zarr, and fields are compared as they are encoded:
beside the 12 points about the boundary of first_try that takes 3 ms of CPU time in place of 15.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np

from pipeline.store.files import THREADS
from pipeline.store.layout import field_key
from pipeline.store.packing import unpacked
from pipeline.store.place import Folder, StoreError
from pipeline.store.root import read_root
from pipeline.store.schema import AT_END, STEPPED
from pipeline.store.verify import fault_of_data, read_or_none
from pipeline.store.write import Store
from pipeline.sweep.model import Point

_Index = tuple[int, ...]
_KEPT = "status/kept-"  # of files beside the lock, which are no data
_BESIDE = ("checksum", "steps", "warning_flags")
_CLOSE = 1e-9  # relative distance of a coordinate that was scaled, and scaled back


class Reader:
    """The store that a dataset is read from, and the points of it that were found sound."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._sound: set[_Index] = set()
        self.dims = store.dims

    def __deepcopy__(self, _: Any) -> Reader:
        return self

    def positions(self, name: str) -> range:
        """All places along a dimension of the store."""
        return range(len(self._store.axes[name]))

    def kept(self, name: str) -> bytes | None:
        """What a command has kept in the store under a name; None if nothing."""
        with suppress(OSError):
            return self._store.place.read(_KEPT + name)
        return None

    def keep(self, name: str, content: bytes) -> None:
        """Keep what a command found of the store, unless it cannot be written."""
        with suppress(OSError):
            self._store.place.create(_KEPT + name, content)

    def position(self, name: str, value: Any) -> int | None:
        """Place of a value along a dimension of the store; None if it has none."""
        axis = self._store.axes[name]
        if value in axis or isinstance(value, str):
            return axis.index(value) if value in axis else None
        distances = np.abs(np.asarray(axis) - value)
        nearest = int(np.argmin(distances))
        return nearest if distances[nearest] <= _CLOSE * abs(value) else None

    def require_sound(self, indices: Collection[_Index]) -> None:
        """Raise a `StoreError` for the first of some done points that is damaged."""
        by_chunk: dict[_Index, list[_Index]] = {}
        for index in sorted(set(indices) - self._sound):
            chunk = tuple(i // n for i, n in zip(index, self._store.block, strict=True))
            by_chunk.setdefault(chunk, []).append(index)
        for chunk, members in by_chunk.items():
            for point, fault in self._faults(chunk, members):
                if fault and self._is_in_place():
                    place = self._store.place
                    raise StoreError(
                        f"{place} is damaged at {self._store.in_words(point)}: {fault}; irg verify "
                        f"{place} --repair makes such points pending, and irg run computes them"
                    )
            self._sound.update(members)

    def _is_in_place(self) -> bool:
        """False if it was deleted or replaced since, which leaves a dataset in memory whole."""
        try:
            root = read_root(self._store.place)
        except StoreError:
            return False
        return (root.attributes, root.axes) == (self._store.attributes, self._store.axes)

    def _faults(self, chunk: _Index, members: list[_Index]) -> Iterator[tuple[Point, str]]:
        """Points of a chunk, each with its fault or nothing."""
        store, within = self._store, [self._within(index) for index in members]
        shared = [name for name in store.arrays if name in STEPPED or name in _BESIDE]
        fields = [name for name in store.arrays if name in AT_END]
        keys = {name: [*store.chunk_keys(name, chunk)] for name in shared}
        alone = [field_key(name, index) for index in members for name in fields]
        wanted = [*itertools.chain(*keys.values()), *alone]
        found = dict(zip(wanted, self._read(wanted), strict=True))
        parts = {name: self._unpacked(name, [found[key] for key in keys[name]]) for name in shared}
        points = store.points_at([*np.transpose(members)])
        for index, place, point in zip(members, within, points, strict=True):
            entries = {name: None if part is None else part[place] for name, part in parts.items()}
            entries |= {name: found[field_key(name, index)] for name in fields}
            yield point, fault_of_data(store.simulated.at(point), point, entries)

    def _within(self, index: _Index) -> _Index:
        return tuple(i % n for i, n in zip(index, self._store.block, strict=True))

    def _read(self, keys: list[str]) -> list[bytes | None]:
        """Contents of keys; None where lost. Those of an object store come side by side."""
        place = self._store.place
        if isinstance(place, Folder):
            return [read_or_none(place, key) for key in keys]
        with ThreadPoolExecutor(THREADS) as threads:
            return list(threads.map(lambda key: read_or_none(place, key), keys))

    def _unpacked(self, name: str, contents: list[bytes | None]) -> Any:
        """The part of a variable that lies in some chunks; None where lost or damaged."""
        shape = self._store.arrays[name].chunks
        try:
            parts = [unpacked(content or b"", name, shape) for content in contents]
        except (RuntimeError, ValueError):
            return None
        return np.concatenate(parts, len(self._store.block)) if len(parts) > 1 else parts[0]

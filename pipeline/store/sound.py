"""Soundness of single points of a store that is read: their data against their checksums.

Chunks are read and decoded here, side by side, and not by Zarr: beside the 12 points about the
boundary of first_try that takes 8 ms of CPU time in place of 15.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np

from pipeline.store.files import THREADS
from pipeline.store.packing import unpacked
from pipeline.store.place import StoreError
from pipeline.store.root import read_root
from pipeline.store.schema import AT_END, STEPPED
from pipeline.store.verify import fault_of_data
from pipeline.store.write import Store
from pipeline.sweep.model import Point

_Index = tuple[int, ...]
_KEPT = "status/kept-"  # of files beside the lock, which are no data
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
        arrays = self._store.arrays
        beside = ("checksum", "steps", "warning_flags")
        shared = [(name, chunk) for name in arrays if name in STEPPED or name in beside]
        fields = [name for name in arrays if name in AT_END]
        wanted = shared + [(name, index) for index in members for name in fields]
        parts = dict(zip(wanted, self._read(wanted), strict=True))
        points = self._store.points_at([*np.transpose(members)])
        for index, point in zip(members, points, strict=True):
            within = tuple(i % n for i, n in zip(index, self._store.block, strict=True))
            entries = {
                name: None if (part := parts[name, numbers]) is None else part[within]
                for name, numbers in shared
            }
            alone = (0,) * len(index)
            entries |= {
                name: None if (part := parts[name, index]) is None else part[alone]
                for name in fields
            }
            yield point, fault_of_data(self._store.simulated.at(point), point, entries)

    def _read(self, wanted: list[tuple[str, _Index]]) -> Iterator[Any]:
        """Parts of variables by their numbers along the points; None where lost or damaged."""
        place, arrays = self._store.place, self._store.arrays
        chunks = {name: arrays[name].chunks for name in {name for name, _ in wanted}}

        def read(name: str, numbers: _Index) -> Any:
            try:
                parts = [
                    unpacked(place.read(key) or b"", name, chunks[name])
                    for key in self._store.chunk_keys(name, numbers)
                ]
                return np.concatenate(parts, len(numbers)) if len(parts) > 1 else parts[0]
            except (OSError, RuntimeError, ValueError):
                return None

        with ThreadPoolExecutor(THREADS) as threads:
            yield from threads.map(read, *zip(*wanted, strict=True))

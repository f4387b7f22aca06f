"""Soundness of single points of a store that is read: their data against their checksums."""

from __future__ import annotations

import asyncio
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
from zarr.core.sync import sync

from pipeline.store.layout import Slices, chunk_key, slices_of
from pipeline.store.packing import unpacked
from pipeline.store.place import StoreError
from pipeline.store.schema import AT_END, STEPPED
from pipeline.store.verify import fault_of_data
from pipeline.store.write import Store
from pipeline.sweep.model import Point

_Index = tuple[int, ...]
_CLOSE = 1e-9  # relative distance of a coordinate that was scaled, and scaled back


class Reader:
    """The store that a dataset is read from, and the points of it that were found sound."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._sound: set[_Index] = set()
        self.dims = store.dims

    def __deepcopy__(self, _: Any) -> Reader:
        return self

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
                if fault:
                    place = self._store.place
                    raise StoreError(
                        f"{place} is damaged at {self._store.in_words(point)}: {fault}; irg verify "
                        f"{place} --repair makes such points pending, and irg run computes them"
                    )
            self._sound.update(members)

    def _faults(self, chunk: _Index, members: list[_Index]) -> Iterator[tuple[Point, str]]:
        """Points of a chunk, each with its fault or nothing."""
        store = self._store
        names = [name for name in store.arrays if name in STEPPED or name == "checksum"]
        fields = [name for name in store.arrays if name in AT_END]
        of_block = dict(zip(names, self._read(names, slices_of(chunk, store.block)), strict=True))
        points = store.points_at([*np.transpose(members)])
        for index, point in zip(members, points, strict=True):
            within = tuple(i % n for i, n in zip(index, store.block, strict=True))
            entries = {
                name: None if entry is None else entry[within] for name, entry in of_block.items()
            }
            entries |= {name: self._field(name, index) for name in fields}
            yield point, fault_of_data(point, entries)

    def _read(self, names: list[str], block: Slices) -> list[Any]:
        """Parts of variables, side by side, which takes half the time; None where damaged."""

        async def parts() -> list[Any]:
            reads = (self._store.arrays[name].async_array.getitem(block) for name in names)
            return await asyncio.gather(*reads, return_exceptions=True)

        return [None if isinstance(part, BaseException) else part for part in sync(parts())]

    def _field(self, name: str, index: _Index) -> Any:
        """Field of a point; None where it is lost or damaged."""
        try:
            encoded = self._store.place.read(chunk_key(name, (*index, 0, 0)))
            shape = self._store.arrays[name].chunks[len(index) :]
            return None if encoded is None else unpacked(encoded, name, shape)
        except (OSError, RuntimeError, ValueError):
            return None

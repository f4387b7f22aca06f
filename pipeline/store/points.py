"""Places of the points of a store along its dimensions."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.store.place import Place
from pipeline.store.root import Root
from pipeline.store.schema import DONE, chunk_name, chunks_of, is_coordinate
from pipeline.sweep.model import Point, Sweep
from tribo.types import Indices, Mask

Slices = tuple[slice, ...]


class Places:
    """Places of points.

    Parameters
    ----------
    root : Root

    Attributes
    ----------
    attributes, metadata, axes : dict
        Attributes of the store, metadata of its arrays, values along its dimensions.
    """

    def __init__(self, root: Root) -> None:
        self.attributes, self.metadata = root
        self.axes = root.axes
        self.dims = self.dims_of("status")
        self._numbers = [
            {value: number for number, value in enumerate(self.axes[name])} for name in self.dims
        ]

    @property
    def ndim(self) -> int:
        """Number of dimensions that tell points apart."""
        return len(self.dims)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each of them."""
        return tuple(map(len, self._numbers))

    @property
    def leading(self) -> tuple[str, ...]:
        """Dimensions in front of load and velocity."""
        return self.dims[: self.dims.index("load")]

    def dims_of(self, name: str) -> tuple[str, ...]:
        """Names of the dimensions of a variable."""
        return tuple(self.metadata[name]["dimension_names"])

    def index(self, point: Point) -> tuple[int, ...]:
        """Place of a point."""
        values = dict(point.variant) | {"load": point.load, "velocity": point.velocity}
        return tuple(
            numbers[values[name]] for name, numbers in zip(self.dims, self._numbers, strict=True)
        )

    def points_at(self, where: Sequence[Indices]) -> list[Point]:
        """Points at places that are given by their indices along each dimension."""
        axes = {
            name: np.array(self.axes[name], dtype=object)[along].tolist()
            for name, along in zip(self.dims, where, strict=True)
        }
        if "sample" in self.leading:  # each of which has one velocity
            velocities = np.array(self.axes["velocity"], dtype=object)
            axes["velocity"] = velocities[where[0]].tolist()
        columns = [axes[name] for name in self.leading]
        values = zip(*columns, strict=True) if columns else itertools.repeat(())
        variants = (tuple(zip(self.leading, row, strict=True)) for row in values)
        return list(map(Point, axes["load"], axes["velocity"], variants))

    def mask_of(self, points: Iterable[Point]) -> Mask:
        """Mask of points."""
        mask = np.zeros(self.shape, bool)
        for point in points:
            mask[self.index(point)] = True
        return mask

    def asked_by(self, sweep: Sweep) -> Mask:
        """Mask of the points that a sweep asks for."""
        if sweep.chosen is not None:
            return self.mask_of(sweep.chosen)
        wanted: dict[str, Iterable[Any]] = {
            "load": sweep.loads, "velocity": sweep.velocities, **sweep.axes
        }  # fmt: skip
        mask = np.zeros(self.shape, bool)
        rows = [
            [numbers[value] for value in wanted[name]]
            for name, numbers in zip(self.dims, self._numbers, strict=True)
        ]
        mask[np.ix_(*rows)] = True
        return mask

    def block(self, chunk: Sequence[int], sizes: Sequence[int]) -> Slices:
        """Points of a chunk, by the sizes of the chunks of its variable."""
        return tuple(
            slice(i * size, min((i + 1) * size, n))
            for i, size, n in zip(chunk, sizes, self.shape, strict=False)
        )


def missing_chunks(place: Place, root: Root, flags: NDArray[np.int8]) -> dict[str, Mask]:
    """Points that are done, but lack a chunk: a mask by the names of variables that lack any."""
    done = flags == DONE
    missing: dict[str, Mask] = {}
    needed: dict[tuple[int, ...], list[tuple[int, ...]]] = {}  # by the sizes, alike for most
    listed = place.all_names(name for name in root.arrays if not is_coordinate(name))
    for name, names in listed.items():
        array = root.arrays[name]
        sizes = chunks_of(array)
        tail = [-(-n // size) for n, size in zip(array["shape"], sizes, strict=True)][done.ndim :]
        block = tuple(sizes[: done.ndim])
        if block not in needed:
            needed[block] = _chunks_with(done, block)
        for chunk in needed[block]:
            keys = (chunk_name((*chunk, *rest)) for rest in np.ndindex(*tail))
            if not names.issuperset(keys):
                points = tuple(slice(i * n, (i + 1) * n) for i, n in zip(chunk, block, strict=True))
                mask = missing.setdefault(name, np.zeros_like(done))
                mask[points] = done[points]
    return missing


def _chunks_with(mask: Mask, sizes: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Numbers of the chunks with any of the points of a mask."""
    counts = [-(-n // size) for n, size in zip(mask.shape, sizes, strict=True)]
    numbers = np.argwhere(mask) // np.array(sizes)
    chunks = np.unique(np.ravel_multi_index(tuple(numbers.T), counts))
    return [tuple(row) for row in np.array(np.unravel_index(chunks, counts)).T.tolist()]

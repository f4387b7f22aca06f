"""Points chosen among those of a sweep, as a bit for each place.

A search over ten thousand samples chooses a hundred thousand points, which take 20 MB as such, and
more as the lists that JSON makes of them.
"""

from __future__ import annotations

import base64
import zlib
from array import array
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.sweep.model import Point
from tribo.types import Mask

Variant = tuple[int | None, int | None]
"""Surface and sample of a point."""


@dataclass(frozen=True, slots=True)
class Chosen(Collection[Point]):
    """Some of the points at given loads and velocities, of given surfaces or samples.

    Attributes
    ----------
    variants : tuple of tuple
        Surface and sample of the points, None where there are none.
    loads : tuple of float
        Normal loads [N].
    velocities : tuple of float
        Sliding velocities [m/s].
    bits : bytes
        Whether each is chosen, by variant, load and velocity, eight to a byte.

    Examples
    --------
    >>> chosen = Chosen.of([Point(600.0, 1.5), Point(200.0, 1.0)])
    >>> print(*chosen, sep="; ")
    200 N, 1 m/s; 600 N, 1.5 m/s
    >>> chosen.over([(None, None)], [200.0, 600.0], [1.5]).tolist()
    [[[False], [True]]]
    """

    variants: tuple[Variant, ...]
    loads: tuple[float, ...]
    velocities: tuple[float, ...]
    bits: bytes

    @classmethod
    def of(cls, points: Iterable[Point]) -> Chosen:
        """Points as such; their order does not matter."""
        if isinstance(points, cls):
            return points
        numbers = array("q")
        known: tuple[dict[Any, int], ...] = ({}, {}, {})
        for load, velocity, *variant in points:
            for each, axis in zip((tuple(variant), load, velocity), known, strict=True):
                numbers.append(axis.setdefault(each, len(axis)))
        variants = sorted(known[0], key=lambda variant: tuple(each or 0 for each in variant))
        axes: tuple[list[Any], ...] = (variants, sorted(known[1]), sorted(known[2]))
        mask = np.zeros([len(values) for values in axes], bool)
        index = np.array(numbers, int).reshape(-1, 3).T
        for along, values, own in zip(index, axes, known, strict=True):
            order = np.empty(len(values), int)
            order[[own[each] for each in values]] = np.arange(len(values))
            along[:] = order[along]
        mask[tuple(index)] = True
        return cls(tuple(variants), tuple(axes[1]), tuple(axes[2]), np.packbits(mask).tobytes())

    @classmethod
    def from_text(
        cls,
        text: str,
        variants: Iterable[Variant],
        loads: Iterable[float],
        velocities: Iterable[float],
    ) -> Chosen:
        """Points of a text that `packed` gave, along the same axes."""
        bits = zlib.decompress(base64.b64decode(text))
        return cls(tuple(variants), tuple(loads), tuple(velocities), bits)

    def packed(
        self, variants: Iterable[Variant], loads: Iterable[float], velocities: Iterable[float]
    ) -> str:
        """Text that says which are chosen along other axes."""
        bits = np.packbits(self.over(variants, loads, velocities)).tobytes()
        return base64.b64encode(zlib.compress(bits)).decode()

    @property
    def mask(self) -> Mask:
        """Whether each is chosen, by variant, load and velocity."""
        shape = len(self.variants), len(self.loads), len(self.velocities)
        count = shape[0] * shape[1] * shape[2]
        found = np.unpackbits(np.frombuffer(self.bits, np.uint8), count=count)
        return found.astype(bool).reshape(shape)

    def over(
        self,
        variants: Iterable[Variant],
        loads: Iterable[float],
        velocities: Iterable[float],
    ) -> Mask:
        """Whether each place along other axes is chosen, shape (n_variant, n_load, n_velocity)."""
        own = self.variants, self.loads, self.velocities
        rows = []
        for wanted, axis in zip((variants, loads, velocities), own, strict=True):
            index = {value: number for number, value in enumerate(axis)}
            rows.append(np.array([index.get(value, -1) for value in wanted], int))
        wider = np.pad(self.mask, [(0, 1)] * 3)  # what is not among its own is at -1
        found: Mask = wider[np.ix_(*rows)]
        return found

    def __len__(self) -> int:
        return int(np.count_nonzero(self.mask))

    def __iter__(self) -> Iterator[Point]:
        places = np.argwhere(self.mask.swapaxes(1, 2))
        for variant, velocity, load in places:  # a row at a time, since lists take more memory
            yield Point(self.loads[load], self.velocities[velocity], *self.variants[variant])

    def __contains__(self, point: object) -> bool:
        if not isinstance(point, Point):
            return False
        return bool(self.over([point[2:]], [point.load], [point.velocity]).any())

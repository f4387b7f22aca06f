"""Caches of maps, surfaces, kernels and contacts that several points of a diagram use.

Points of a diagram share nothing but these values and the ramps of `tribo.simulation.ramp_cache`. A
cached value does not change, so that threads may use it at the same time. A thread waits while
another thread computes a value of the same cache.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from tribo.contact import ElasticHalfSpace
from tribo.material import Material, contact_modulus
from tribo.numerics import Grid, forget_buffers
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.thermal import ConductingHalfSpace
from tribo.types import Array

_MAX_BODIES = 8  # a scene needs up to three of them, one for each of its grids
_MAX_BYTES = 2**28  # each for thermal maps and for contacts

Value = TypeVar("Value")


class Cache(Generic[Value]):
    """A cache of values by key, up to a total size.

    `size_of` returns the size of a value, in the unit of `limit`. The least recently used values
    are dropped first. The newest value stays, whatever its size.

    Examples
    --------
    >>> words = Cache(size_of=len, limit=6)
    >>> [words.get(n, lambda: "o" * n) for n in (3, 2, 3, 3)]
    ['ooo', 'oo', 'ooo', 'ooo']
    >>> words.get(4, lambda: "four"), words.get(2, lambda: "computed again")
    ('four', 'computed again')
    """

    def __init__(self, size_of: Callable[[Value], int], limit: int) -> None:
        self._size_of, self._limit, self._size = size_of, limit, 0
        self._values: OrderedDict[Hashable, Value] = OrderedDict()
        # Reentrant, since a contact may need a contact on smaller elements.
        self._lock = threading.RLock()

    def get(self, key: Hashable, compute: Callable[[], Value]) -> Value:
        """Return the value of a key; compute it if it is not cached."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
            value = self._values[key] = compute()
            self._size += self._size_of(value)
            while self._size > self._limit and len(self._values) > 1:
                self._size -= self._size_of(self._values.popitem(last=False)[1])
            return value

    def clear(self) -> None:
        """Drop all values."""
        with self._lock:
            self._values.clear()
            self._size = 0


class ElasticBodies(NamedTuple):
    """Elastic response and undeformed separation of the pin and the disk.

    `solid` maps pressure to elastic displacement. `heights` are the disk's heights on the elements,
    above their mean; None if neither shifts of the disk nor imprints are computed. An imprint is
    the negative of the roughness that the disk wears into the pin. Its depth is estimated from
    `heights` and `elastic_sum`, the sum of z·u over all elements. Here z is an element's height,
    and u its displacement under a pressure of z times 1 Pa/m on each element.
    """

    solid: ElasticHalfSpace
    separation: Array  # between the unworn, undeformed surfaces [m]
    heights: Array | None = None  # of the disk above their mean [m]; None if not used
    elastic_sum: float = 0.0  # Σ z·u of these heights z and displacements u [m²]


_bodies = Cache[ElasticBodies](size_of=lambda _: 1, limit=_MAX_BODIES)
_solids = Cache[ElasticHalfSpace](size_of=lambda _: 1, limit=_MAX_BODIES)  # for any surface
_heights = Cache[Array | None](size_of=lambda _: 1, limit=1)  # one surface, for all its grids
_summits = Cache[Any](size_of=lambda _: 1, limit=_MAX_BODIES)
# Of a body at rest the spectrum is real, and is stored twice more for multiplication.
_heat_maps = Cache[ConductingHalfSpace](
    size_of=lambda body: body.spectrum.nbytes * (3 if np.isrealobj(body.spectrum) else 1),
    limit=_MAX_BYTES,
)
_contacts = Cache[State](
    size_of=lambda state: (4 + len(state.passing)) * state.pressure.nbytes, limit=_MAX_BYTES
)


def cached_heights(scene: Scene) -> Array | None:
    """Heights of the disk on the pixels [m], cached; None if it is smooth."""
    return _heights.get((scene.roughness, scene.pixels), scene.heights)


def cached_summits(scene: Scene, compute: Callable[[], Value]) -> Value:
    """Widths and slope of the summits of the scene's surface, cached for scenes of any fidelity.

    `compute` is called if they are not cached yet.
    """
    summits: Value = _summits.get((scene.roughness, scene.pixels), compute)
    return summits


def elastic_bodies(scene: Scene) -> ElasticBodies:
    """Elastic response and undeformed separation of a scene's bodies, on its grid; cached."""
    return _bodies.get(scene, lambda: _elastic_bodies(scene))


def heat_map(
    grid: Grid, material: Material, velocity: float, time: float, length: float
) -> ConductingHalfSpace:
    """Map from a flux [W/m²] to the rise of a body [K]; cached. See `ConductingHalfSpace`."""
    return _heat_maps.get(
        (grid, material, velocity, time, length),
        lambda: ConductingHalfSpace(grid, material, velocity, time, length=length),
    )


def unworn_contact(key: Hashable, compute: Callable[[], State]) -> State:
    """State of a contact that does not depend on earlier steps, cached under `key`.

    `compute` is called if the contact is not cached yet.
    """
    return _contacts.get(key, compute)


def forget_kernels() -> None:
    """Empty all caches of simulations, and free this thread's buffers for Fourier transforms.

    The caches have thermal maps from flux to rise, elastic bodies, surfaces and contacts.

    Examples
    --------
    >>> forget_kernels()
    """
    _bodies.clear()
    _solids.clear()
    _heights.clear()
    _summits.clear()
    _heat_maps.clear()
    _contacts.clear()
    forget_buffers()


def _elastic_bodies(scene: Scene) -> ElasticBodies:
    modulus = contact_modulus(scene.pin.material, scene.disk)
    key = scene.grid, modulus
    solid = _solids.get(key, lambda: ElasticHalfSpace(*key))
    pixel_heights = cached_heights(scene)
    separation = scene.separation(pixel_heights)
    if not (scene.sweeps_over or scene.wears_by_strips or scene.fidelity.imprint):
        return ElasticBodies(solid, separation)
    heights = scene.pin.profile(scene.grid) - separation
    heights -= heights.mean()
    return ElasticBodies(solid, separation, heights, float(np.sum(solid(heights) * heights)))

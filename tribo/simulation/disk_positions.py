"""Contacts that a step has to solve: by its wear scheme, and by the patches of the disk that pass.

Along a periodic y swept wear averages over y, which is exact. Where y is free, as under a ball, the
pin's shape varies along both axes, and the roughness that is swept past must be moved itself: the
pin wears by the pressure averaged over positions of the disk. A step is cut into parts, and in each
stage of each part the disk lies elsewhere. The patch is taken to repeat itself along both axes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tribo.loading import Station
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Array
from tribo.wear import WEAR_SCHEMES, Stage, Wear, WearScheme

# Under balls and crowned pins of 2 to 40 mm whose wear is 9 to 64 times the roughness, with
# correlation lengths of 8 to 30 µm, the rise exceeded by 10 % of the contact is by these within
# 0.9 % of that of 48 parts, in the 25 steps of `standard`; by two parts it is up to 5.2 % too high.
_MOST_PARTS = 8
_IMPRINT = 0.3  # of a part, beyond which a step has more of them, up to that number
_PLASTIC = 1.32471795724474602596  # the root of x³ = x + 1, whose powers fill a square evenly
_STEPS = 1 / _PLASTIC, 1 / _PLASTIC**2


class Pass(NamedTuple):
    """A contact to be solved within a step."""

    stage: Stage
    shift: tuple[int, int] | None = None  # of the disk along x and y, in elements


def parts(scene: Scene, wear: Wear, distance: float) -> int:
    """Parts into which a step of wear is cut, with the disk elsewhere in each.

    As many as leave the imprint of each below a limit. Of a wave of the roughness that is an
    amplitude of kS/λ for small ones: the wear along the distance S [m] by the pressure that
    flattens it, λ the compliance of the half-space to it. Here it is the mean over the waves.
    """
    heights, yielding = elastic_bodies(scene).heights, elastic_bodies(scene).yielding
    if heights is None or not yielding > 0:
        return 1
    imprint = float(np.sum(wear.depth(heights, distance) * heights)) / yielding
    return math.ceil(min(max(imprint / _IMPRINT, 1.0), _MOST_PARTS))


def passes(
    scene: Scene,
    state: State,
    station: Station,
    wear: Wear | None,
    distance: float,
    observed: bool,
    scheme: WearScheme | None = None,
) -> Iterator[Pass]:
    """Contacts that the step from `state` to `station` has to solve, with the wear at its velocity.

    The contact at the disk's own position is solved too, last, where it is to be observed.
    """
    if not wear:
        yield Pass(Stage(station.normal_load, 0.0, 0.0))
        return
    runge_kutta = WEAR_SCHEMES[scheme or scene.fidelity.wear_scheme]
    loads = state.normal_load, station.normal_load
    mean_load = max(0.0, (station.impulse - state.impulse) / (station.time - state.time))
    if not scene.sweeps_over:
        yield from map(Pass, runge_kutta.stages(loads, mean_load, distance))
        return
    count = parts(scene, wear, distance)
    ends = np.linspace(*loads, count + 1)
    # Each part has the share of the impulse that it would have if the load changed linearly.
    length = float(ends.sum() - (ends[0] + ends[-1]) / 2)
    for part in range(count):
        begin, end = float(ends[part]), float(ends[part + 1])
        mean = count * mean_load * (begin + end) / 2 / length if length else mean_load
        stages = list(runge_kutta.stages((begin, end), mean, distance / count))
        for place, stage in enumerate(stages, len(stages) * (_MOST_PARTS * station.index + part)):
            yield Pass(stage, _position(scene, place))
    # Pressure and temperature are looked at where the disk has worn nothing yet: any other position
    # has left the imprint of its waves, which would make the contact rougher and too hot.
    if observed:
        yield Pass(Stage(station.normal_load, 0.0, 0.0))


def separation_at(scene: Scene, shift: tuple[int, int] | None) -> Array:
    """Distance of the unworn, undeformed surfaces where the disk has moved [m]."""
    _, separation, heights, _ = elastic_bodies(scene)
    if shift is None or heights is None:
        return separation
    return separation + heights - np.roll(heights, shift, axis=(0, 1))


def _position(scene: Scene, number: int) -> tuple[int, int]:
    # Roberts' sequence fills the patch evenly, so that no position comes twice.
    x, y = (int(n * (number * step % 1)) for n, step in zip(scene.grid.shape, _STEPS, strict=True))
    return x, y

"""Contacts that a step has to solve: by its wear scheme, and by the patches of the disk that pass.

Along a periodic y swept wear averages over y, which is exact. Where y is free, as under a ball, the
pin's shape varies along both axes, and the roughness that is swept past must be moved itself: the
pin wears by the pressure averaged over positions of the disk. A step is cut into parts, and in each
stage of each part the disk lies elsewhere. The patch is taken to repeat itself along both axes.

Where few elements touch, the temperature at one position depends on a few summits. It is then a
mean over positions, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tribo.loading import MeasuredLoad, Station
from tribo.material import contact_modulus
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Array
from tribo.wear import WEAR_SCHEMES, Stage, Wear, WearScheme

# Under balls and crowned pins of 2 to 40 mm whose wear is 9 to 64 times the roughness, with
# correlation lengths of 8 to 30 µm, the rise exceeded by 10 % of the contact is by these within
# 0.9 % of that of 48 parts, in the 25 steps of `standard`; by two parts it is up to 5.2 % too high.
_MOST_PARTS = 8
_IMPRINT = 0.3  # imprint in a part beyond which a step has more parts, up to that number
_PLASTIC = 1.32471795724474602596  # the root of x³ = x + 1, whose powers fill a square evenly
_STEPS = 1 / _PLASTIC, 1 / _PLASTIC**2
# Positions of the disk over which a temperature is a mean: up to so many, and with so many pixels
# of Hertzian contact in all of them. The rise of five balls and crowned pins on 56 to 563 elements
# differed between 50, 100, 200 and 400 steps by 0.8 to 7.4 % at one position, by 0.03 to 0.9 % so,
# and others that wear heavily by up to 2.6 % from 50 to 100. Of the positions themselves: a ball of
# 2 mm at 10 N that wears off 2.4 µm moves by 0.5 % from 9 to 19 and 0.8 % from 19 to 38.
_MOST_POSITIONS, _PIXELS = 100, 1e5
# Below so many, the disk's own position suffices: from one to another the shipped ball's rise
# differs by 0.4 %.
_FEWEST_POSITIONS = 5
# From so many positions on steps of wear have more parts. Without, the ball on 140 elements among
# these differed by 3.0 %, not 0.5 %.
_FEW, _MORE_PARTS = 20, 3
_SHIFT = 4  # pixels by which positions differ, so that they are the same on larger elements


class Pass(NamedTuple):
    """A contact to be solved within a step."""

    stage: Stage
    shift: tuple[int, int] | None = None  # the disk's along x and y, in elements


def part_count(scene: Scene, wear: Wear, distance: float) -> int:
    """Parts into which a step of wear is cut, with the disk elsewhere in each.

    As many as leave the imprint of each below a limit. Of a wave of the roughness that is an
    amplitude of kS/λ for small ones: the wear along the distance S [m] by the pressure that
    flattens it, λ the compliance of the half-space to it. Here it is the mean over the waves.
    """
    imprint = imprint_of(scene, wear, distance)
    finer = _finer(scene)
    return math.ceil(min(max(finer * imprint / _IMPRINT, 1.0), finer * _MOST_PARTS))


def imprint_of(scene: Scene, wear: Wear, distance: float) -> float:
    """Imprint of the disk's roughness in a pin after a distance [m], see `parts`; 0 if unknown."""
    heights, yielding = elastic_bodies(scene).heights, elastic_bodies(scene).yielding
    if heights is None or not yielding > 0:
        return 0.0
    return float(np.sum(wear.depth(heights, distance) * heights)) / yielding


def _finer(scene: Scene) -> int:
    """Parts of a step of wear, for each one where many elements touch."""
    loading = scene.loading
    highest = loading.peak if isinstance(loading, MeasuredLoad) else loading.reference_load
    return _MORE_PARTS if position_count(scene, highest) >= _FEW else 1


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
    if not wear or not distance:
        yield Pass(Stage(station.normal_load, 0.0, 0.0))
        return
    runge_kutta = WEAR_SCHEMES[scheme or scene.fidelity.wear_scheme]
    loads = state.normal_load, station.normal_load
    mean_load = max(0.0, (station.impulse - state.impulse) / (station.time - state.time))
    if not scene.sweeps_over:
        yield from map(Pass, runge_kutta.stages(loads, mean_load, distance))
        return
    count, most = part_count(scene, wear, distance), _finer(scene) * _MOST_PARTS
    ends = np.linspace(*loads, count + 1)
    # Each part has the share of the impulse that it would have if the load changed linearly.
    length = float(ends.sum() - (ends[0] + ends[-1]) / 2)
    for part in range(count):
        begin, end = float(ends[part]), float(ends[part + 1])
        mean = count * mean_load * (begin + end) / 2 / length if length else mean_load
        stages = list(runge_kutta.stages((begin, end), mean, distance / count))
        for place, stage in enumerate(stages, len(stages) * (most * station.index + part)):
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


def further_positions(scene: Scene, normal_load: float) -> list[tuple[int, int]]:
    """Shifts of the disk over which, with its own position, the temperature at a load is a mean.

    By pixels and not by elements, for a mean that all fidelities share.
    """
    if not scene.sweeps_over:
        return []
    block = scene.fidelity.pixels_per_element
    units = [math.lcm(math.gcd(n, _SHIFT), block) // block for n in scene.pixels.shape]
    return [_position(scene, n, units) for n in range(1, position_count(scene, normal_load))]


def position_count(scene: Scene, normal_load: float) -> int:
    """Number of positions over which the temperature at a load is a mean."""
    modulus = contact_modulus(scene.pin.material, scene.disk)
    mean_pressure = scene.pin.hertz(normal_load, modulus).peak_pressure / 1.5
    touching = normal_load / scene.pin.patches(scene.grid) / mean_pressure
    pixels = touching / scene.pixels.element_area
    count = int(_PIXELS / max(pixels, _PIXELS / _MOST_POSITIONS))
    return count if count >= _FEWEST_POSITIONS else 1


def _position(scene: Scene, number: int, units: Sequence[int] = (1, 1)) -> tuple[int, int]:
    """Shift in elements, a multiple of as many as are given along each axis."""
    # Roberts' sequence fills the patch evenly, so that no position comes twice.
    x, y = (
        unit * int(n / unit * (number * step % 1))
        for n, unit, step in zip(scene.grid.shape, units, _STEPS, strict=True)
    )
    return x, y

"""Contacts that a step has to solve: by its wear scheme, and by the parts of the disk that pass.

Along a periodic y swept wear averages over y, which is exact. If y is free, as under a ball, the
pin's shape varies along both axes, and the roughness itself has to be moved: the pin wears by the
pressure averaged over positions of the disk. A step is cut into parts, and in each stage of each
part the disk lies elsewhere. The window is taken to repeat itself along both axes.

Where few elements touch, the temperature at one position depends on a few summits. The
temperature is then a mean over positions, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tribo.constants import (
    FEW_POSITIONS,
    FEW_POSITIONS_PART_FACTOR,
    FEWEST_POSITIONS,
    MAX_PART_IMPRINT,
    MOST_PARTS_OF_WEAR,
    MOST_POSITIONS,
    PIXELS_OF_POSITIONS,
    SHIFT,
)
from tribo.loading import LoadStep, MeasuredLoad, Stages
from tribo.material import contact_modulus
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Array
from tribo.wear import WEAR_SCHEMES, Stage, Wear, WearScheme

_PLASTIC = 1.32471795724474602596  # root of x³ = x + 1, whose powers fill a square evenly
_STEPS = 1 / _PLASTIC, 1 / _PLASTIC**2


class Pass(NamedTuple):
    """A contact to be solved within a step of the loading, and the shift of the disk in it.

    The shift is in elements along x and y; None for the unshifted disk.
    """

    stage: Stage
    shift: tuple[int, int] | None = None  # of the disk along x and y, in elements


def part_count(scene: Scene, wear: Wear, distance: float) -> int:
    """Number of parts into which a step is cut; in each part the disk has other positions.

    The deeper the imprint that the disk's roughness would wear into the pin over the `distance`
    [m] slid in the whole step, the more parts there are, up to a limit.
    """
    imprint = imprint_ratio(scene, wear, distance)
    finer = _part_factor(scene)
    return math.ceil(min(max(finer * imprint / MAX_PART_IMPRINT, 1.0), finer * MOST_PARTS_OF_WEAR))


def imprint_ratio(scene: Scene, wear: Wear, distance: float) -> float:
    """Depth of the roughness's imprint in the worn pin, divided by the height of the roughness.

    For a wave of the roughness the ratio is kS/λ, with the specific wear rate k of `wear` [m²/N],
    the sliding `distance` S [m] and the compliance λ of the half-space to this wave [m/Pa]. The
    result is a mean over all waves. It is 0 if the disk is smooth, or if the scene uses neither
    shifted disks nor the fidelity's `imprint`.
    """
    heights, elastic_sum = elastic_bodies(scene).heights, elastic_bodies(scene).elastic_sum
    if heights is None or not elastic_sum > 0:
        return 0.0
    return float(np.sum(wear.depth(heights, distance) * heights)) / elastic_sum


def _part_factor(scene: Scene) -> int:
    """Factor on the number of parts of a step of wear: above 1 if few elements touch, else 1."""
    loading = scene.loading
    if isinstance(loading, Stages):
        highest = loading.loads[-1]
    else:
        highest = loading.peak if isinstance(loading, MeasuredLoad) else loading.reference_load
    return FEW_POSITIONS_PART_FACTOR if position_count(scene, highest) >= FEW_POSITIONS else 1


def passes(
    scene: Scene,
    state: State,
    load_step: LoadStep,
    wear: Wear | None,
    distance: float,
    observed: bool,
    scheme: WearScheme,
) -> Iterator[Pass]:
    """Yield the contacts to solve in the step from `state` to `load_step`, in order.

    The pin wears by `wear` over the `distance` slid in the step [m]. `scheme` integrates the
    wear. If `observed`, the disk is unshifted in the last contact.
    """
    if not wear or not distance:
        yield Pass(Stage(load_step.normal_load, 0.0, 0.0))
        return
    runge_kutta = WEAR_SCHEMES[scheme]
    loads = state.normal_load, load_step.normal_load
    mean_load = max(0.0, (load_step.impulse - state.impulse) / (load_step.time - state.time))
    if not scene.sweeps_over:
        yield from map(Pass, runge_kutta.stages(loads, mean_load, distance))
        return
    count, max_parts = part_count(scene, wear, distance), _part_factor(scene) * MOST_PARTS_OF_WEAR
    ends = np.linspace(*loads, count + 1)
    # Each part has the share of the impulse that it would have if the load changed linearly.
    length = float(ends.sum() - (ends[0] + ends[-1]) / 2)
    for part in range(count):
        begin, end = float(ends[part]), float(ends[part + 1])
        mean = count * mean_load * (begin + end) / 2 / length if length else mean_load
        stages = list(runge_kutta.stages((begin, end), mean, distance / count))
        for number, stage in enumerate(stages, len(stages) * (max_parts * load_step.index + part)):
            yield Pass(stage, _position(scene, number))
    # Pressure and temperature are evaluated with the unshifted disk, which has worn nothing yet.
    # Any other position has left an imprint, which would make the contact rougher and too hot.
    if observed:
        yield Pass(Stage(load_step.normal_load, 0.0, 0.0))


def separation_at(scene: Scene, shift: tuple[int, int] | None) -> Array:
    """Separation of the unworn, undeformed surfaces [m], (nx, ny), with the disk moved by `shift`.

    The shift is in elements towards +x and +y; None for the unmoved disk.
    """
    _, separation, heights, _ = elastic_bodies(scene)
    if shift is None or heights is None:
        return separation
    return separation + heights - np.roll(heights, shift, axis=(0, 1))


def further_positions(scene: Scene, normal_load: float) -> list[tuple[int, int]]:
    """Shifts of the disk over which a temperature is averaged, in addition to no shift.

    The shifts are in elements along x and y; none if one position is enough. They are multiples of
    `SHIFT` pixels where the window allows it, so that all fidelities average over the same
    positions.
    """
    if not scene.sweeps_over:
        return []
    block = scene.fidelity.pixels_per_element
    units = [math.lcm(math.gcd(n, SHIFT), block) // block for n in scene.pixels.shape]
    return [_position(scene, n, units) for n in range(1, position_count(scene, normal_load))]


def position_count(scene: Scene, normal_load: float) -> int:
    """Number of positions of the disk over which the temperature at a load [N] is averaged."""
    modulus = contact_modulus(scene.pin.material, scene.disk)
    mean_pressure = scene.pin.hertz(normal_load, modulus).peak_pressure / 1.5
    contact_area = normal_load / scene.pin.windows(scene.grid) / mean_pressure
    pixels = contact_area / scene.pixels.element_area
    count = int(PIXELS_OF_POSITIONS / max(pixels, PIXELS_OF_POSITIONS / MOST_POSITIONS))
    return count if count >= FEWEST_POSITIONS else 1


def _position(scene: Scene, number: int, units: Sequence[int] = (1, 1)) -> tuple[int, int]:
    """Shift of the disk at its position `number`, in elements: multiples of `units`."""
    # Roberts' sequence fills the window evenly and repeats no position.
    x, y = (
        unit * int(n / unit * (number * step % 1))
        for n, unit, step in zip(scene.grid.shape, units, _STEPS, strict=True)
    )
    return x, y

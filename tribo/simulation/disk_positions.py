"""Contacts that a step has to solve: by its wear scheme, and by the parts of the disk that pass.

Under swept wear the pin wears by the pressure averaged over positions of the moving disk. The
window is taken to repeat itself along both axes.

Along a periodic y, all points of a pin at rest at the same x wear equally, by the mean pressure
along y. One window has too few independent grooves along y for this mean: it keeps the ridges of
the window, and the pin would wear into their negative, which a moving disk does not allow. So the
disk is cut into 32 strips along y, each of which is moved along x to another position:

    z(x − s_n, y) in strip n,  s_n = {n φ + m √2} L_x,                                    (1)

with the heights z, the length L_x of the window, the number m of the stage, and the golden ratio φ,
whose multiples are even in their fractional parts { }. The mean along y is then one over 32
positions, which follow no direction that a lay could have. A strip comes back to within 1 % of the
window only after 70 stages. Pressure and temperature are evaluated with the disk itself, which has
worn nothing.

The wear of the last stages remains in the pin as an imprint of their positions, and changes the
rise at random. More parts of a step, as the preset `fine` has, average over more positions.

If y is free, as under a ball, the pin's shape varies along both axes. A step is then cut into
parts, and in each stage of each part the whole disk lies elsewhere.

The temperature at one position depends on the summits that happen to be in contact there. It is
therefore a mean over positions, too. A contact of many summits needs fewer positions.
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
    PATCHES,
    PIXELS_OF_POSITIONS,
    SHIFT,
    STRIPS,
)
from tribo.loading import LoadStep, MeasuredLoad, Stages
from tribo.material import contact_modulus
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.surface_groups import surface_lengths
from tribo.thermal.quantiles import GROUPS
from tribo.types import Array
from tribo.wear import WEAR_SCHEMES, Stage, Wear, WearScheme

_PLASTIC_NUMBER = 1.32471795724474602596  # root of x³ = x + 1, whose powers fill a square evenly
_POSITION_STEPS = 1 / _PLASTIC_NUMBER, 1 / _PLASTIC_NUMBER**2
# Multiples of both ratios fill a length evenly; those of the second one return late to the first.
_GOLDEN_RATIO, _SILVER_RATIO = (math.sqrt(5) - 1) / 2, math.sqrt(2)


class Pass(NamedTuple):
    """A contact to be solved within a step of the loading, and the shift of the disk in it.

    The shift is in elements along x and y; None for the unshifted disk. If the disk is in strips,
    they have their own shifts along x instead, as in Eq. (1).
    """

    stage: Stage
    shift: tuple[int, int] | None = None
    strip_shifts: tuple[int, ...] = ()


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
    velocity: float,
    observed: bool,
    scheme: WearScheme,
) -> Iterator[Pass]:
    """Yield the contacts to solve in the step from `state` to `load_step`, in order.

    The pin wears by `wear` at the sliding `velocity` [m/s], along which strips of the disk move.
    `scheme` integrates the wear. If `observed`, the disk is unshifted in the last contact, which
    wears nothing if the disk is shifted in the others.
    """
    distance = abs(velocity) * (load_step.time - state.time)
    if not wear or not distance:
        yield Pass(Stage(load_step.normal_load, 0.0, 0.0))
        return
    runge_kutta = WEAR_SCHEMES[scheme]
    loads = state.normal_load, load_step.normal_load
    mean_load = max(0.0, (load_step.impulse - state.impulse) / (load_step.time - state.time))
    if not scene.sweeps_over:
        stages = list(runge_kutta.stages(loads, mean_load, distance))
        if not scene.wears_by_strips:
            yield from map(Pass, stages)
            return
        part = scene.fidelity.parts * load_step.index + load_step.part
        for number, stage in enumerate(stages, len(stages) * part):
            yield Pass(stage, strip_shifts=_strip_shifts(scene, number, velocity))
        if observed:
            yield Pass(Stage(load_step.normal_load, 0.0, 0.0))
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


def _strip_shifts(scene: Scene, stage_number: int, velocity: float) -> tuple[int, ...]:
    """Shifts of the disk's strips in a stage, in elements along x, by Eq. (1).

    The strips are moved along the sliding `velocity`.
    """
    direction, begin = (1 if velocity > 0 else -1), stage_number * _SILVER_RATIO
    return tuple(
        direction * int(scene.grid.shape[0] * ((number * _GOLDEN_RATIO + begin) % 1))
        for number in range(STRIPS)
    )


def separation_at(
    scene: Scene, shift: tuple[int, int] | None, strip_shifts: tuple[int, ...] = ()
) -> Array:
    """Separation of the unworn, undeformed surfaces [m], (nx, ny), with the disk moved by `shift`.

    The shift is in elements towards +x and +y; None for the unmoved disk. If there are
    `strip_shifts`, they move as many strips of the disk along x.
    """
    _, separation, heights, _ = elastic_bodies(scene)
    if heights is None or (shift is None and not strip_shifts):
        return separation
    if shift is not None:
        return separation + heights - np.roll(heights, shift, axis=(0, 1))
    strips = np.array_split(heights, len(strip_shifts), axis=1)
    moved = [np.roll(strip, n, axis=0) for strip, n in zip(strips, strip_shifts, strict=True)]
    return separation + heights - np.concatenate(moved, axis=1)


def further_positions(scene: Scene, normal_load: float) -> list[tuple[int, int]]:
    """Shifts of the disk over which a temperature is averaged, in addition to no shift.

    The shifts are in elements along x and y; none if one position is enough. They are multiples of
    `SHIFT` pixels where the window allows it, so that all fidelities average over the same
    positions.
    """
    block = scene.fidelity.pixels_per_element
    units = [math.lcm(math.gcd(n, SHIFT), block) // block for n in scene.pixels.shape]
    if scene.wears_by_strips:
        count = line_position_count(scene, normal_load)
        distance = scene.grid.shape[0] / (count * units[0])
        return [(units[0] * round(number * distance), 0) for number in range(1, count)]
    if not scene.sweeps_over:
        return []
    return [_position(scene, n, units) for n in range(1, position_count(scene, normal_load))]


def line_position_count(scene: Scene, normal_load: float) -> int:
    """Number of positions of the disk over which the temperature of a line contact is averaged.

    It is 1, 2, 4 or 8: the fewest with which the smooth contacts at a load [N] cover together at
    least `PATCHES` patches of the surface, each as large as the product of both correlation
    lengths. Eight positions must do.
    """
    modulus = contact_modulus(scene.pin.material, scene.disk)
    mean_pressure = scene.pin.hertz(normal_load, modulus).peak_pressure * math.pi / 4
    contact_area = normal_load / scene.pin.windows(scene.grid) / mean_pressure
    patches = contact_area / math.prod(surface_lengths(scene))
    return next((n for n in (1, 2, 4) if n * patches >= PATCHES), GROUPS)


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
        for n, unit, step in zip(scene.grid.shape, units, _POSITION_STEPS, strict=True)
    )
    return x, y

"""Steps cut into parts if each would leave too deep an imprint of the roughness in the pin.

A pin that wears point by point becomes the negative of the area that it faces. A pin that wears by
mean pressures along y takes an imprint of long ridges along y in each part of a step. Most of this
happens within a few steps. The depth of a step's imprint depends only on the velocity and the wear
rate, and the rate on the state before the step. So loads that share a ramp have the same parts of
its steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from tribo.constants import MOST_PARTS_OF_STEP, RESOLVING_STEPS
from tribo.loading import LoadStep
from tribo.simulation.disk_positions import imprint_ratio
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.step_wear import step_wear


def step_parts(
    scene: Scene, before: State, load_step: LoadStep, velocity: float
) -> Iterator[LoadStep]:
    """Cut a step into parts of equal duration; yield time and load at the end of each part.

    The step leads from the state `before` to `load_step`, which is yielded last. The step has so
    many parts that in each the roughness wears only a shallow imprint into the pin, but at most 4,
    and only one with 25 steps or more. A dense contact has more parts, see
    `tribo.simulation.element_size`.
    """
    distance = abs(velocity) * (load_step.time - before.time)
    count = 1 if load_step.holding or not scene.wears else scene.fidelity.parts
    count *= _part_count(scene, before, distance / count, velocity)
    for part in range(1, count):
        yield replace(interpolate_step(before, load_step, part / count), part=part - 1)
    yield load_step if count == 1 else replace(load_step, part=count - 1)


def _part_count(scene: Scene, before: State, distance: float, velocity: float) -> int:
    if not (scene.fidelity.imprint and distance) or scene.sweeps_over:
        return 1
    wear = step_wear(scene, before, distance, velocity)
    if wear is None:
        return 1
    fidelity = scene.fidelity
    resolving_parts = math.ceil(RESOLVING_STEPS / (fidelity.increments * fidelity.parts))
    imprint = imprint_ratio(scene, wear, distance) / fidelity.imprint
    return math.ceil(min(max(imprint, 1.0), MOST_PARTS_OF_STEP, resolving_parts))


def interpolate_step(before: State, load_step: LoadStep, share: float) -> LoadStep:
    """Time and load after a `share` of a step's duration, if the load changes linearly within it.

    The step leads from the state `before` to `load_step`.
    """
    begin, end = before.normal_load, load_step.normal_load
    load = begin + share * (end - begin)
    # 0 for an unloaded step.
    impulse_share = share * (begin + load) / (begin + end) if begin + end else 0.0
    impulse = impulse_share * (load_step.impulse - before.impulse)
    return replace(
        load_step,
        normal_load=load,
        time=before.time + share * (load_step.time - before.time),
        on_trunk=False,
        impulse=before.impulse + impulse,
    )

"""Promises of `--accuracy`, on every scene that we keep and on windows of full size."""

import functools
from pathlib import Path

import numpy as np
import pytest

import pipeline
from tests.helpers.accuracy_scenes import ALUMINA, SCENES
from tests.helpers.entries import changed
from tests.promises.judge import (
    boundaries,
    boundary_velocity,
    exponents,
    largest_error,
    places,
    true_boundary,
)
from tests.promises.wide import random_wide_sweep
from tribo import Ball, Crowned, Cylinder, Grid, SelfAffineRoughness

SHIPPED = pipeline.load_scene(Path(__file__).parents[3] / "workflows" / "irg_transition.toml")
LARGE = {
    "shipped": SHIPPED,
    "shipped, another radius": changed(
        SHIPPED,
        pin=Cylinder(5e-3, 3.4e-3, SHIPPED.scene.disk),
        pixels=Grid((480, 240), (1.3e-6, 1.9e-6), (False, True)),
    ),
    "shipped, another surface": changed(
        SHIPPED, roughness=SelfAffineRoughness(0.4e-6, 0.7, (6e-6, 12e-6), seed=5)
    ),
    "shipped, other loads and pin": changed(
        SHIPPED,
        pin=Cylinder(2e-3, 3.4e-3, ALUMINA),
        loads=tuple(float(load) for load in range(100, 301, 25)),
        pixels=Grid((480, 240), (0.6e-6, 0.95e-6), (False, True)),
    ),
}
SMALL = {
    "no wear, few pixels": changed(
        SCENES["no wear"],
        loads=(200.0, 750.0),
        pixels=Grid((64, 32), (6e-6, 6e-6)),
        roughness=SelfAffineRoughness(0.27e-6, 0.8, (12e-6, 12e-6), seed=0),
    )
}
# With so many velocities, measuring the fidelities costs less than using the reference.
VELOCITIES = tuple(float(velocity) for velocity in np.geomspace(0.25, 8.0, 40))
ALL = {
    name: changed(scene, velocities=VELOCITIES) for name, scene in (SCENES | LARGE | SMALL).items()
}


@functools.cache
def truth(name):
    return true_boundary(ALL[name])


@functools.cache
def true_error(name, fidelity):
    true = truth(name)
    velocities, _ = boundaries(ALL[name], fidelity, true, exponents(ALL[name], true))
    return largest_error(velocities, true)


@pytest.mark.parametrize(("seed", "pin"), [(124, Ball), (125, Crowned), (126, Cylinder)])
def test_scenes_of_the_wider_family_turn_severe_amid_their_velocities(seed, pin):
    sweep = random_wide_sweep(seed)
    assert isinstance(sweep.scene.pin, pin)
    place, middle = (
        places(sweep)[1],
        (sweep.velocities[0] * sweep.velocities[-1]) ** 0.5,
    )
    velocity, _ = boundary_velocity(sweep, sweep.scene.fidelity, place, middle)
    assert sweep.velocities[0] < velocity < sweep.velocities[-1]

"""Parts of a step: each wears by the load that acts in it, which grows linearly with time."""

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, small_scene
from tribo import Ball, Fidelity, Grid, Ramp, Scene, SelfAffineRoughness, Wear
from tribo.simulation.disk_positions import passes
from tribo.simulation.loading_step import start
from tribo.simulation.parts_of_steps import step_parts

RATE, VELOCITY = 150.0, 1.5


def test_a_part_has_the_impulse_of_its_own_loads():
    scene = small_scene(parts=4)
    first = next(scene.load_steps(600.0))
    parts = list(step_parts(scene, start(scene), first, VELOCITY))
    assert [part.time / first.time for part in parts] == pytest.approx([0.25, 0.5, 0.75, 1.0])
    # ∫F dt of F = RATE t
    expected = [RATE * part.time**2 / 2 for part in parts]
    assert [part.impulse for part in parts] == pytest.approx(expected, rel=1e-12)


def test_contacts_at_positions_of_the_disk_wear_by_the_loads_of_their_parts():
    scene = Scene(
        pin=Ball(5e-3, STEEL),
        disk=STEEL,
        pixels=Grid((96, 96), (6e-6, 6e-6), periodic=(False, False)),
        loading=Ramp(RATE, 75.0),
        roughness=SelfAffineRoughness(0.2e-6, 0.8, (16e-6, 16e-6), seed=0),
        wear=Wear(1e-14),
        fidelity=Fidelity(increments=4),
    )
    first = next(scene.load_steps(75.0))
    begin = start(scene)
    parts = list(passes(scene, begin, first, scene.wear, VELOCITY, False, "implicit"))
    assert len(parts) > 2
    slid = VELOCITY * first.time / len(parts)
    worn = np.cumsum([part.stage.normal_load * part.stage.distance for part in parts])
    # V ∫F dt until the end of each part
    expected = [RATE * (n * slid) ** 2 / VELOCITY / 2 for n in range(1, len(parts) + 1)]
    assert worn == pytest.approx(expected, rel=1e-12)

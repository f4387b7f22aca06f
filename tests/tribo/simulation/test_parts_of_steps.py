"""Parts of a step: each wears by the load that acts in it, which grows linearly with time."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, small_scene
from tribo import Ball, Fidelity, Grid, Ramp, Scene, SelfAffineRoughness, Wear
from tribo.simulation import loading_step
from tribo.simulation.disk_positions import passes
from tribo.simulation.loading_step import start
from tribo.simulation.step_wear import step_parts

RATE, VELOCITY = 150.0, 1.5


def test_a_part_has_the_impulse_of_its_own_loads():
    scene = small_scene(parts=4)
    first = next(scene.load_steps(600.0))
    parts = list(step_parts(scene, start(scene), first, VELOCITY))
    assert [part.time / first.time for part in parts] == pytest.approx([0.25, 0.5, 0.75, 1.0])
    # ∫F dt of F = RATE t
    expected = [RATE * part.time**2 / 2 for part in parts]
    assert [part.impulse for part in parts] == pytest.approx(expected, rel=1e-12)


def passes_of_a_ball(specific_wear_rate=1e-14):
    """Contacts of the first load step of a rough ball, and the duration of the step [s]."""
    scene = Scene(
        pin=Ball(5e-3, STEEL),
        disk=STEEL,
        pixels=Grid((96, 96), (6e-6, 6e-6), periodic=(False, False)),
        loading=Ramp(RATE, 75.0),
        roughness=SelfAffineRoughness(0.2e-6, 0.8, (16e-6, 16e-6), seed=0),
        wear=Wear(specific_wear_rate),
        fidelity=Fidelity(increments=4),
    )
    first = next(scene.load_steps(75.0))
    begin = start(scene)
    return [*passes(scene, begin, first, scene.wear, VELOCITY, False, "implicit")], first.time


def test_contacts_at_positions_of_the_disk_wear_by_the_loads_of_their_parts():
    parts, duration = passes_of_a_ball()
    assert len(parts) > 2
    slid = VELOCITY * duration / len(parts)
    worn = np.cumsum([part.stage.normal_load * part.stage.distance for part in parts])
    # V ∫F dt until the end of each part
    expected = [RATE * (n * slid) ** 2 / VELOCITY / 2 for n in range(1, len(parts) + 1)]
    assert worn == pytest.approx(expected, rel=1e-12)


def test_positions_of_the_disk_lie_in_all_quarters_of_the_window():
    parts, _ = passes_of_a_ball(specific_wear_rate=1e-12)
    shifts = [part.shift for part in parts]  # of 48 × 48 elements
    assert len({(x >= 24, y >= 24) for x, y in shifts}) == 4


def test_the_residual_of_a_step_is_the_largest_of_its_contacts(monkeypatch):
    scene, residuals = small_scene(), []
    solve = loading_step.solve_pass

    def recorded(*arguments):
        contact, displacement = solve(*arguments)
        residuals.append(1e-7 / (1 + len(residuals)))
        return replace(contact, residual=residuals[-1]), displacement

    monkeypatch.setattr(loading_step, "solve_pass", recorded)
    first = next(scene.load_steps(600.0))
    state = loading_step.advance(scene, start(scene), first, VELOCITY)
    assert len(residuals) > 1
    assert state.residual == 1e-7

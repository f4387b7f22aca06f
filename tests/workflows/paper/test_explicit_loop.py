"""The paper's explicit wear loop (workflows/paper/explicit_loop.py)."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, small_scene
from tribo import Cylinder, Fidelity, Grid, InputError, Ramp, Scene, Wear, simulate
from workflows.paper.explicit_loop import EXPLICIT_LIMIT, explicit_loop, highest_rise, stiffness

LOAD, VELOCITY = 750.0, 1.25  # the paper's severest point


def plane(increments):
    """Scene with the paper's wear under a smooth pin, whose elements are rows."""
    return Scene(
        pin=Cylinder(2e-3, 3.4e-3, STEEL),
        disk=STEEL,
        pixels=Grid((120, 1), (3.264e-6, 456e-6)),
        loading=Ramp(150.0, LOAD),
        wear=Wear(1.2e-15, "swept"),
        fidelity=Fidelity(pixels_per_element=1, increments=increments, contact_tolerance=1e-6),
    )


@functools.cache
def explicit(increments):
    return explicit_loop(plane(increments), LOAD, VELOCITY)


@functools.cache
def implicit():
    *_, state = simulate(plane(100), LOAD, VELOCITY)
    return state


def roughness_of(pressure):
    """Mean change of the pressure's slope between elements in contact, over mean pressure."""
    inside = pressure[pressure[:, 0] > 0].mean(axis=1)
    return float(np.abs(np.diff(inside, 2)).mean() / inside.mean())


def stiffness_of(increments):
    scene = plane(increments)
    return stiffness(scene, scene.grid, VELOCITY * LOAD / 150.0 / increments)


def test_the_paper_s_increments_leave_a_checkerboard():
    # Neighbours differ by more than the mean pressure; by implicit wear, by a thousandth.
    assert stiffness_of(100) > EXPLICIT_LIMIT
    assert roughness_of(implicit().pressure) < 0.01
    assert roughness_of(explicit(100)) > 0.5
    assert explicit(100).max() > 2 * implicit().pressure.max()


def test_increments_below_the_limit_of_stability_give_the_implicit_result():
    assert stiffness_of(179) < EXPLICIT_LIMIT < stiffness_of(178)
    assert roughness_of(explicit(179)) < 0.03
    # The nearest image alone deforms less than all images.
    assert explicit(179).max() == pytest.approx(implicit().pressure.max(), rel=0.01)


def test_the_loop_carries_the_load():
    carried = (
        explicit(100).sum() * plane(100).grid.element_area * plane(100).pin.windows(plane(100).grid)
    )
    assert carried == pytest.approx(LOAD, rel=1e-10)


def test_stiffness_is_that_of_the_shapes_that_wear():
    grid = Grid((240, 240), (1.632e-6, 1.9e-6))
    local, swept = (
        stiffness(replace(plane(100), wear=Wear(1.2e-15, pattern)), grid, 0.0625)
        for pattern in ("local", "swept")
    )
    # The smallest eigenvalues of this grid are 8.80e-18 and 1.05e-17 m/Pa, to three digits.
    assert local == pytest.approx(1.2e-15 * 0.0625 / 8.80e-18, rel=1e-3)
    assert swept == pytest.approx(1.2e-15 * 0.0625 / 1.05e-17, rel=2e-3)


def test_the_highest_rise_is_that_of_a_heated_length_of_two_windows():
    """The window and its nearest image heat about as much as a pin of twice the window's length."""
    scene = replace(small_scene(roughness=False), wear=None)
    scene = replace(scene, pin=replace(scene.pin, length=2 * scene.pixels.size[1]))
    *_, state = simulate(scene, 10.0, VELOCITY)
    rise = highest_rise(scene, state.pressure, VELOCITY, state.time)
    assert rise == pytest.approx(state.heat.max_rise, rel=0.02)


def test_a_scene_without_archard_wear_is_refused():
    with pytest.raises(InputError, match="wear"):
        explicit_loop(replace(plane(100), wear=None), LOAD, VELOCITY)

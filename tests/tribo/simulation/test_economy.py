"""Only what a scene requires is computed, and what is left out changes no result."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import small_scene, with_hardness
from tribo import QUANTILES, Grid, MeasuredRoughness, Wear, measures, simulate

DECISIVE = QUANTILES.index(0.9)


def rough_scene(**fidelity):
    """Scene with 192 × 96 pixels, enough for heat history on a coarser grid."""
    scene = small_scene(**fidelity)
    return replace(
        scene,
        pixels=Grid((192, 96), (2e-6, 2e-6)),
        roughness=replace(scene.roughness, correlation_length=(4e-6, 4e-6)),
    )


def total_work(states):
    # Iterations of the last step count on the finest grid, where most of them are made.
    counts = (s.iterations + (s.heat.iterations if s.heat else 0) for s in states)
    return sum(s.pressure.size * count for s, count in zip(states, counts, strict=True))


# Steps before the end of a point on a coarser grid


def test_a_coarse_history_saves_work_and_hardly_moves_the_temperature():
    full = list(simulate(rough_scene(increments=20, contact_tolerance=1e-3), 600.0, 1.5))
    scene = rough_scene(increments=20, contact_tolerance=1e-3, history_coarsening=2)
    coarse = list(simulate(scene, 600.0, 1.5))
    assert coarse[0].pressure.shape == (96, 48)
    assert coarse[-1].pressure.shape == coarse[-1].heat.rise.shape == (192, 96)
    assert total_work(coarse) < total_work(full) / 2
    # Few summits touch on so small a patch; on the shipped scene the difference is 0.02 %.
    deciding = [states[-1].heat.rise_quantile[DECISIVE] for states in (full, coarse)]
    assert deciding[1] == pytest.approx(deciding[0], rel=0.01)


# Without wear


@pytest.mark.parametrize("wear", [None, Wear(0.0)])
def test_without_wear_a_point_is_one_step(wear):
    scene = with_hardness(small_scene(contact_tolerance=1e-8), 3e9)
    scene = replace(scene, wear=wear)
    states = list(simulate(scene, 600.0, 1.25))
    assert len(states) == 1
    # The path of the load does not matter: a pin that hardly wears reaches the same contact, with
    # plastic yield, in 8 steps.
    hardly = list(simulate(replace(scene, wear=Wear(1e-25)), 600.0, 1.25))
    assert len(hardly) == 8
    assert measures(scene, states[0])["plastic_fraction"] > 0
    assert states[0].pressure == pytest.approx(hardly[-1].pressure, abs=1e-5 * 6.6e9)
    assert states[0].heat.rise == pytest.approx(hardly[-1].heat.rise, rel=1e-5)


# Two smooth bodies


def smooth(pattern, **fidelity):
    """A scene that is simulated as plane, and the same scene with a rough surface of height 0."""
    plane = replace(
        small_scene(pattern, roughness=False, contact_tolerance=1e-9),
        pixels=Grid((96, 64), (4e-6, 4e-6)),
    )
    zero = MeasuredRoughness(np.zeros(plane.pixels.shape))
    return plane, replace(plane, roughness=zero)


@pytest.mark.parametrize("pattern", ["swept", "local"])
def test_a_smooth_scene_is_a_plane_one(pattern):
    plane, full = smooth(pattern)
    assert plane.grid.shape == (96, 1)
    plane_states, full_states = (list(simulate(scene, 600.0, 1.25)) for scene in (plane, full))
    assert total_work(full_states) > 50 * total_work(plane_states)
    plane_state, full_state = plane_states[-1], full_states[-1]
    assert plane_state.heat.rise_quantile == pytest.approx(full_state.heat.rise_quantile, rel=1e-6)
    for name in ("pressure", "wear_depth"):
        field = getattr(full_state, name)
        same = pytest.approx(field, abs=1e-6 * field.max())
        assert np.broadcast_to(getattr(plane_state, name), field.shape) == same
    values, expected = measures(plane, plane_state), measures(full, full_state)
    for name in ("contact_width", "mean_pressure", "wear_volume", "max_rise", "pin_heat_share"):
        assert values[name] == pytest.approx(expected[name], rel=1e-6)

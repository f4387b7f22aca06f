"""Kernels that simulations share (tribo/simulation/cache.py)."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from tests.helpers.scenes import small_scene
from tribo import SelfAffineRoughness, simulate
from tribo.simulation import forget_kernels


def test_threads_simulate_points_of_one_scene_at_the_same_time_bit_for_bit():
    scene = small_scene(increments=4)
    velocities = [0.5, 1.0, 1.5, 2.0]

    def rise(velocity):
        *_, state = simulate(scene, 600.0, velocity)
        return state.heat.rise

    alone = [rise(velocity) for velocity in velocities]
    forget_kernels()
    with ThreadPoolExecutor(4) as threads:
        assert np.array_equal(list(threads.map(rise, velocities)), alone)


def test_the_grids_of_a_scene_have_its_surface_made_once(monkeypatch):
    made, heights = [], SelfAffineRoughness.heights

    def counted(roughness, pixels):
        made.append(roughness)
        return heights(roughness, pixels)

    monkeypatch.setattr(SelfAffineRoughness, "heights", counted)
    forget_kernels()
    scene = small_scene(history_coarsening=2, increments=4)
    assert len(list(scene.levels())) == 2
    *_, _ = simulate(scene, 600.0, 1.0)
    assert len(made) == 1
    *_, _ = simulate(replace(scene, roughness=replace(scene.roughness, seed=1)), 600.0, 1.0)
    assert [roughness.seed for roughness in made] == [0, 1]

"""Kernels that simulations share (tribo/simulation/cache.py)."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from tests.helpers.scenes import small_scene
from tribo import SelfAffineRoughness, forget_kernels, simulate
from tribo.simulation.cache import Kept


def ask(kept, *keys):
    """Keys that are computed when these are asked for, one after the other."""
    computed = []
    for key in keys:
        assert kept.get(key, lambda key=key: computed.append(key) or key) == key
    return computed


def test_values_used_last_are_kept_up_to_a_size():
    kept = Kept(size_of=int, limit=10)
    assert ask(kept, 5, 4, 5, 4) == [5, 4]
    assert ask(kept, 5) == []  # so 4 was used longest ago
    assert ask(kept, 3) == [3]
    assert ask(kept, 5, 3, 4) == [4]
    assert ask(kept, 3, 4) == []
    assert ask(kept, 5) == [5]


def test_threads_that_ask_at_the_same_time_compute_a_value_once():
    kept, started, computed = Kept(size_of=len, limit=100), threading.Barrier(8), []

    def compute():
        computed.append(threading.get_ident())
        threading.Event().wait(0.02)
        return "value"

    def asked(_):
        started.wait(10)
        return kept.get("key", compute)

    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(asked, range(8))) == ["value"] * 8
    assert len(computed) == 1


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

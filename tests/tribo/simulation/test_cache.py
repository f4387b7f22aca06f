"""Kernels and ramps that simulations share (tribo/simulation/cache.py and ramp_cache.py)."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests.helpers.scenes import small_scene
from tribo import simulate
from tribo.simulation import RampCache, forget_kernels
from tribo.simulation.cache import Cache


def test_threads_simulate_points_of_one_scene_at_the_same_time_bit_for_bit():
    scene = small_scene(increments=4)
    velocities = [0.5, 1.0, 1.5, 2.0]

    def rise(velocity):
        *_, state = simulate(scene, 600.0, velocity)
        return state.heat.rise

    serial_rises = [rise(velocity) for velocity in velocities]
    forget_kernels()
    with ThreadPoolExecutor(4) as threads:
        assert np.array_equal(list(threads.map(rise, velocities)), serial_rises)


def test_a_thread_that_wants_what_another_computes_waits_for_it():
    cache = Cache(size_of=lambda _: 1, limit=8)

    def slowly():
        time.sleep(0.05)
        return object()

    with ThreadPoolExecutor(4) as threads:
        values = set(threads.map(lambda _: cache.get("key", slowly), range(4)))
    assert len(values) == 1


@pytest.mark.parametrize(("limit", "further_steps"), [(2**28, 3), (0, 6)])
def test_a_cache_with_room_keeps_the_ramps_of_several_velocities(limit, further_steps):
    scene, ramp_cache = small_scene(), RampCache(limit)
    counts = [
        len(list(simulate(scene, load, velocity, ramp_cache)))
        for load, velocity in ((300.0, 1.0), (300.0, 1.25), (450.0, 1.0), (450.0, 1.25))
    ]
    assert counts == [4, 4, further_steps, further_steps]


@pytest.mark.parametrize(("limit", "steps_again"), [(2**28, 1), (0, 4)])
def test_a_cache_with_room_keeps_the_steps_below_the_highest_load(limit, steps_again):
    scene, ramp_cache = small_scene(), RampCache(limit)
    counts = [len(list(simulate(scene, load, 1.0, ramp_cache))) for load in (300.0, 450.0, 300.0)]
    assert counts == [4, 3, steps_again]

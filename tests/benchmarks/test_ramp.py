"""A whole ramp of the paper's system against the bare transforms that it contains."""

import time

import numpy as np
import pytest

from tests.benchmarks.bare import bare_time, counted_transforms, plain_time
from tests.benchmarks.scene import paper_scene
from tribo import ElasticHalfSpace, contact_modulus, simulate

INCREMENTS = 100


@pytest.fixture(scope="module")
def scene():
    scene = paper_scene()
    next(iter(simulate(scene, 1.0, 1.0)))  # kernels and roughness are made once
    return scene


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("velocity", [0.5, 1.25, 2.75, 5.0])
def test_ramp_of_100_increments(benchmark, scene, velocity):
    def ramp():
        # The last state is left out: its temperature is not part of the ramp.
        states = simulate(scene, 750.0 + 1e-6, velocity)
        return sum(next(states).iterations for _ in range(INCREMENTS))

    convolutions = benchmark.pedantic(ramp, rounds=3)
    with counted_transforms() as transforms:
        ramp()
    seconds = benchmark.stats["min"]
    print(
        f"\n{velocity} m/s: {convolutions / INCREMENTS:.1f} convolutions an increment, "
        f"{seconds / bare_time(transforms):.2f} × its transforms, "
        f"{seconds / plain_time(transforms):.2f} × plain ones for each convolution"
    )


def test_convolution(benchmark, scene):
    solid = ElasticHalfSpace(scene.grid, contact_modulus(scene.disk, scene.disk))
    pressure, out = np.ones(scene.grid.shape), np.empty(scene.grid.shape)
    benchmark(solid, pressure, out=out)

"""Chains of points of the shipped scene against their transforms."""

import time

import pytest

import pipeline
from pipeline.sweep import plan
from tests.benchmarks.bare import bare_time, counted_transforms, plain_time
from tests.benchmarks.scene import SCENE


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("preset", ["draft", "standard"])
@pytest.mark.parametrize("velocity", [0.75, 2.0, 4.0])
def test_chain_of_loads(benchmark, preset, velocity):
    sweep = pipeline.load_scene(SCENE, preset)
    (chain,) = (c for c in plan.chains(plan.points(sweep), sweep) if c[0].velocity == velocity)

    def points():
        trunk = None
        for point in chain:
            trunk = plan.run_point(sweep, point.load, point.velocity, trunk=trunk).trunk

    points()  # kernels and roughness are made once
    benchmark.pedantic(points, rounds=3)
    with counted_transforms() as transforms:
        points()
    seconds = benchmark.stats["min"]
    print(
        f"\n{preset}, {velocity} m/s: {1e3 * seconds / len(chain):.1f} ms a point, "
        f"{seconds / bare_time(transforms):.2f} × its transforms, "
        f"{seconds / plain_time(transforms):.2f} × plain ones for each convolution"
    )

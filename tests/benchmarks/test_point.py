"""All loads of the shipped scene at a velocity against their transforms."""

import time

import pytest

import pipeline
from pipeline.sweep import plan
from tests.benchmarks.bare import bare_time, counted_transforms
from tests.helpers.points import run_point
from tribo.simulation import RampCache


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("preset", ["standard", "fine"])
@pytest.mark.parametrize("velocity", [0.75, 2.0, 4.0])
def test_chain_of_loads(benchmark, preset, velocity):
    sweep = pipeline.load_scene("irg_transition", preset)
    chain = [point for point in plan.points(sweep) if point.velocity == velocity]

    def points():
        ramp_cache = RampCache()
        for point in chain:
            run_point(sweep, point, ramp_cache)

    points()  # makes kernels and roughness before timing
    benchmark.pedantic(points, rounds=3)
    with counted_transforms() as transforms:
        points()
    seconds = benchmark.stats["min"]
    print(
        f"\n{preset}, {velocity} m/s: {1e3 * seconds / len(chain):.1f} ms a point, "
        f"{seconds / bare_time(transforms):.2f} × its transforms"
    )

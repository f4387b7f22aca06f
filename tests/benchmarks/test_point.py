"""Points of the shipped scene: what a first one sets up, and chains against their transforms."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import pipeline
from pipeline.sweep import plan
from tests.benchmarks.bare import bare_time, counted_transforms, plain_time
from tribo import PRESETS

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "workflows" / "irg_transition.toml"
LOAD, VELOCITY = 750.0, 1.25
PROCESSES, ROUNDS = 5, 3

# A process's first point, the same with all that the first one has set up, and what of the first
# one went into surface and kernels [s].
FIRST_AND_NEXT = """
import json, sys, time
from tests.benchmarks.test_point import LOAD, VELOCITY, sweep_at
from tribo import simulate
from tribo.simulation import cache

def seconds(run, *args):
    began = time.process_time()
    run(*args)
    return time.process_time() - began

def timed(make):
    def wrapper(*args):
        made = []
        setting_up.append(seconds(lambda: made.append(make(*args))))
        return made[0]
    return wrapper

sweep, setting_up = sweep_at(sys.argv[1]), []
for name in ("_elastic_bodies", "conducted_spectrum"):
    setattr(cache, name, timed(getattr(cache, name)))
times = [seconds(lambda: list(simulate(sweep.scene, LOAD, VELOCITY))) for _ in range(4)]
print(json.dumps([times[0], min(times[1:]), sum(setting_up)]))
"""


def sweep_at(preset):
    sweep = pipeline.load_scene(SCENE)
    return sweep if preset == "as shipped" else sweep.changed(fidelity=PRESETS[preset])


@pytest.mark.parametrize("preset", ["draft", "standard", "as shipped"])
def test_share_of_a_first_point_that_sets_up(benchmark, preset):
    def first_and_next():
        program = [sys.executable, "-c", FIRST_AND_NEXT, preset]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        ran = subprocess.run(
            program, check=True, capture_output=True, env=environment, timeout=120, cwd=ROOT
        )
        return json.loads(ran.stdout)

    processes = [first_and_next() for _ in range(PROCESSES - 1)]
    processes.append(benchmark.pedantic(first_and_next))
    first, following, setting_up = (min(times) for times in zip(*processes, strict=True))
    print(
        f"\n{preset}: {1e3 * first:.0f} ms the first time, {1e3 * following:.0f} ms the next; "
        f"surface and kernels {setting_up / first:.0%} of the first"
    )


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("preset", ["draft", "standard"])
@pytest.mark.parametrize("velocity", [0.75, 2.0, 4.0])
def test_chain_of_loads(benchmark, preset, velocity):
    sweep = sweep_at(preset)
    (chain,) = (c for c in plan.chains(plan.points(sweep), sweep) if c[0].velocity == velocity)

    def points():
        trunk = None
        for point in chain:
            trunk = plan.run_point(sweep, point.load, point.velocity, trunk=trunk).trunk

    points()  # kernels and roughness are made once
    benchmark.pedantic(points, rounds=ROUNDS)
    with counted_transforms() as transforms:
        points()
    seconds = benchmark.stats["min"]
    print(
        f"\n{preset}, {velocity} m/s: {1e3 * seconds / len(chain):.1f} ms a point, "
        f"{seconds / bare_time(transforms):.2f} × its transforms, "
        f"{seconds / plain_time(transforms):.2f} × plain ones for each convolution"
    )

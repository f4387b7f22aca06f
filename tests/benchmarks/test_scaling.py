"""Growth of a point's time with its grid and its increments."""

import time
from dataclasses import replace

import pytest

from tests.benchmarks.bare import bare_time, counted_transforms
from tests.benchmarks.scene import paper_scene
from tests.helpers.entries import changed
from tribo import QUANTILES, Grid, simulate

FINEST = 960
LOAD, VELOCITY = 750.0, 1.25


@pytest.fixture(scope="module")
def sweep():
    """The paper's system on one surface that all of the grids resolve, each as far as it can."""
    sweep = paper_scene()
    (nx, ny), (dx, dy) = sweep.scene.pixels.shape, sweep.scene.pixels.spacing
    spacing = dx * nx / FINEST, dy * ny / FINEST
    return changed(sweep, pixels=Grid((FINEST, FINEST), spacing, sweep.scene.pixels.periodic))


def measured(benchmark, sweep, **fidelity):
    sweep = changed(sweep, fidelity=replace(sweep.scene.fidelity, **fidelity))

    def point():
        return list(simulate(sweep.scene, LOAD, VELOCITY))

    with counted_transforms() as transforms:
        states = point()
    benchmark.pedantic(point, rounds=2)
    seconds = benchmark.stats["min"]
    n, steps = sweep.scene.grid.shape[0], len(states)
    print(
        f"\n{n} × {n}, {steps} increments: {seconds:.2f} s a point, "
        f"{sum(state.iterations for state in states) / steps:.1f} convolutions of the contact and "
        f"{1e9 * seconds / steps / n**2:.0f} ns an element an increment, "
        f"{seconds / bare_time(transforms):.2f} × the bare transforms; "
        f"Θ10 at friction 1 {states[-1].heat.rise_quantile[QUANTILES.index(0.9)]:.0f} K"
    )


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("n", [60, 120, 240, 480, 960])
def test_grid(benchmark, sweep, n):
    measured(benchmark, sweep, pixels_per_element=FINEST // n, increments=25)


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("increments", [10, 25, 50, 100, 200])
def test_increments(benchmark, sweep, increments):
    measured(benchmark, sweep, pixels_per_element=FINEST // 240, increments=increments)

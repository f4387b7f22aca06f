"""A whole ramp of the paper's system against the bare transforms that it contains."""

from pathlib import Path

import numpy as np
import pytest

import pipeline
from tribo import ElasticHalfSpace, contact_modulus, simulate

SCENE = Path(__file__).parents[2] / "workflows" / "irg_transition.toml"
INCREMENTS = 100


@pytest.fixture(scope="module")
def scene():
    scene = pipeline.load_scene(SCENE)
    next(iter(simulate(scene, 1.0, 1.0)))  # kernels and roughness are made once
    return scene


def bare_transforms(grid, count):
    """The transforms of one convolution, `count` times, into kept buffers."""
    modes = np.zeros((2 * grid.shape[0], grid.shape[1] // 2 + 1), dtype=complex)
    field = np.ones(grid.shape)

    def run():
        nx, ny = grid.shape
        for _ in range(count):
            np.fft.rfft(field, axis=1, out=modes[:nx])
            np.fft.fft(modes, axis=0, out=modes)
            np.fft.ifft(modes, axis=0, out=modes)
            np.fft.irfft(modes[:nx], n=ny, axis=1, out=field)

    return run


@pytest.mark.parametrize("velocity", [0.5, 1.25, 2.75, 5.0])
def test_ramp_of_100_increments(benchmark, scene, velocity):
    import time

    def ramp():
        # The last state is left out: its temperature is not part of the ramp.
        states = simulate(scene, 750.0 + 1e-6, velocity)
        return sum(next(states).iterations for _ in range(INCREMENTS))

    convolutions = benchmark.pedantic(ramp, rounds=3)
    bare = bare_transforms(scene.grid, convolutions)
    times = []
    for _ in range(3):
        began = time.perf_counter()
        bare()
        times.append(time.perf_counter() - began)
    benchmark.extra_info["convolutions an increment"] = convolutions / INCREMENTS
    benchmark.extra_info["ratio to bare transforms"] = benchmark.stats["min"] / min(times)
    print(
        f"\n{velocity} m/s: {convolutions / INCREMENTS:.1f} convolutions an increment, "
        f"{benchmark.stats['min'] / min(times):.2f} times the bare transforms"
    )


def test_convolution(benchmark, scene):
    solid = ElasticHalfSpace(scene.grid, contact_modulus(scene.disk, scene.disk))
    pressure, out = np.ones(scene.grid.shape), np.empty(scene.grid.shape)
    benchmark(solid, pressure, out=out)

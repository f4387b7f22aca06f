"""A smooth scene in one column of elements against the same scene in all of them."""

import time
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from tests.benchmarks.scene import SCENE
from tribo import Fidelity, MeasuredRoughness, simulate

TIGHT = Fidelity(contact_tolerance=1e-8, heat_tolerance=1e-8)


def ramp(scene):
    """States of a ramp, and the work and time that they took."""
    began = time.process_time()
    states = list(simulate(scene, 750.0, 1.25))
    seconds = time.process_time() - began
    work = sum(s.work + (s.heat.iterations * s.pressure.size if s.heat else 0) for s in states)
    return states, work, seconds


@pytest.mark.parametrize("block", [2, 1])
def test_a_plane_gives_the_same_for_a_fraction(benchmark, block):
    shipped = pipeline.load_scene(SCENE)
    plane = replace(shipped, roughness=None, fidelity=replace(TIGHT, pixels_per_element=block))
    full = replace(plane, roughness=MeasuredRoughness(np.zeros(plane.pixels.shape)))
    ramp(plane)
    next(iter(simulate(full, 1.0, 1.0)))
    states, work, seconds = benchmark.pedantic(ramp, (plane,), rounds=5)
    others, more_work, more_seconds = ramp(full)
    ours, theirs = (run[-1].heat.rise_quantile for run in (states, others))
    print(
        f"\n{plane.grid.shape[0]} x 1 for {full.grid.shape}: {more_seconds / seconds:.0f} times "
        f"less time, {more_work / work:.0f} times less work; the rise is the same to "
        f"{np.abs(ours / theirs - 1).max():.0e}"
    )
    assert ours == pytest.approx(theirs, rel=1e-6)
    assert more_work / work > 100

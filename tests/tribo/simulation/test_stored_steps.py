"""Stored steps before the end: continued from the step before, within their stated accuracy."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.sweep.plan import run_point
from pipeline.sweep.stored_steps import StoredSteps
from pipeline.sweep.sweep import Point
from tests.tribo.simulation.test_moving_disk import LOAD, VELOCITY, scene_of
from tribo import Fidelity, measures, simulate
from tribo.contact import solve_contact
from tribo.simulation import heat
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.disk_positions import separation_at

ERROR = 0.02  # largest relative error of steps, as workflows/DATASET.md states it
GRIDS = {
    "one grid": {},
    "two grids": {"history_coarsening": 2},
    "loose": {"history_coarsening": 2, "contact_tolerance": 0.12},
}


def columns(scene, steps, load=LOAD):
    return run_point(scene, StoredSteps(steps, False), Point(load, VELOCITY, ())).columns


def from_scratch(scene, state):
    """Contact of a state solved without a guess to 1e-6, and its rises to 1e-6."""
    pressure = solve_contact(
        elastic_bodies(scene).solid,
        separation_at(scene, None) + state.wear_depth,
        state.normal_load / scene.pin.windows(scene.grid),
        hardness=scene.hardness,
        tolerance=1e-6,
    ).pressure
    tight = Fidelity(pixels_per_element=1, contact_tolerance=24e-6)
    state = replace(state, pressure=pressure, passing=())
    return pressure, heat(replace(scene, fidelity=tight), state, VELOCITY)


@pytest.mark.parametrize("surface", ["no lay", "across"])
@pytest.mark.parametrize("grids", GRIDS)
def test_a_step_has_the_contact_and_the_rises_that_are_solved_from_scratch(surface, grids):
    scene = scene_of(surface, **GRIDS[grids])
    course = columns(scene, "course")
    states = list(simulate(scene, LOAD, VELOCITY, requested=range(100)))[:-1]
    assert len(states) > 2
    for index, state in enumerate(states):
        pressure, temperature = from_scratch(scene, state)
        fraction = np.count_nonzero(pressure) / pressure.size
        assert course["contact_fraction"][index] == pytest.approx(fraction, rel=ERROR)
        assert course["mean_rise"][index] == pytest.approx(temperature.mean_rise, rel=ERROR)
        stated = temperature.rise_quantile[11:-1]
        assert course["rise_quantile"][index][11:-1] == pytest.approx(stated, rel=ERROR)
        assert measures(scene, state)["residual"] <= 2 * scene.contact_tolerance


@pytest.mark.parametrize("load", [LOAD, 280.0])  # at the end of a shared step, and between two
@pytest.mark.parametrize("grids", GRIDS)
def test_the_end_is_the_same_whichever_steps_are_stored(grids, load):
    scene = scene_of(**GRIDS[grids])
    course, end = columns(scene, "course", load), columns(scene, "end", load)
    for name in ("contact_fraction", "max_pressure", "wear_depth_max", "wear_volume"):
        assert course[name][-1] == end[name][-1]
    # At a load that is also a step of higher loads, positions have other first guesses.
    assert course["rise_quantile"][-1] == pytest.approx(end["rise_quantile"][-1], rel=2e-3)
    if load == 280.0:
        assert np.array_equal(course["rise_quantile"][-1], end["rise_quantile"][-1])


def test_load_area_and_wear_grow_from_step_to_step():
    course = columns(scene_of(history_coarsening=2, contact_tolerance=0.12), "course", 600.0)
    for name in ("normal_load", "contact_fraction", "contact_width", "wear_volume"):
        assert (np.diff(course[name]) > 0).all()
    assert (np.diff(course["wear_depth_max"]) > 0).all()

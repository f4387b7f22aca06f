"""Points, tasks and the computation of one point (pipeline/sweep/plan.py)."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline import load_scene, run_point
from pipeline.sweep import plan
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import choose_stored_steps
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.points import run_point as run_alone
from tests.helpers.scenes import STEEL
from tribo.simulation import RampCache, contact_ramp, disk_positions, heat
from tribo.simulation.requested_state import refine_step

SWEEP = tiny.sweep()


def same(first, second):
    """Assert that two results agree bit for bit; return whether their warnings agree."""
    assert first.columns.keys() == second.columns.keys()
    for name, values in (first.columns | first.fields).items():
        assert values.tobytes() == (second.columns | second.fields)[name].tobytes(), name
    return first.warnings == second.warnings


def test_a_step_of_a_ramp_is_the_end_of_the_point_at_its_load_except_with_larger_elements():
    """The first step of `first_try` has larger elements than the point at its load."""
    scene = load_scene("first_try").changed("sweep.steps", "course")
    course = run_point(scene, 750.0, 2.8).columns
    loads = course["normal_load"]
    first, second = (run_point(scene, float(load), 2.8).columns for load in loads[:2])
    for name in ("contact_fraction", "mean_pressure", "wear_depth_max"):
        np.testing.assert_array_equal(course[name][1], second[name][-1])
    assert course["contact_fraction"][0] / first["contact_fraction"][-1] > 1.1
    assert course["mean_pressure"][0] / first["mean_pressure"][-1] < 0.9


def test_a_point_has_the_surface_of_its_realization():
    sweep = tiny.sweep(case_table=surface_table((1, 2)))
    expected = run_alone(sweep, Point(600.0, 1.0, (("realization", 2),)))
    assert same(run_point(sweep, "600 N", "1 m/s", realization=2), expected)


WIDE = tribo.Grid((48, 16), (9e-6, 15e-6))
RAMP = tribo.Ramp(rate=150.0, reference_load=750.0, hold=1.0)
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0, 5.0]), np.array([0.0, 300.0, 250.0, 750.0]))
SMALLER = {"pixels_per_element": 2, "fewest_elements": 1000}
PHYSICS = {
    "plain": {},
    "no wear": {"wear": None},
    "measured load": {"loading": RECORD},
    "few elements and a hold": {"pixels": WIDE, "fidelity": SMALLER, "loading": RAMP},
    "ball": {
        "pin": tribo.Ball(8e-3, STEEL),
        "pixels": tribo.Grid((20, 20), (38e-6, 38e-6), (False, False)),
    },
}


@pytest.fixture(autouse=True)
def _few_positions(monkeypatch):
    """Average the temperature under a ball over only three positions of the disk."""
    monkeypatch.setattr(disk_positions, "MOST_POSITIONS", 3)


@pytest.mark.parametrize("physics", PHYSICS)
def test_a_point_on_a_trunk_equals_the_point_alone_bit_for_bit(physics):
    """250 N is a step of the shared ramp. The cache has any size, and loads come in any order."""
    sweep, single_results = tiny.sweep(steps="end", **PHYSICS[physics]), {}
    large, none = RampCache(2**28), RampCache(0)
    order = (250.0, 600.0, 625.0, 250.0)
    for load, ramp_cache in (*((load, large) for load in order), (600.0, none)):
        result = run_alone(sweep, Point(load, 1.0), ramp_cache)
        if load not in single_results:
            single_results[load] = run_point(sweep, load, 1.0)
        assert same(result, single_results[load])
        assert len(result.columns["time"]) == len(
            choose_stored_steps(sweep).select(sweep.scene, load)
        )
        assert all(np.isfinite(values).all() for values in result.columns.values())


@pytest.mark.parametrize("physics", sorted(PHYSICS.keys() - {"measured load"}))
def test_a_step_is_the_end_of_the_point_at_its_load(physics):
    parts = {"loading": tiny.sweep().scene.loading} | PHYSICS[physics]
    parts["loading"] = replace(parts["loading"], hold=0.0)
    sweep = tiny.sweep(steps="course", **parts)
    lower, higher = (
        plan.run_point(sweep.scene, choose_stored_steps(sweep), Point(load, 1.0))
        for load in (250.0, 600.0)
    )
    assert higher.columns["normal_load"].tolist() == [125.0, 250.0, 375.0, 500.0, 600.0]
    end = run_point(replace(sweep, steps="end"), 600.0, 1.0)
    # The end has further contacts and temperatures, with the disk at other positions.
    has_positions = sweep.scene.wears_by_strips
    of_positions = {"max_rise", "mean_rise", "rise_quantile", "pin_heat_share"}
    of_positions |= {"iterations", "residual"}
    for name, values in higher.columns.items():
        if not (has_positions and name in of_positions):
            assert values[1].tobytes() == lower.columns[name][-1].tobytes(), name
        assert values[-1].tobytes() == end.columns[name][-1].tobytes(), name
    assert same(replace(end, columns={}), replace(higher, columns={}))


@pytest.mark.parametrize(
    ("module", "function", "argument"), [(contact_ramp, refine_step, 3), (plan, heat, 1)]
)
def test_what_is_not_found_at_an_increment_costs_no_end(monkeypatch, module, function, argument):
    """Where the contact is not found, only the time and the path of the step are known."""

    def failing(*arguments):
        if arguments[argument].normal_load == 250.0:
            raise tribo.ConvergenceError("it did not converge", solution=None)
        return function(*arguments)

    undisturbed = run_point(SWEEP, 600.0, 1.0).columns
    monkeypatch.setattr(module, function.__name__, failing)
    columns = run_point(SWEEP, 600.0, 1.0).columns
    for name, values in columns.items():
        assert values[[0, 2, 3, 4]].tobytes() == undisturbed[name][[0, 2, 3, 4]].tobytes(), name
    assert np.isnan(columns["max_rise"][1])
    assert np.isnan(columns["wear_volume"][1]) == (module is contact_ramp)
    assert columns["normal_load"].tolist() == undisturbed["normal_load"].tolist()
    with pytest.raises(tribo.ConvergenceError, match="it did not converge"):
        run_point(SWEEP, 250.0, 1.0)


def test_fields_of_smaller_elements_are_means_over_those_of_the_scene():
    sweep = tiny.sweep(pixels=WIDE, fidelity=SMALLER)
    result = run_point(sweep, 250.0, 1.0)
    assert (result.state.pressure.shape, result.shape) == (WIDE.shape, (24, 8))
    blocks = result.state.heat.rise.reshape(24, 2, 8, 2)
    assert result.fields["rise"] == pytest.approx(blocks.mean(axis=(1, 3)))
    load = result.fields["pressure"].sum() * sweep.scene.grid.element_area
    assert load * sweep.scene.pin.windows(sweep.scene.grid) == pytest.approx(250.0)


STEPS = {
    "ramp": ({}, "course"),
    "hold": ({"loading": RAMP}, "end"),
    "shared contacts": (
        {"case_table": rows("oil", {"a": {}, "b": {"disk.thermal_conductivity": 30.0}})}, "end"
    ),
    "surfaces": ({"case_table": surface_table([1, 2])}, "course"),
    "one that wears": (
        {"case_table": rows("wear", {"some": {}, "none": {"wear": None}})}, "course"
    ),
    "one that is held": ({"case_table": rows("hold", {"a": {}, "b": {"loading": RAMP}})}, "end"),
}  # fmt: skip


@pytest.mark.parametrize("kind", STEPS)
def test_the_course_is_stored_of_what_wears_on_a_ramp_of_its_own(kind):
    changes, steps = STEPS[kind]
    assert choose_stored_steps(tiny.sweep(**changes)).steps == steps

"""Points, chains and the computation of one point (pipeline/sweep/plan.py)."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.store.schema import COLUMNS
from pipeline.sweep.model import Point
from pipeline.sweep.plan import chains, points, run_point, run_points
from pipeline.sweep.station_choice import choose_stations
from tests.helpers import tiny
from tests.helpers.scenes import STEEL
from tribo.simulation import disk_positions

SWEEP = tiny.sweep()


def same(first, second):
    """True if two results and the trunks that they hand on agree bit for bit."""
    assert first.columns.keys() == second.columns.keys()
    for name, values in (first.columns | first.fields).items():
        assert values.tobytes() == (second.columns | second.fields)[name].tobytes(), name
    assert first.warnings == second.warnings
    one, other = (result.trunk.ends[()] for result in (first, second))
    for load in one.keys() & other.keys():
        assert all(np.array_equal(one[load][name], other[load][name]) for name in one[load])
    return first.trunk.state.pressure.tobytes() == second.trunk.state.pressure.tobytes()


def test_chains_ascend_in_load_at_one_velocity():
    assert len(set(points(SWEEP))) == 9
    for chain in chains(reversed(points(SWEEP)), SWEEP):
        assert [point.load for point in chain] == list(tiny.LOADS)
        assert len({point.velocity for point in chain}) == 1


def test_independent_points_are_chains_of_their_own():
    alone = SWEEP.changed(independent=True)
    assert chains(points(alone), alone) == tuple((point,) for point in points(alone))


@pytest.mark.parametrize(("load", "count"), [(150.0, 1), (400.0, 3)])
def test_a_point_has_a_row_for_each_of_its_stations(load, count):
    result = run_point(SWEEP, load, 1.0)
    assert choose_stations(SWEEP).count(SWEEP.scene, load) == count
    assert {name: len(values) for name, values in result.columns.items()} == dict.fromkeys(
        COLUMNS, count
    )
    assert result.columns["normal_load"][-1] == load
    assert result.columns["rise_quantile"].shape == (count, len(tribo.QUANTILES))
    assert all(np.isfinite(values).all() for values in result.columns.values())


WIDE = tribo.Grid((48, 16), (9e-6, 15e-6))
RAMP = tribo.Ramp(rate=150.0, reference_load=750.0, hold=1.0, hold_steps=2)
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0, 5.0]), np.array([0.0, 300.0, 250.0, 750.0]))
SMALLER = {"pixels_per_element": 2, "history_coarsening": 2, "fewest_elements": 100}
PHYSICS = {
    "plain": {},
    "no wear": {"wear": None},
    "measured load": {"loading": RECORD},
    "few elements": {"pixels": WIDE, "fidelity": SMALLER, "loading": RAMP},
    "few elements and heat of the past": {
        "pixels": WIDE,
        "fidelity": SMALLER | {"heat_model": "history", "history_coarsening": 1},
        "loading": RAMP,
    },
    "heat of the past": {"fidelity": {"heat_model": "history"}, "loading": RAMP},
    "steps with a short end and heat of the past": {
        "fidelity": {"wear_scheme": "sdirk2", "heat_model": "history"},
        "wear": tribo.Wear(1e-14),
    },
    "explicit wear": {"fidelity": {"wear_scheme": "explicit"}},
    "as published": {
        "fidelity": {
            "kernel": "nearest-image",
            "contact_criterion": "pressure-change",
            "partition": "uniform",
        }
    },
    "ball": {
        "pin": tribo.Ball(8e-3, STEEL),
        "pixels": tribo.Grid((20, 20), (38e-6, 38e-6), (False, False)),
    },
}


@pytest.fixture(autouse=True)
def _few_positions(monkeypatch):
    """Of the disk under a ball, over which its temperature is a mean."""
    monkeypatch.setattr(disk_positions, "_MOST_POSITIONS", 3)


@pytest.mark.parametrize(
    ("physics", "steps"),
    [("plain", "loads"), *((one, "all") for one in PHYSICS)],
)
def test_a_point_on_a_trunk_equals_the_point_alone_bit_for_bit(physics, steps):
    """250 N is a step of the trunk, so that its end lies on another's."""
    sweep = tiny.sweep(steps=steps, **PHYSICS[physics])
    highest, trunk = run_point(sweep, 625.0, 1.0), None
    for load in (150.0, 250.0, 600.0):
        result = run_point(sweep, load, 1.0, trunk=trunk)
        assert same(result, run_point(sweep, load, 1.0))
        assert len(result.columns["time"]) == choose_stations(sweep).count(sweep.scene, load)
        assert all(np.isfinite(values).all() for values in result.columns.values())
        trunk = pickle.loads(pickle.dumps(result.trunk))
    assert same(highest, run_point(sweep, 625.0, 1.0, trunk=trunk))


@pytest.mark.parametrize(
    ("physics", "steps"),
    [
        *((name, "loads") for name in ("no wear", "few elements", "heat of the past", "ball")),
        *(("plain", steps) for steps in (3, "all")),
        ("steps with a short end and heat of the past", "all"),
    ],
)
def test_a_station_is_the_end_of_the_point_at_its_load_bit_for_bit(physics, steps):
    parts = PHYSICS[physics]
    if "loading" in parts:
        parts = {**parts, "loading": replace(parts["loading"], hold=0.0)}
    sweep = tiny.sweep(steps=steps, **parts)
    highest = run_point(sweep, 600.0, 1.0).columns
    for number, load in enumerate(highest["normal_load"]):
        lower = run_point(sweep, load, 1.0).columns
        assert len(lower["time"]) == number + 1
        for name, values in highest.items():
            assert values[: number + 1].tobytes() == lower[name].tobytes(), (name, load)


def test_a_load_that_failed_is_no_station():
    loading = tiny.DivergingRamp(150.0, 750.0, faulty_load=250.0)
    sweep = tiny.sweep(loading=loading)
    told = run_points(sweep, [Point(600.0, 1.0)], failed=[Point(250.0, 1.0)])[0]
    assert told.columns["normal_load"].tolist() == [150.0, 600.0]


def test_the_distance_slid_does_not_show_on_which_elements_the_lower_loads_were():
    """Contacts of few elements are computed once more on smaller ones, in steps of their own."""
    sweep = pipeline.load_scene("first_try")
    velocity = 3.8495  # at which the sum of the steps has another last bit than their whole
    trunk = None
    for load in sweep.plane.loads:
        result = run_point(sweep, load, velocity, trunk=trunk)
        trunk = result.trunk
    alone = run_point(sweep, load, velocity)
    distances = [one.columns["sliding_distance"].tobytes() for one in (result, alone)]
    assert distances[0] == distances[1]


def test_fields_of_smaller_elements_are_means_over_those_of_the_scene():
    sweep = tiny.sweep(pixels=WIDE, fidelity={"pixels_per_element": 2, "fewest_elements": 100})
    result = run_point(sweep, 250.0, 1.0)
    assert (result.state.pressure.shape, result.shape) == (WIDE.shape, (24, 8))
    blocks = result.state.heat.rise.reshape(24, 2, 8, 2)
    assert result.fields["rise"] == pytest.approx(blocks.mean(axis=(1, 3)))
    load = result.fields["pressure"].sum() * sweep.scene.grid.element_area
    assert load * sweep.scene.pin.patches(sweep.scene.grid) == pytest.approx(250.0)


def test_a_number_asks_for_so_many_stations_of_the_highest_load_even_in_time():
    for steps, loads in ((1, [250.0]), (2, [250.0, 375.0]), (9, [125.0, 250.0, 375.0, 500.0])):
        columns = run_point(tiny.sweep(steps=steps), 600.0, 1.0).columns
        assert columns["normal_load"].tolist() == [*loads, 600.0]


def test_the_moments_of_a_hold_are_stored_on_reaching_the_load_and_at_the_end():
    sweep = tiny.sweep(loading=RAMP)
    held = run_point(sweep, 250.0, 1.0).columns
    assert held["normal_load"].tolist() == [250.0, 250.0]
    assert held["time"].tolist() == [250 / 150, 250 / 150 + 1.0]
    every = run_point(sweep.changed(steps="all"), 250.0, 1.0).columns
    assert every["normal_load"].tolist()[-4:] == [125.0, 250.0, 250.0, 250.0]
    with pytest.raises(tribo.InputError, match="the load is held: a higher load does not pass"):
        tiny.sweep(loading=RAMP, steps="loads")


@pytest.mark.parametrize(("load", "other"), [(200.0, 600.0), (600.0, 150.0)])
def test_a_trunk_that_does_not_lead_to_the_load_is_left(load, other):
    """One of a higher load, and one of a load so low that its steps are smaller."""
    alone, trunk = run_point(SWEEP, load, 1.0), run_point(SWEEP, other, 1.0).trunk
    result = run_point(SWEEP, load, 1.0, trunk=trunk)
    for name, values in alone.columns.items():
        assert np.array_equal(result.columns[name], values, equal_nan=True)


def test_a_contact_at_the_edge_of_the_window_is_a_warning_of_the_point():
    lower, higher = (
        [warning.text for warning in run_point(SWEEP, load, 1.0).warnings]
        for load in (150.0, 600.0)
    )
    assert not any("edge" in text for text in lower)
    assert any("touches the window's x edge" in text for text in higher)

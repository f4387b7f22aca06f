"""Points, chains and the computation of one point (pipeline/sweep/plan.py)."""

import pickle

import numpy as np
import pytest

import tribo
from pipeline.store.schema import COLUMNS
from pipeline.sweep.model import Point
from pipeline.sweep.plan import chains, points, run_point, step_count
from tests.helpers import tiny
from tests.helpers.scenes import STEEL

SWEEP = tiny.sweep()


def same(first, second):
    """True if two results and the trunks that they hand on agree bit for bit."""
    assert first.columns.keys() == second.columns.keys()
    assert all(
        first.columns[name].tobytes() == second.columns[name].tobytes() for name in first.columns
    )
    assert all(
        first.fields[name].tobytes() == second.fields[name].tobytes() for name in first.fields
    )
    assert first.warnings == second.warnings
    return same_trunks(first.trunk, second.trunk)


def same_trunks(first, second):
    records = [trunk.records.get((), ()) for trunk in (first, second)]
    for one, other in zip(*records, strict=True):
        assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)
    return first.state.pressure.tobytes() == second.state.pressure.tobytes()


def test_every_load_meets_every_velocity_once():
    assert len(points(SWEEP)) == len(set(points(SWEEP))) == 9
    assert Point(250.0, 1.5) in points(SWEEP)


def test_chains_ascend_in_load_at_one_velocity():
    for chain in chains(reversed(points(SWEEP)), SWEEP):
        assert [point.load for point in chain] == list(tiny.LOADS)
        assert len({point.velocity for point in chain}) == 1


def test_independent_points_are_chains_of_their_own():
    alone = SWEEP.changed(independent=True)
    assert chains(points(alone), alone) == tuple((point,) for point in points(alone))


@pytest.mark.parametrize(("load", "count"), [(100.0, 2), (150.0, 3), (250.0, 2), (600.0, 5)])
def test_a_point_has_a_row_for_each_of_its_steps(load, count):
    result = run_point(SWEEP, load, 1.0)
    assert step_count(SWEEP.scene, load) == count
    assert {name: len(values) for name, values in result.columns.items()} == dict.fromkeys(
        COLUMNS, count
    )
    assert result.columns["normal_load"][-1] == load
    assert result.columns["rise_quantile"].shape == (count, len(tribo.QUANTILES))


WIDE = tribo.Grid((48, 16), (9e-6, 15e-6))
RAMP = tribo.Ramp(rate=150.0, reference_load=750.0, hold=1.0, hold_steps=2)
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0, 5.0]), np.array([0.0, 300.0, 250.0, 750.0]))
SMALLER = {"pixels_per_element": 2, "history_coarsening": 2, "fewest_elements": 100}
SECOND_ORDER, HEAVY = {"wear_scheme": "sdirk2"}, tribo.Wear(1e-14)
PHYSICS = {
    "plain": {},
    "no wear": {"wear": None},
    "measured load": {"loading": RECORD},
    "coarse history and hold": {
        "pixels": WIDE,
        "fidelity": {"history_coarsening": 2},
        "loading": RAMP,
    },
    "few elements": {"pixels": WIDE, "fidelity": SMALLER, "loading": RAMP},
    "few elements and heat of the past": {
        "pixels": WIDE,
        "fidelity": SMALLER | {"heat_model": "history", "history_coarsening": 1},
        "loading": RAMP,
    },
    "heat of the past": {"fidelity": {"heat_model": "history"}, "loading": RAMP},
    "steps with a short end": {"fidelity": SECOND_ORDER, "wear": HEAVY},
    "steps with a short end and heat of the past": {
        "fidelity": SECOND_ORDER | {"heat_model": "history"},
        "wear": HEAVY,
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
        "pixels": tribo.Grid((32, 32), (24e-6, 24e-6), (False, False)),
    },
}


@pytest.mark.parametrize(("physics", "interval"), [("plain", 0), *((name, 2) for name in PHYSICS)])
def test_a_point_on_a_trunk_equals_the_point_alone_bit_for_bit(physics, interval):
    """250 N and 500 N are stations, so that the end of the one lies on the trunk of the other."""
    sweep = tiny.sweep(temperature_interval=interval, **PHYSICS[physics])
    highest, trunk = run_point(sweep, 625.0, 1.0), None
    for load in (100.0, 150.0, 250.0, 500.0, 600.0):
        result = run_point(sweep, load, 1.0, trunk=trunk)
        assert same(result, run_point(sweep, load, 1.0))
        assert len(result.columns["time"]) == step_count(sweep.scene, load)
        assert np.isfinite(result.columns["max_rise"][-1])
        trunk = pickle.loads(pickle.dumps(result.trunk))
        assert same(highest, run_point(sweep, 625.0, 1.0, trunk=trunk))


def test_fields_of_smaller_elements_are_means_over_those_of_the_scene():
    sweep = tiny.sweep(pixels=WIDE, fidelity={"pixels_per_element": 2, "fewest_elements": 100})
    result = run_point(sweep, 250.0, 1.0)
    assert (result.state.pressure.shape, result.shape) == (WIDE.shape, (24, 8))
    blocks = result.state.heat.rise.reshape(24, 2, 8, 2)
    assert result.fields["rise"] == pytest.approx(blocks.mean(axis=(1, 3)))
    load = result.fields["pressure"].sum() * sweep.scene.grid.element_area
    assert load * sweep.scene.pin.patches(sweep.scene.grid) == pytest.approx(250.0)


def test_temperatures_on_the_way_are_where_they_are_asked_for():
    for interval in (0, 1, 2):
        rise = run_point(tiny.sweep(temperature_interval=interval), 700.0, 1.0).columns["max_rise"]
        asked = [bool(interval) and step % interval == 0 for step in range(1, len(rise))]
        np.testing.assert_array_equal(np.isfinite(rise), [*asked, True])


def test_the_steps_of_a_hold_belong_to_the_point_alone():
    sweep = tiny.sweep(loading=RAMP)
    held, higher = run_point(sweep, 250.0, 1.0), run_point(sweep, 300.0, 1.0)
    np.testing.assert_array_equal(held.columns["normal_load"], [125.0, 250.0, 250.0, 250.0])
    np.testing.assert_array_equal(higher.columns["normal_load"], [125.0, 250.0, *[300.0] * 3])
    assert len(held.trunk.records[()]) == len(higher.trunk.records[()]) == 2


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

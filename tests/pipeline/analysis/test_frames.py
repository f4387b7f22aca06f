"""Tests of a laboratory stand beside what is computed at their own conditions."""

import pytest

import pipeline
from pipeline.analysis.laboratory import agreement, compared
from pipeline.sweep.measurement import Measurement
from tests.helpers import synthetic
from tests.helpers.sweeps import with_fields


def sweep(*tests):
    transition = tuple(Measurement(**test) for test in tests if "outcome" not in test)
    tested = tuple(Measurement(**test) for test in tests if "outcome" in test)
    return synthetic.sweep(measured=transition, tested=tested)


def rig(outcome, velocity, load=600.0, **own):
    place = {"normal_load": load, "velocity": velocity, "friction": None}
    return place | ({"outcome": outcome} if outcome else {}) | own


CRITICAL = pipeline.boundary(synthetic.sweep())["critical_velocity"].sel(load=600).item()


@pytest.mark.parametrize(
    ("case", "computed", "agrees"),
    [
        (rig("mild", 0.7 * CRITICAL), "mild", "yes"),
        (rig("severe", 0.7 * CRITICAL), "mild", "no"),
        (rig("severe", 1.001 * CRITICAL), "not decided", "not decided"),
        (rig("mild", 0.7 * CRITICAL, bulk_temperature=400.0), "severe", "no"),
        (rig(None, 1.5 * CRITICAL), f"at {CRITICAL:.3g} m/s", "no"),
        (rig("mild", 1.0, load=9e3), "not known", "not known"),
    ],
)
def test_a_test_agrees_beyond_the_error_at_its_own_conditions(case, computed, agrees):
    (row,) = compared(pipeline.results(sweep(case))).to_dict("records")
    assert (row["computed"], row["agrees"]) == (computed, agrees)


@pytest.mark.parametrize("velocity", [0.6 * CRITICAL, CRITICAL, 1.46 * CRITICAL, 2.2 * CRITICAL])
def test_nothing_agrees_where_the_error_is_not_known(velocity):
    unknown = with_fields(sweep(rig(None, velocity)), preset=None)
    (row,) = compared(pipeline.results(unknown)).to_dict("records")
    assert row["agrees"] == "not decided"
    assert (
        agreement(compared(pipeline.results(unknown))) == "Agreement with the tests: 1 not decided."
    )


def test_the_tests_that_agree_are_counted():
    table = compared(
        pipeline.results(sweep(rig("mild", 0.7 * CRITICAL), rig("mild", 1.3 * CRITICAL)))
    )
    assert agreement(table) == "Agreement with the tests: 1 yes, 1 no."
    assert compared(pipeline.results(sweep())) is None


def test_other_conditions_for_the_plane_leave_the_tests_at_their_own():
    ds = sweep(rig("severe", 0.7 * CRITICAL, bulk_temperature=400.0), rig("mild", 0.7 * CRITICAL))
    kept = ["friction", "bulk temperature [°C]", "computed", "agrees"]
    there = compared(pipeline.results(pipeline.at(ds, friction=0.15, bulk_temperature="60 degC")))
    assert there[kept].equals(compared(pipeline.results(ds))[kept])
    warm, cold = rig("mild", 1.0, bulk_temperature=333.15), rig("mild", 1.2)
    axes = pipeline.plot(pipeline.at(sweep(warm, cold), bulk_temperature="60 degC")).axes[0]
    drawn = {line.get_gid(): line for line in axes.lines}
    assert drawn["tested-mild"].get_xdata().tolist() == [1.0]
    assert drawn["tested-mild-elsewhere"].get_xdata().tolist() == [1.2]
    assert drawn["tested-mild-elsewhere"].get_alpha() < 0.5

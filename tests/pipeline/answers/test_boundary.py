"""The boundary (pipeline.boundary) of sweeps whose boundary is known in closed form."""

import numpy as np
import pytest

from pipeline import boundary
from pipeline.answers.answer_frames import boundary_frame
from pipeline.answers.field import Field
from pipeline.answers.results import sweep_of
from pipeline.frames import lines_of
from tests.helpers import synthetic
from tests.helpers.entries import bare_test
from tests.helpers.synthetic import LOADS, VELOCITIES
from tests.pipeline.test_film import filmed
from tribo.simulation.lubrication import find_lubrication

TRANSITION, MILD, SEVERE, UNKNOWN = 0, 1, 2, 3


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep()


def curved(load, velocity, quantile=1.0):
    """Rise [K] like that of a real sweep: not quite a power law of load or velocity."""
    return synthetic.rise(load, velocity, quantile) / (1 + 0.1 * np.sqrt(velocity) + load / 5000)


@pytest.mark.parametrize("share", [0.1, 0.0])  # 0 is the maximum temperature
def test_boundary_of_a_power_law_is_found_to_rounding(sweep, share):
    crossings = boundary(sweep, critical_area_fraction=share)
    limit = synthetic.limit()
    expected = synthetic.critical_velocity(LOADS, limit, share)
    np.testing.assert_allclose(crossings["critical_velocity"], expected, rtol=1e-13)
    expected = synthetic.critical_load(VELOCITIES, limit, share)
    inside = (expected >= LOADS[0]) & (expected <= LOADS[-1])
    assert inside.sum() == {0.1: 10, 0.0: 9}[share]
    np.testing.assert_allclose(crossings["critical_load"][inside], expected[inside], rtol=1e-13)
    assert np.isnan(crossings["critical_load"][~inside]).all()


def test_boundary_of_a_bent_rise_is_found_between_points_every_quarter_metre_per_second():
    velocities, loads = np.linspace(1.05, 3.6, 5), np.linspace(210.0, 740.0, 5)
    # measured 4.1e-6 and 3.2e-5; straight lines give 2.3e-3 and 3.2e-3
    for name, ds, points, tolerance in (
        ("velocity", synthetic.sweep((400.0,), rise=curved), (400.0, velocities), 8e-6),
        ("load", synthetic.sweep(velocities=(2.0,), rise=curved), (loads, 2.0), 6e-5),
    ):
        load, velocity = np.broadcast_arrays(*points)
        critical = (298.15 + 0.1 * curved(load, velocity, 0.9)).tolist()
        (line,) = boundary(ds, critical_temperature=critical)[f"critical_{name}"].values.T
        expected = velocities if name == "velocity" else loads
        np.testing.assert_allclose(line, expected, rtol=tolerance)


def test_the_boundary_is_nan_where_the_sweep_does_not_cross_it(sweep):
    for conditions in ({"critical_temperature": 3000.0}, {"friction": 0}):
        cold = boundary(sweep, **conditions)
        assert np.isnan(cold["critical_velocity"]).all()
        assert (cold["outcome_along_velocity"] == MILD).all()
        assert (cold["outcome_along_load"] == MILD).all()
    hot = boundary(sweep, critical_temperature=300.0)
    assert np.isnan(hot["critical_load"]).all()
    assert (hot["outcome_along_load"] == SEVERE).all()
    crossings = boundary(sweep)
    assert (crossings["outcome_along_velocity"] == TRANSITION).all()
    assert (
        crossings["outcome_along_load"].values.tolist()
        == [MILD] * 3 + [TRANSITION] * 10 + [SEVERE] * 2
    )


def test_only_the_last_step_counts():
    ds = synthetic.sweep(interval=1)
    earlier = ds["step"] < 0
    hot = ds.assign(rise_quantile=ds["rise_quantile"].where(~earlier, 1e4))
    assert boundary(hot).equals(boundary(synthetic.sweep()))
    unfinished = ds.assign(rise_quantile=ds["rise_quantile"].where(earlier))
    assert (boundary(unfinished)["outcome_along_velocity"] == UNKNOWN).all()


def test_each_crossing_has_its_film_parameter_where_the_scene_has_an_oil():
    plain, oiled = synthetic.sweep(), synthetic.sweep(oil=synthetic.OIL)
    assert not [name for name in boundary(plain) if name.startswith("film")]
    crossings = boundary(oiled, bulk_temperature=320.0, friction=[0.09, 0.1])
    film_parameter = find_lubrication(
        sweep_of(oiled).scene, sweep_of(oiled).lubricant
    ).film_parameter
    for friction in (0.09, 0.1):
        part = crossings.sel(friction=friction)
        expected = film_parameter(part["load"], part["critical_velocity"], 320.0)
        np.testing.assert_array_equal(part["film_parameter_at_load"], expected)
        expected = film_parameter(part["critical_load"], part["velocity"], 320.0)
        np.testing.assert_array_equal(part["film_parameter_at_velocity"], expected)
    assert crossings["film_parameter_at_load"].notnull().any()


def test_a_table_says_on_which_side_of_the_sweep_a_value_lies():
    """At 10 times the limit all is mild, at a tenth severe; a film hides the rest."""
    for factor, side in ((10.0, "above 4"), (0.1, "below 0.5")):
        critical = 298.15 + factor * 120.0
        frame = boundary_frame(boundary(synthetic.sweep(tests=()), critical_temperature=critical))
        columns = ["mild up to [m/s]", "computed [m/s]", "severe from [m/s]"]
        assert (frame[columns] == side).all(axis=None)
    frame = boundary_frame(boundary(filmed()))
    assert frame["severe from [m/s]"].tolist()[:4] == ["outside"] * 4
    for conditions in ({}, {"friction": [0.09, 0.1]}):
        frame = boundary_frame(boundary(filmed(), **conditions))
        assert all(len(line) <= 80 for line in lines_of(frame))


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_the_line_with_tests_is_where_half_of_the_runs_are_severe(share):
    """Transitions at a share of the limit move the line with tests, but not the computed one."""
    plain, limit = synthetic.sweep(tests=()), synthetic.limit()
    tests = tuple(
        bare_test(load, float(synthetic.critical_velocity(load, share * limit)))
        for load in (200.0, 400.0, 600.0)
    )
    answer = boundary(synthetic.sweep(tests=tests))
    np.testing.assert_array_equal(answer["critical_velocity"], boundary(plain)["critical_velocity"])
    ratio = (answer["critical_velocity_p50"] / answer["critical_velocity"]).dropna("load")
    assert len(ratio) >= 11
    assert ratio.values == pytest.approx(share ** (1 / 0.7), rel=0.04)
    mild, severe = (answer[f"{verdict}_velocity"].values for verdict in ("mild", "severe"))
    assert np.all(mild[2:-2] < answer["critical_velocity_p50"].values[2:-2])
    assert np.nanmax(severe / answer["critical_velocity_p50"]) < 1.3


def test_rows_by_velocity_have_the_critical_load_and_rows_by_load_the_critical_velocity(sweep):
    by_load, by_velocity = (boundary_frame(boundary(sweep), by) for by in ("load", "velocity"))
    assert [*by_load][:2] == ["load [N]", "mild up to [m/s]"]
    assert [*by_velocity][:3] == ["velocity [m/s]", "mild up to [N]", "computed [N]"]
    assert len(by_velocity) == len(VELOCITIES)


def test_wear_that_is_mild_again_at_a_higher_velocity_has_its_boundary_at_the_lower_crossing():
    crossings = boundary(synthetic.sweep(rise=synthetic.falling, tests=()))
    np.testing.assert_allclose(crossings["critical_velocity"], 1.1, rtol=1e-3)
    assert (crossings["outcome_along_velocity"] == TRANSITION).all()


@pytest.mark.parametrize(("exponent", "slant"), [(-0.5, 0.0), (1.2, 1.2), (2.5, 2.0)])
def test_rises_are_interpolated_along_lines_of_equal_rise_up_to_a_slant(exponent, slant):
    loads, velocities = np.array([200.0, 300.0, 400.0]), 2.0 ** np.arange(5)
    field = Field(loads, velocities, exponent * np.log(loads)[:, None] + np.log(velocities))
    along = field.at(np.array([250.0]), np.array([4.0])).row_velocities[:, 0]
    np.testing.assert_allclose(along, 4.0 * (250.0 / loads) ** slant)

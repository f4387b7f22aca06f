"""The transition boundary (pipeline/analysis/boundary.py), on sweeps with a known one."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.at import at
from pipeline.analysis.boundary import boundary
from pipeline.analysis.words import boundary_lines, next_run_line
from pipeline.store.schema import PENDING
from pipeline.sweep.surface import find_lubrication
from tests.helpers import synthetic
from tests.helpers.synthetic import LOADS, VELOCITIES

CROSSES, MILD, SEVERE, UNKNOWN = range(4)


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep()


def curved(load, velocity, quantile=1.0):
    """Rise [K] like that of a real sweep: not quite a power law of load or velocity."""
    return synthetic.rise(load, velocity, quantile) / (1 + 0.1 * np.sqrt(velocity) + load / 5000)


@pytest.mark.parametrize("share", [0.1, 0.0])  # 0 is the maximum temperature
def test_boundary_of_a_power_law_is_found_to_rounding(sweep, share):
    crossings = boundary(at(sweep, share=share))
    limit = synthetic.limit()
    expected = synthetic.critical_velocity(LOADS, limit, share)
    np.testing.assert_allclose(crossings["critical_velocity"], expected, rtol=1e-13)
    expected = synthetic.critical_load(VELOCITIES, limit, share)
    inside = (expected >= LOADS[0]) & (expected <= LOADS[-1])
    assert inside.sum() == {0.1: 10, 0.0: 9}[share]
    np.testing.assert_allclose(crossings["critical_load"][inside], expected[inside], rtol=1e-13)
    assert np.isnan(crossings["critical_load"][~inside]).all()


def test_boundary_of_a_bent_rise_is_found_between_points_every_quarter_metre_per_second():
    ds = synthetic.sweep(rise=curved)

    def missed(name, **place):
        """Relative error of a computed boundary, if the true one is at this load and velocity."""
        critical = 298.15 + 0.1 * curved(*place.values(), 0.9)
        crossings = boundary(at(ds, critical_temperature=critical))[f"critical_{name}"]
        (other,) = (axis for axis in place if axis != name)
        return float(crossings.sel({other: place[other]})) / place[name] - 1

    error = [missed("velocity", load=400.0, velocity=v) for v in np.linspace(1.05, 3.6, 5)]
    assert np.abs(error).max() < 8e-6  # measured 4.1e-6; straight lines give 2.3e-3
    error = [missed("load", load=F, velocity=2.0) for F in np.linspace(210.0, 740.0, 5)]
    assert np.abs(error).max() < 6e-5  # measured 3.2e-5; straight lines give 3.2e-3


def test_nan_where_the_sweep_does_not_cross(sweep):
    for conditions in ({"critical_temperature": 3000.0}, {"friction": 0}):
        cold = boundary(at(sweep, **conditions))
        assert np.isnan(cold["critical_velocity"]).all()
        assert (cold["outcome_at_load"] == MILD).all()
        assert (cold["outcome_at_velocity"] == MILD).all()
    hot = boundary(at(sweep, critical_temperature=300.0))
    assert np.isnan(hot["critical_load"]).all()
    assert (hot["outcome_at_velocity"] == SEVERE).all()
    crossings = boundary(sweep)
    assert (crossings["outcome_at_load"] == CROSSES).all()
    assert (
        crossings["outcome_at_velocity"].values.tolist()
        == [MILD] * 3 + [CROSSES] * 10 + [SEVERE] * 2
    )


@pytest.mark.parametrize("kept", [0.3, 0.6])
def test_the_band_of_a_sweep_that_is_half_done_holds_the_boundary_of_the_whole(kept):
    chance = np.random.default_rng(4)
    whole = synthetic.sweep(
        [200.0, 400.0, 600.0, 750.0], [0.5, 1.0, 1.5, 2.0, 3.0, 4.0], rise=curved,
        model_scatter=0.0, measured=(),
    )  # fmt: skip
    critical, told = boundary(whole)["critical_velocity"], 0
    one_point = (whole["load"] != 600.0).values[:, None] | (whole["velocity"] == 4.0).values
    for is_done in (one_point, *(chance.random((6, *whole["status"].shape)) < kept)):
        found = boundary(whole.assign(status=whole["status"].where(is_done, PENDING)))
        assert found.attrs["missing_points"] == (~is_done).sum()
        assert not (found["mild_below"] > critical).any()
        assert not (found["severe_above"] < critical).any()
        told += int(np.isfinite(found["mild_below"]).sum())
    assert told > 5  # known ends of the band, of 28


def test_only_the_last_step_counts():
    ds = synthetic.sweep(interval=1)
    earlier = ds["step"] < 0
    hot = ds.assign(rise_quantile=ds["rise_quantile"].where(~earlier, 1e4))
    assert boundary(hot).equals(boundary(synthetic.sweep()))
    unfinished = ds.assign(rise_quantile=ds["rise_quantile"].where(earlier))
    assert (boundary(unfinished)["outcome_at_load"] == UNKNOWN).all()


def test_decisive_temperature_is_that_of_the_closed_form(sweep):
    judged = at(sweep, friction=0.2, bulk_temperature=310.0, share=0.05)
    places = {"load": LOADS[::4], "velocity": VELOCITIES[[0, 7, 14]]}
    found = pipeline.margin(judged, places)
    rise = synthetic.rise(places["load"], places["velocity"], 0.95)
    expected = 310.0 + 0.2 * rise - 273.15
    np.testing.assert_allclose(found["decisive temperature [°C]"], expected, rtol=1e-12)


def test_each_crossing_has_its_film_parameter_where_the_scene_has_an_oil():
    plain, oiled = synthetic.sweep(), synthetic.sweep(oil=synthetic.OIL)
    assert not [name for name in boundary(plain) if name.startswith("film")]
    crossings = boundary(at(oiled, bulk_temperature=320.0, friction=[0.09, 0.1]))
    of = find_lubrication(pipeline.results(oiled).sweep).film_parameter
    for friction in (0.09, 0.1):
        part = crossings.sel({"friction.coefficient": friction})
        expected = of(part["load"], part["critical_velocity"], 320.0)
        np.testing.assert_array_equal(part["film_parameter_at_load"], expected)
        expected = of(part["critical_load"], part["velocity"], 320.0)
        np.testing.assert_array_equal(part["film_parameter_at_velocity"], expected)
    assert crossings["film_parameter_at_load"].notnull().any()


@pytest.mark.parametrize(("friction", "side"), [(0.0, "mild"), (1e6, "severe")])
def test_a_run_that_is_mild_or_severe_at_all_velocities_is_said_to_be_so(friction, side):
    said = next_run_line(boundary(pipeline.at(synthetic.sweep(), friction=friction)))
    assert said == f"the next run is {side} throughout at 200 N; {side} throughout at 750 N"


def test_a_boundary_over_surfaces_says_that_the_median_is_not_the_onset(sweep):
    said = "the median is not the onset: the hottest patch under the pin scuffs first"
    several = xr.concat([sweep, sweep], "realization", combine_attrs="override")
    assert [boundary_lines(boundary(ds)).count(said) for ds in (sweep, several)] == [0, 1]

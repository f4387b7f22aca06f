"""The search of the boundary: few points, all crossings, and the same points after a kill."""

import numpy as np
import pytest

import pipeline
from pipeline.run.line_search import Line, places_along
from pipeline.run.plane_search import next_points
from pipeline.store.schema import DONE, LEFT_OUT, PENDING
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny

LOADS = tuple(np.geomspace(100.0, 800.0, 9).round(1).tolist())
VELOCITIES = tuple(np.geomspace(0.25, 8.0, 21).round(3).tolist())
COARSE = 0.3  # leaves loads out, although the small contact differs by chance from load to load


def plane(**changes):
    return tiny.sweep(**{"loads": LOADS, "velocities": VELOCITIES} | changes)


def searched(sweep, path, tolerance=0.01, **more):
    return pipeline.run_sweep(sweep, path, workers=1, boundary_only=tolerance, **more)


def done(path):
    return pipeline.open_sweep(path)["status"].values == DONE


def off(path, whole):
    """Largest relative difference of the critical velocities of two stores."""
    here, there = (pipeline.boundary(one)["critical_velocity"].values for one in (path, whole))
    assert np.array_equal(np.isnan(here), np.isnan(there))
    return np.nanmax(np.abs(here / there - 1))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.zarr"
    pipeline.run_sweep(plane(), path, workers=2)
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "small.zarr"
    outcome = searched(plane(), path)
    assert outcome.total == len(LOADS) * len(VELOCITIES)
    assert outcome.computed == outcome.done <= 30
    return path


def test_the_boundary_is_that_of_the_whole_plane_within_the_tolerance(small, whole):
    assert off(small, whole) < 0.01


def test_a_larger_tolerance_takes_fewer_points(small, tmp_path, whole):
    outcome = searched(plane(), tmp_path / "coarse.zarr", COARSE)
    assert outcome.done < done(small).sum()
    assert off(tmp_path / "coarse.zarr", whole) < COARSE


def test_no_answer_complains_of_points_left_out(small):
    ds = pipeline.open_sweep(small)
    assert pipeline.boundary(ds).attrs["missing_points"] == 0
    assert np.isfinite(pipeline.boundary(ds)["critical_velocity"]).all()
    assert np.array_equal(ds["asked"] == LEFT_OUT, ds["status"] == PENDING)
    state = pipeline.summary(small)
    assert state.left_out == state.pending == state.total - state.done


def test_the_stated_error_covers_loads_left_out(tmp_path, whole):
    path = tmp_path / "coarse.zarr"
    searched(plane(), path, COARSE)
    critical = pipeline.boundary(whole)["critical_velocity"]
    left_out = [load for load, row in zip(LOADS, done(path), strict=True) if not row.any()]
    assert left_out
    for load in left_out:
        here = pipeline.margin(path, load, critical.sel(load=load).item())
        assert abs(here.distance) < here.error.interpolation


def test_a_second_search_computes_nothing(small):
    assert searched(plane(), small).computed == 0


def test_a_run_without_the_option_completes_the_plane(tmp_path, whole):
    path = tmp_path / "plane.zarr"
    few = plane(loads=LOADS[3:5])
    found = searched(few, path).computed
    outcome = pipeline.run_sweep(few, path, workers=2)
    assert outcome.computed == outcome.total - found
    assert off(path, pipeline.open_sweep(whole).sel(load=list(few.loads))) == 0
    assert pipeline.summary(path).left_out == 0
    assert searched(few, path).computed == 0
    assert pipeline.summary(path).left_out == 0  # all are done


def test_a_load_whose_points_fail_is_given_up_and_the_search_goes_round_it(tmp_path, whole):
    path, ramp = tmp_path / "failed.zarr", plane().scene.loading
    diverging = tiny.DivergingRamp(ramp.rate, ramp.reference_load, faulty_load=LOADS[4])
    outcome = searched(plane(loading=diverging), path)
    assert [point.load for point in outcome.failed] == [LOADS[4]] * 3
    again = searched(plane(loading=diverging), path)
    assert (again.computed, len(again.failed)) == (0, 3)
    critical = pipeline.boundary(path)["critical_velocity"]
    assert np.isfinite(critical).sum() == len(LOADS) - 1
    assert searched(plane(), path, retry_failed=True).failed == ()
    assert off(path, whole) < 0.01


class KilledError(Exception):
    """Stands for a kill, which leaves the store as it is."""


@pytest.mark.parametrize("count", [1, 3, 7, 12])
def test_a_search_that_was_stopped_ends_with_the_same_points(tmp_path, small, count):
    def stop(progress):
        if progress.done >= count:
            raise KilledError

    path = tmp_path / "stopped.zarr"
    with pytest.raises(KilledError):
        searched(plane(), path, progress=stop)
    assert count <= done(path).sum() < done(small).sum()
    searched(plane(), path)
    assert np.array_equal(done(path), done(small))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_planes_of_few_loads_and_velocities(tmp_path, count):
    sweep = plane(loads=LOADS[:count], velocities=VELOCITIES[:: 20 // count][:count])
    outcome = searched(sweep, tmp_path / "few.zarr")
    assert 0 < outcome.done <= count**2
    pipeline.boundary(tmp_path / "few.zarr")


def test_velocity_0_is_left_out(tmp_path):
    searched(plane(velocities=(0.0, 0.5, 1.0, 2.0)), tmp_path / "rest.zarr")
    assert not done(tmp_path / "rest.zarr")[:, 0].any()


def test_each_surface_has_its_own_boundary(tmp_path):
    sweep = plane(variants=surfaces((1, 2)), loads=LOADS[:5])
    for name, options in (("searched", {"boundary_only": 0.01}), ("whole", {})):
        pipeline.run_sweep(sweep, tmp_path / name, workers=2, **options)
    assert off(tmp_path / "searched", tmp_path / "whole") < 0.01


# Every crossing, on closed forms of ln(rise/limit) at ten loads


X = np.log(np.linspace(0.25, 6.0, 40))


def heat(load, x, generator):
    """Return ln(rise/limit) at friction 1: rising, bent, and a little rough, as a contact's."""
    slope, bend, level = generator.uniform([0.4, -0.06, -0.6], [0.9, 0.06, 0.6])
    middle = np.log(1.5)
    waves = sum(0.001 * np.sin(k * 9.0 * x + generator.uniform(0, 7)) for k in (1, 2))
    return level + 0.58 * load + slope * (x - middle) + bend * (x - middle) ** 2 + waves


def friction(generator, turns):
    """Return ln(µ) over ln(velocity), with bends at random velocities; 0 without turns."""
    if not turns:
        return lambda x: np.zeros_like(x)
    nodes = np.sort(generator.uniform(X[0], X[-1], turns + 1))
    values = np.cumsum(generator.uniform(0.4, 1.5, turns + 1) * (-1.0) ** np.arange(turns + 1))
    return lambda x: np.interp(x, nodes, values - values.mean())


def touches(y):
    """Return True if a turn of y is so near to 0 that roughness decides about two crossings."""
    is_turn = np.diff(np.sign(np.diff(y))) != 0
    return bool(np.any(np.abs(y[1:-1][is_turn]) < 0.005))


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_every_crossing_is_found(turns):
    loads, count, asked = np.log(np.geomspace(0.5, 2.0, 10)), 0, 0
    fine = places_along(X)
    for seed in range(10):
        mu = friction(generator := np.random.default_rng([turns, seed]), turns)
        shape = generator.integers(2**31)
        truth = [heat(load, X, np.random.default_rng(shape)) + mu(X) for load in loads]
        y = np.full((len(loads), len(X)), np.nan)
        while todo := next_points(loads, [Line(X, row, mu(fine)) for row in y], 0.01):
            for load, velocity in todo:
                assert np.isnan(y[load, velocity])  # nothing is computed twice
                y[load, velocity] = truth[load][velocity]
        asked += np.isfinite(y).sum()
        for number in np.flatnonzero(np.isfinite(y).any(axis=1)):
            if touches(heat(loads[number], fine, np.random.default_rng(shape)) + mu(fine)):
                continue
            whole = Line(X, truth[number], mu(fine)).crossings()
            found = Line(X, y[number], mu(fine)).crossings()
            assert len(found) == len(whole)
            np.testing.assert_allclose(found, whole, atol=0.005)
            count += len(whole)
    assert count > 40
    assert asked < 10 * y.size * (0.1 + 0.1 * turns)


@pytest.mark.slow
def test_of_the_shipped_diagram_few_points_give_the_boundary_and_the_agreement(tmp_path):
    sweep = pipeline.load_scene("irg_transition", "standard", {"sweep.fields": False})
    outcome = pipeline.run_sweep(sweep, tmp_path / "small.zarr", boundary_only=0.01)
    assert (outcome.total, outcome.done <= 32) == (228, True)
    pipeline.run_sweep(sweep, tmp_path / "whole.zarr", source=tmp_path / "small.zarr")
    assert off(tmp_path / "small.zarr", tmp_path / "whole.zarr") < 0.005
    small, whole = (pipeline.infer(tmp_path / f"{name}.zarr") for name in ("small", "whole"))
    assert small.temperature == whole.temperature

"""A run with an accuracy goal computes until the error of the boundary is small enough."""

import json
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.answers.error import PARTS
from pipeline.progress import silent
from pipeline.run import goal
from pipeline.run.goal import GoalOutcome, GoalPlan, reason_surface_is_fixed
from pipeline.run.search import PointIndex
from pipeline.store.schema import DONE, NOT_NEEDED
from tests.helpers.kept import assert_as_kept
from tribo import InputError

# first_try on fewer elements: the same search in a quarter of the time
SMALL = {
    "without": ["tests"],
    "window.pixels": [96, 48],
    "window.pixel_size": ["4 um", "4 um"],
    "disk.roughness.correlation_length": "8 um",
    "materials.steel.hardness": "2 GPa",
    "sweep.loads": ["400 N", "750 N"],
}
CHOICE = "preset standard (error at most 1.1 %; by positions of the disk, 1.3 % of the rise)"


def scene(**entries):
    return pipeline.load_scene("first_try", overrides=SMALL | entries)


def words(**entries):
    """Options of a command for the same scene."""
    changes = (f"{name}={json.dumps(value)}" for name, value in (SMALL | entries).items())
    return [word for change in changes for word in ("--set", change)]


def run(sweep, path, accuracy=0.025, **more):
    return pipeline.run_sweep(sweep, path, workers=1, accuracy=accuracy, **more)


def done(path):
    """Mask of the points that are done, by realization, load and velocity."""
    dims = "realization", "load", "velocity"
    return pipeline.open_sweep(path)["status"].transpose(..., *dims).values == DONE


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("goal") / "small.zarr"
    reports = []
    outcome = run(scene(), path, progress=reports.append)
    assert outcome.computed == outcome.done < 30
    assert str(reports[0]) == CHOICE
    assert reports[-1].total == outcome.total  # without points that are not needed
    return path


def test_the_stated_error_is_below_the_goal_with_the_ends_of_few_points(small):
    boundary = pipeline.boundary(small)
    assert (boundary["velocity_error"] < 0.025).all()
    assert boundary.attrs["missing_points"] == 0
    ds = pipeline.open_sweep(small)
    assert np.array_equal(ds["status"] == NOT_NEEDED, ds["status"] != DONE)
    assert (ds.sizes["step"], ds.attrs["stored_steps"]) == (1, "end")


def test_further_realizations_have_one_point_a_load_and_no_fields(small):
    mask = done(small)
    fields = xr.open_zarr(small, group="fields", chunks=None)
    assert (mask[1:].sum(axis=-1) <= 1).all()
    assert mask[0].any(axis=-1).all()
    assert np.array_equal(np.isfinite(fields["pressure"].values).any(axis=(2, 3)), mask[0])
    assert pipeline.verify_store(small).is_clean


class KilledError(Exception):
    """Raised in place of a kill; it leaves the store as it is."""


def test_a_run_that_was_stopped_ends_with_the_same_points(tmp_path, small):
    def stop(progress):
        if progress.done >= 5:
            raise KilledError

    path = tmp_path / "stopped.zarr"
    with pytest.raises(KilledError):
        run(scene(), path, progress=stop)
    assert 0 < done(path).sum() < done(small).sum()
    pipeline.boundary(path)  # a half-done search answers
    run(scene(), path)
    assert np.array_equal(done(path), done(small))
    assert run(scene(), path, 0.05).computed == 0  # a larger goal is reached, too


def test_each_case_has_the_goal_and_a_preset_in_place_of_its_own_numbers(tmp_path):
    path, messages = tmp_path / "cases.zarr", []
    radii = {"sweep.over": {"pin.radius": ["1.8 mm", "2 mm"]}, "sweep.loads": ["750 N"]}
    sweep = scene(**radii | {"fidelity.increments": 7})
    run(sweep, path, 0.05, progress=lambda progress: messages.append(str(progress)))
    assert messages[0] == f"{CHOICE} replaces [fidelity] of the scene"
    boundary = pipeline.boundary(path)
    assert boundary["velocity_error"].dims == ("pin_radius", "load")
    assert np.isfinite(boundary["critical_velocity"]).all()
    assert (boundary["velocity_error"] < 0.05).all()


def test_listed_seeds_are_all_taken_and_their_part_is_left_out_of_the_goal(tmp_path, irg):
    out = tmp_path / "seeds.zarr"
    options = words(**{"sweep.loads": ["400 N"], "sweep.realizations": [3, 5]})
    output = irg("run", "first_try", *options, "--accuracy", "2.5%", "-o", out, "--workers", "1")
    assert "accuracy 2.5 % reached: at most ± 2." in output
    (statement,) = (line for line in output.splitlines() if " reached: at most ± " in line)
    assert "surface" not in statement
    assert ", positions 1." in statement
    assert "which the goal does not count, because 2 seeds are listed" in output
    assert f"{out}: {done(out).sum()} of {done(out).sum()} points done, " in output
    assert done(out)[1].sum() == 1


def test_a_later_run_computes_the_plane_of_the_first_realization(small, tmp_path):
    path = shutil.copytree(small, tmp_path / "plane.zarr")
    few = done(path).sum()
    plane = scene(**{"sweep.realizations": 1})
    outcome = pipeline.run_sweep(plane, path, workers=1)
    assert done(path)[0].all()
    assert done(path).sum() == few + outcome.computed == outcome.done == outcome.total


def test_a_plain_run_is_refused_with_the_command_that_grows_the_store(small):
    for plain in (scene(), scene(**{"fidelity.preset": "fine", "sweep.realizations": 2})):
        with pytest.raises(pipeline.StoreMismatchError, match=r"irg run SCENE --accuracy 2\.5%"):
            pipeline.run_sweep(plain, small, workers=1)
    with pytest.raises(InputError, match="the store's preset may err by"):
        run(scene(), small, 0.009)


def test_the_command_tells_what_it_reached_and_a_smaller_goal_goes_on_with_the_store(tmp_path, irg):
    out = tmp_path / "out.zarr"
    options = words(**{"sweep.loads": ["100 N", "750 N"]})
    arguments = "run", "first_try", *options, "-o", out, "--workers", "1"
    output = irg(*arguments, "--accuracy", "3%")
    assert re.search(r"accuracy 3 % reached: at most ± 2[.\d]* %, at 750 N \(inter", output)
    assert "no critical velocity in the plane at 100 N" in output
    first = done(out).sum()
    document = irg(*arguments, "--accuracy", "2%", "--json")
    assert first + document["computed"] == done(out).sum() > first
    assert document["accuracy"]["scenes"][0]["total"] < 0.02


def test_a_goal_out_of_reach_ends_with_a_line_of_advice_and_exit_code_1(tmp_path, irg):
    arguments = *words(**{"sweep.loads": ["400 N"]}), "-o", tmp_path / "far.zarr"
    output = irg("run", "first_try", *arguments, "--accuracy", "0.7%", "--workers", "1", code=1)
    assert "accuracy 0.7 % not reached" in output
    assert "to reach it: there are too few surface realizations" in output
    assert (done(tmp_path / "far.zarr").sum(axis=0) < 3).all()  # no further realizations


def test_velocities_of_a_coarse_sweep_become_more_where_the_goal_needs_them(tmp_path, irg):
    out = tmp_path / "coarse.zarr"
    few = words(**{"sweep.loads": ["750 N"], "sweep.velocities": ["0.5 m/s", "4 m/s"]})
    command = "run", "first_try", *few, "-o", out, "--accuracy", "5%", "--workers", "1"
    assert "accuracy 5 % reached" in irg(*command)
    velocities = pipeline.open_sweep(out)["velocity"].values
    assert {0.5, 4.0} < {*velocities.tolist()}
    critical_velocity = pipeline.boundary(out)["critical_velocity"].item()
    assert np.abs(velocities / critical_velocity - 1).min() < 0.02


def test_a_critical_temperature_from_tests_is_found_before_the_boundary_is_searched(tmp_path):
    with_tests = {name: value for name, value in SMALL.items() if name != "without"}
    sweep = pipeline.load_scene(
        "first_try",
        overrides={**with_tests, "temperature.critical": "from tests", "sweep.loads": ["750 N"]},
    )
    outcome = run(sweep, tmp_path / "a.zarr", 0.06)
    assert outcome.tests.done == outcome.tests.total == 4
    assert 0 < outcome.computed == outcome.done < 40
    boundary = pipeline.boundary(tmp_path / "a.zarr")
    assert (boundary["velocity_error"] < 0.06).all()
    assert "(median, from tests)" in boundary.attrs["conditions"]
    assert run(sweep, tmp_path / "a.zarr", 0.06).computed == 0


@pytest.mark.parametrize(("realization", "count"), [(3, 4), (4, 7), (200, 256)])
def test_a_store_grows_by_half_when_it_has_too_few_realizations(
    small, monkeypatch, realization, count
):
    needed = [PointIndex(0, 0, 0), PointIndex(realization, 0, 0)]
    search = SimpleNamespace(loads=[400.0], velocities=[1.0], ask=lambda: (needed, []))
    monkeypatch.setattr(goal, "search_of", lambda *_: search)
    plan = GoalPlan(scene(), None, 0.025, silent)
    assert plan.ask(pipeline.open_sweep(small)) == [(400.0, 1.0, (("realization", 0),))]
    assert len(plan.sweep.cases) == count


def test_a_goal_stores_the_course_of_points_only_where_the_scene_asks_for_it():
    for entries, steps in (({}, "end"), ({"sweep.steps": "course"}, "course")):
        assert GoalPlan(scene(**entries), None, 0.025, silent).sweep.steps == steps


SURFACES = {
    "smooth": ("fig4", {}),
    "area": ("scan", {"sweep.realizations": 1}),
    "areas": ("scan", {"sweep.realizations": 2}),
    "random": ("first_try", {}),
    "seeds": ("first_try", {"sweep.realizations": [3, 5]}),
}


def test_the_lines_of_a_goal_are_kept():
    def said(case="", load=400.0, total=0.03, reason="", **parts):
        errors = dict.fromkeys(PARTS, 0.001) | parts
        outcome = GoalOutcome(case, "fine", load, total, errors, 0.01, (100.0, 200.0))
        return "\n".join(outcome.lines(0.02, reason))

    texts = {part: said(**{part: 0.029}) for part in PARTS}
    texts["unknown"] = said("pin.radius 2 mm", total=np.nan, warnings=np.nan)
    texts["fixed"] = said(total=0.019, reason="2 seeds are listed")
    texts["none"] = said("pin.radius 2 mm", load=np.nan)
    for name, (shipped, entries) in SURFACES.items():
        texts[name] = reason_surface_is_fixed(pipeline.load_scene(shipped, overrides=entries))
    assert_as_kept("goals", texts)

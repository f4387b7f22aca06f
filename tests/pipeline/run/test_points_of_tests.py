"""Points of tests, stored besides the plane: computed, resumed, added, copied and verified."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.answers.results import cases_of
from pipeline.store.create import writing
from pipeline.sweep import plan
from tests.helpers import scenes
from tests.helpers.stores import killed_after

SCENE = scenes.SCENE.replace("increments = 10", "increments = 3").replace(
    'loads = ["200 N", "400 N", "600 N"]\nvelocities = ["1 m/s", "2 m/s", "4 m/s"]\nfields = true',
    'loads = ["400 N"]\nvelocities = ["1 m/s", "2 m/s"]',
)
STEP = '[[tests]]\nload = "400 N"\nvelocity = "2 m/s"\noutcome = "transition"\nstep = "1 m/s"\n'
WORN = (
    '[[tests]]\nload = "300 N"\nvelocity = "3 m/s"\noutcome = "severe"\nfriction = 0.12\n'
    'with = { "wear.specific_wear_rate" = "3.7e-7 mm^3/(N m)" }\n'
)
HOLD = '[[tests]]\nload = "500 N"\nvelocity = "1 m/s"\noutcome = "mild"\n'
HOLD += 'with = { "loading.hold" = "3 s" }\n'
FINE_HOLD = HOLD.replace('"3 s"', '"6 s", "fidelity.increments" = 12')


def load(folder, *tests, sweep=""):
    text = SCENE + sweep + "\n" + "".join(tests)
    (folder / "lab.toml").write_text(text, encoding="utf-8")
    return pipeline.load_scene(folder / "lab.toml")


def compute(path, sweep, count=None):
    """Compute points of tests in this process, all or the first ones; return their number."""
    with writing(path, sweep) as store:
        tests, done = store.groups[1], 0
        for point in tests.pending()[:count]:
            scene = tests.sweep.case(point.case).scene
            tests.commit([plan.run_point(scene, tests.sweep.stored_steps, point).record(False)])
            done += 1
    return done


def answered(source):
    """Load, velocity and rise of each test's point under the test's own conditions."""
    case = cases_of(source)[0]
    return [
        (point.load, point.velocity, point.rise(test.case.conditions))
        for test, points in zip(case.sweep.tests, case.tests, strict=True)
        for point in points
    ]


def simulated_rise(sweep, load, velocity, friction=0.1, **entries):
    """Rise at a load and velocity in the scene of a sweep with other entries."""
    scene = sweep.single_case()
    for path, value in entries.items():
        scene = scene.changed(path.replace("__", "."), value)
    point = pipeline.run_point(scene, load, velocity)
    rise = point.verdict(replace(scene.conditions, friction=friction)).contact_rise / friction
    return pytest.approx(rise, rel=1e-12)


@pytest.fixture(scope="module")
def tested_store(tmp_path_factory):
    """A sweep with three tests, and its store, which was computed on workers."""
    folder = tmp_path_factory.mktemp("tests")
    sweep = load(folder, STEP, WORN, HOLD)
    outcome = pipeline.run_sweep(sweep, folder / "lab.zarr", workers=1)
    assert (outcome.total, outcome.done, outcome.computed) == (2, 2, 2)
    assert (outcome.tests.total, outcome.tests.done, outcome.tests.failed) == (4, 4, ())
    return sweep, folder / "lab.zarr"


def test_points_of_tests_have_the_rises_of_their_own_scenes(tested_store):
    sweep, path = tested_store
    test_rises = answered(path)
    assert [point[:2] for point in test_rises] == [(400, 1), (400, 2), (300, 3), (500, 1)]
    changes_by_test = {}, {}, {"wear__specific_wear_rate": "3.7e-7 mm^3/(N m)", "friction": 0.12}
    for (load_of, velocity, rise), changes in zip(
        test_rises, (*changes_by_test, {"loading__hold": "3 s"}), strict=True
    ):
        assert rise == simulated_rise(sweep, load_of, velocity, **changes)
    ds = pipeline.open_sweep(path)
    assert ds.sizes["test_step"] == 2  # the onset of the hold, and its end
    plane = np.exp(cases_of(ds)[0].log_rises(sweep.conditions)).ravel()
    assert [rise for *_, rise in test_rises[:2]] == pytest.approx(plane.tolist(), rel=1e-12)


def test_an_interrupted_run_goes_on_and_a_second_one_computes_nothing(tested_store, tmp_path):
    sweep, path = tested_store[0], tmp_path / "lab.zarr"
    assert compute(path, sweep, count=3) == 3
    assert pipeline.summary(path).tests.pending == 1
    outcome = pipeline.run_sweep(sweep, path, workers=1)
    assert (outcome.tests.done, outcome.computed) == (4, 2)
    assert answered(path) == answered(tested_store[1])
    assert compute(path, sweep) == 0


def test_a_changed_or_further_test_is_computed_alone_and_no_store_is_refused(tmp_path):
    path = tmp_path / "lab.zarr"
    assert compute(path, load(tmp_path, STEP)) == 2
    assert compute(path, load(tmp_path, HOLD, STEP)) == 1
    changed = WORN.replace("3.7e-7", "1e-7")
    assert compute(path, load(tmp_path, STEP, WORN)) == 1
    assert compute(path, load(tmp_path, STEP, changed)) == 1
    assert compute(path, load(tmp_path, WORN, STEP)) == 1  # it was dropped with its test
    sweep = load(tmp_path, STEP, WORN.replace("0.12", "0.2"))
    assert compute(path, sweep) == 0  # the same simulation
    wear = {"wear__specific_wear_rate": "3.7e-7 mm^3/(N m)"}
    assert answered(path)[2] == (300.0, 3.0, simulated_rise(sweep, 300.0, 3.0, 0.2, **wear))
    assert pipeline.verify_store(path).is_clean


def test_a_test_with_more_steps_than_the_store_has_room_for_is_taken(tmp_path):
    path = tmp_path / "lab.zarr"
    track = SCENE.replace("[disk]\n", '[disk]\ntrack_length = "200 mm"\n')
    for tests, computed in (
        ((STEP, HOLD), 3),
        ((STEP, HOLD, FINE_HOLD), 1),
        ((STEP, FINE_HOLD), 0),
    ):
        (tmp_path / "lab.toml").write_text(track + "\n" + "".join(tests), encoding="utf-8")
        sweep = pipeline.load_scene(tmp_path / "lab.toml")
        assert compute(path, sweep) == computed
        assert pipeline.verify_store(path).is_clean
        assert np.isfinite([rise for *_, rise in answered(path)]).all()


def test_no_kill_while_a_store_takes_a_further_test_loses_a_finished_one(tmp_path, monkeypatch):
    before, sweep = load(tmp_path, STEP), load(tmp_path, HOLD, STEP, WORN)
    assert compute(tmp_path / "before.zarr", before) == 2
    kills = 0
    for count in range(0, 400, 97):
        path = shutil.copytree(tmp_path / "before.zarr", tmp_path / "lab.zarr")
        with killed_after(monkeypatch, count) as was_killed, writing(path, sweep):
            pass
        with writing(path, before) as store:
            assert len(store.groups[1].pending()) == 0
        assert pipeline.verify_store(path).tests.damaged == ()
        with writing(path, sweep) as store:
            assert len(store.groups[1].pending()) == 2
        shutil.rmtree(path)
        kills += bool(was_killed)
        if not was_killed:
            break
    assert kills > 1


def test_a_run_with_a_goal_computes_the_tests_too_and_once(tmp_path):
    sweep = load(tmp_path, STEP, WORN, sweep="realizations = 1\n")
    sweep, path = sweep.changed("fidelity.preset", "standard"), tmp_path / "lab.zarr"
    outcome = pipeline.run_sweep(sweep, path, workers=1, accuracy=0.6)
    assert (outcome.tests.total, outcome.tests.done) == (3, 3)
    assert compute(path, sweep) == 0


def test_rows_and_surfaces_have_the_tests_of_the_scene_once(tmp_path):
    rows = 'over = { "pin.radius" = ["3 mm", "1 mm"] }\nrealizations = 2\n'
    sweep, path = load(tmp_path, STEP, sweep=rows), tmp_path / "lab.zarr"
    assert compute(path, sweep) == 2
    assert answered(path) == [(400.0, V, simulated_rise(sweep, 400.0, V)) for V in (1.0, 2.0)]
    selected = pipeline.open_sweep(path).sel(pin_radius=1e-3).isel(realization=[0])
    assert answered(selected) == answered(path)


SELECTIONS = {
    "one place": lambda ds: ds.sel(load=400.0, velocity=1.0),
    "joined": lambda ds: xr.concat([ds.isel(velocity=[k]) for k in (0, 1)], "velocity"),
}


@pytest.mark.parametrize("kind", SELECTIONS)
def test_what_xarray_does_with_the_plane_leaves_the_tests_alone(tested_store, kind):
    ds = SELECTIONS[kind](pipeline.open_sweep(tested_store[1]))
    assert answered(ds) == answered(tested_store[1])


def test_a_failed_test_tells_its_reason_and_is_tried_again_when_asked_to(tmp_path, irg):
    sweep, path = load(tmp_path, STEP), tmp_path / "lab.zarr"
    compute(path, sweep)
    with writing(path, sweep) as store:
        point = plan.points(store.groups[1].sweep)[1]
        store.groups[1].commit([plan.PointRecord(point, None, "out of luck")])
    points = [test_point for points in cases_of(path)[0].tests for test_point in points]
    assert [test_point.status for test_point in points] == [1, 2]
    assert points[1].message == "out of luck"
    output = irg("status", path, code=1)
    assert "tests: 1 of 2 points done" in output
    assert "failed: 400 N, 2 m/s, test 1: out of luck" in output
    outcome = pipeline.run_sweep(sweep, path, workers=1, retry_failed=True)
    assert (outcome.tests.done, outcome.tests.failed) == (2, ())


def test_damage_of_a_test_is_named_apart_and_mended(tested_store, tmp_path, irg):
    path = shutil.copytree(tested_store[1], tmp_path / "lab.zarr")
    (chunk,) = (path / "tests" / "max_rise").glob("c.*")
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 1
    chunk.write_bytes(content)
    output = irg("verify", path, code=1)
    assert "points: 2 done and undamaged, 0 damaged" in output
    assert "tests: 0 done and undamaged, 4 damaged" in output
    outcome = pipeline.run_sweep(tested_store[0], path, workers=1)
    assert (outcome.computed, outcome.tests.done) == (0, 4)
    assert answered(path) == answered(tested_store[1])


def test_a_document_counts_the_tests_apart(tested_store, tmp_path, irg):
    load(tmp_path, STEP, WORN, HOLD)
    copy = shutil.copytree(tested_store[1], tmp_path / "lab.zarr")
    document = irg("run", tmp_path / "lab.toml", "-o", copy, "--json")
    assert document["tests"] == {"points": 4, "done": 4, "failed": 0}


def test_points_of_tests_are_taken_from_another_store(tested_store, tmp_path):
    sweep, path = tested_store[0], tmp_path / "new.zarr"
    outcome = pipeline.run_sweep(sweep, path, workers=1, source=tested_store[1])
    assert (outcome.computed, outcome.tests.done) == (0, 4)
    assert answered(path) == answered(tested_store[1])

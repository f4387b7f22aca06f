"""Roots that are made again, and resumed runs that read what differs alone."""

import os
import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import tribo
from pipeline.run.sweep import run_sweep
from pipeline.scene.scenefile import load_scene
from pipeline.store import root
from pipeline.store.create import restore_root, writing
from pipeline.store.place import StoreError, StoreMismatchError
from pipeline.store.schema import DONE
from pipeline.store.verify import changed_chunks, note_files, verify_store
from pipeline.sweep.plan import points
from tests.crash.drive import computing
from tests.helpers import tiny
from tests.helpers.heard import Heard
from tests.helpers.scenes import SCENE
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    contents,
    done_points,
    make,
    opened,
    record,
)
from tests.pipeline.conftest import commit_all

SWEEP = tiny.full()


def flip(file, place):
    content = bytearray(file.read_bytes())
    content[int(place * (len(content) - 1))] ^= 1
    file.write_bytes(content)


HARMS = {
    "flip": flip,
    "cut": lambda file, place: file.write_bytes(file.read_bytes()[: int(place * 1000)]),
    "delete": lambda file, _: file.unlink(),
}


@pytest.mark.parametrize(("harm", "place"), [("flip", 0.6), ("cut", 0.9), ("delete", 0.0)])
def test_a_root_is_made_again_by_the_scene_that_made_it(copy, harm, place):
    before = opened(copy).root
    HARMS[harm](copy / "zarr.json", place)
    with pytest.raises(StoreError, match="irg run with the scene that made it makes it again"):
        opened(copy)
    messages = Heard()
    outcome = run_sweep(SWEEP, copy, workers=1, progress=messages.hear)
    assert (outcome.computed, outcome.done) == (0, 9)
    assert messages[0] == f"the root of {copy} was lost, damaged or old, and is made again"
    after = opened(copy).root
    assert after.arrays == before.arrays
    assert after.sweep == before.sweep
    assert replace(after.facts, generation=before.facts.generation) == before.facts
    assert verify_store(copy).is_clean
    assert_is_as_computed(copy, points(SWEEP))


def test_conditions_that_were_changed_in_the_root_are_named_and_made_right(copy):
    file = copy / "zarr.json"
    before = file.read_bytes()
    friction = SWEEP.conditions.friction
    changed = before.replace(rb"\"friction\": %g" % friction, rb"\"friction\": %g" % (2 * friction))
    assert changed != before
    file.write_bytes(changed)
    with pytest.raises(StoreError, match="is damaged: it is not what was written"):
        opened(copy)
    run_sweep(SWEEP, copy, workers=1)
    assert opened(copy).sweep.conditions == SWEEP.conditions


def test_another_scene_on_the_same_axes_is_refused_and_nothing_written(copy):
    other = tiny.full(pin=tribo.Cylinder(9e-3, 3.375e-3, SWEEP.scene.disk))
    (copy / "zarr.json").unlink()
    before = contents(copy)
    with pytest.raises(StoreMismatchError, match="its points are not those of this scene"):
        run_sweep(other, copy, workers=1)
    assert contents(copy) == before


def test_another_scene_is_refused_too_where_most_points_are_still_to_do(path):
    commit(path, SWEEP, points(SWEEP)[:2])
    (path / "zarr.json").unlink()
    with pytest.raises(StoreMismatchError, match="its points are not those of this scene"):
        restore_root(path, tiny.full(pin=tribo.Cylinder(9e-3, 3.375e-3, SWEEP.scene.disk)))
    assert restore_root(path, SWEEP)


def test_a_scene_with_one_other_row_makes_no_root_again(path, tmp_path):
    def load(radius):
        rows = f"""along = [
          {{ "pin.radius" = "3 mm", load = "300 N", velocity = "1 m/s" }},
          {{ "pin.radius" = "{radius}", load = "300 N", velocity = "2 m/s" }},
        ]"""
        (tmp_path / "scene.toml").write_text(SCENE.replace("[sweep]", f"[sweep]\n{rows}"))
        return load_scene(tmp_path / "scene.toml", overrides={"fidelity.increments": 3})

    commit_all(path, load("4 mm"))
    (path / "zarr.json").unlink()
    with pytest.raises(StoreMismatchError, match="not those of this scene"):
        restore_root(path, load("5 mm"))
    assert restore_root(path, load("4 mm"))


def test_a_root_of_a_store_that_has_grown_keeps_its_stations(copy):
    larger = tiny.full(loads=(200.0, 600.0), velocities=(0.75,))
    make(copy, larger)
    stations = opened(copy).sweep.record.stations
    (copy / "zarr.json").unlink()
    assert restore_root(copy, larger)
    assert opened(copy).sweep.record.stations == stations
    assert set(np.argwhere(opened(copy).flags == DONE).shape) == {9, 2}


ADDED = {
    "between": {"velocities": (0.75,)},
    "behind": {"velocities": (2.0,)},
    "stations": {"loads": (100.0, 900.0), "velocities": (0.5,)},
}


def resumed(path, sweep, progress=None):
    """Run a sweep from records; the number of points that were computed."""
    records = {point: record(point) for point in points(sweep)}
    with computing(records, pace=0.0):
        return run_sweep(sweep, path, workers=1, progress=progress).computed


@pytest.mark.parametrize("added", ADDED)
def test_a_root_older_than_its_arrays_is_made_again_with_all_points(copy, irg, added, monkeypatch):
    old, larger = (copy / "zarr.json").read_bytes(), tiny.full(**ADDED[added])
    commit(copy, larger)
    done, versions = set(done_points(copy)), opened(copy).root.facts.versions
    assert len(done) > 9
    monkeypatch.setattr(root, "package_versions", lambda: dict.fromkeys(versions, "later"))
    (copy / "zarr.json").write_bytes(old)
    before = contents(copy)
    for options in ((), ("--repair",)):
        said = irg("verify", copy, *options, code=2)
        assert "zarr.json is older than its arrays, or newer; nothing was changed; irg run" in said
    assert contents(copy) == before
    messages = Heard()
    assert resumed(copy, SWEEP, messages.hear) == 0
    assert "is made again" in messages[0]
    assert set(done_points(copy)) == done
    assert opened(copy).root.facts.versions == versions
    assert [kept.read_bytes() for kept in copy.glob("damaged/*/zarr.json")] == [old]
    assert verify_store(copy).is_clean


def test_a_root_newer_than_its_arrays_is_made_again_with_their_points(copy):
    older = shutil.copytree(copy, copy.with_name("older.zarr"))
    larger = tiny.full(velocities=(0.5, 0.75, 1.0, 1.5))
    commit(copy, larger)
    shutil.copy(copy / "zarr.json", older / "zarr.json")
    assert resumed(older, larger) == 3
    assert_is_as_computed(older, points(larger))


def test_files_of_a_larger_store_among_those_of_a_smaller_one_are_left_alone(copy):
    """A copy that was cut short: neither root nor arrays tell which points are whole."""
    older = shutil.copytree(copy, copy.with_name("older.zarr"))
    commit(copy, tiny.full(velocities=(0.75,)))
    for name in (
        "mean_rise/zarr.json",
        "mean_rise/c.0.0.0",
        "rise_quantile/zarr.json",
        "zarr.json",
    ):
        shutil.copy(copy / name, older / name)
    before = contents(older)
    for function in (
        verify_store,
        partial(verify_store, repair=True),
        partial(resumed, sweep=SWEEP),
    ):
        with pytest.raises(StoreError, match=r"not of one time, and .*; nothing was changed: copy"):
            function(older)
    assert contents(older) == before


# What a resumed run reads


def noted(path):
    store = make(path, SWEEP)
    note_files(store)
    return store


def test_a_store_as_it_was_left_is_not_read_again(copy):
    store = noted(copy)
    assert changed_chunks(store) == set()
    messages = Heard()
    run_sweep(SWEEP, copy, workers=1, progress=messages.hear)
    assert messages == []


@pytest.mark.parametrize("listed", ["nonsense", "[[1, 2]]", "[" * 10**5])
def test_without_a_list_of_its_files_any_of_a_store_may_differ(copy, listed):
    (copy / "status" / "seen").write_text(listed)
    assert changed_chunks(opened(copy)) is None


def older(file):
    content, state = file.read_bytes(), file.stat()
    flip(file, 0.5)
    os.utime(file, ns=(state.st_atime_ns, state.st_mtime_ns - 10**12))
    assert file.stat().st_size == len(content)


@pytest.mark.parametrize(
    ("name", "harm"),
    [("mean_rise/c.0.0.0", older), ("rise/c.1.1.0.0", lambda file: file.unlink())],
)
def test_a_file_that_differs_in_name_size_or_time_is_read_again(copy, harm, name):
    noted(copy)
    harm(copy / name)
    messages = Heard()
    outcome = run_sweep(SWEEP, copy, workers=1, progress=messages.hear)
    assert "1 chunks of points" in messages[0]
    assert "whose files differ" in messages[0]
    assert outcome.computed == (9 if name.startswith("mean_rise") else 1)
    assert_is_as_computed(copy, points(SWEEP))


def swapped(path, name, rng):
    """Exchange a block with another one of the store."""
    other = path / str(rng.choice([one for one in contents(path) if "/c." in one and one != name]))
    mine, theirs = (path / name).read_bytes(), other.read_bytes()
    (path / name).write_bytes(theirs)
    other.write_bytes(mine)


@pytest.mark.parametrize(
    ("harm", "names"),
    [*((harm, "*/c.*") for harm in ("cut", "swap", "older")), ("older", "status/c.0.0")],
)
def test_after_any_mutation_of_a_file_a_run_ends_with_the_same_bits(alone, tmp_path, harm, names):
    rng = np.random.default_rng(len(harm))
    with writing(half := tmp_path / "half.zarr", SWEEP) as store:
        store.commit([record(point) for point in points(SWEEP)[:4]])
    path = shutil.copytree(alone, tmp_path / "out.zarr")
    noted(path)
    name = str(rng.choice(sorted(file.relative_to(path) for file in path.glob(names))))
    if harm == "swap":
        swapped(path, name, rng)
    elif harm == "older" and (half / name).exists():
        shutil.copy2(half / name, path / name)
    else:
        HARMS.get(harm, HARMS["delete"])(path / name, rng.uniform())
    with computing({point: record(point) for point in points(SWEEP)}, pace=0.0):
        outcome = run_sweep(SWEEP, path, workers=1)
    assert outcome.done == len(points(SWEEP)), name
    verify_store(path, repair=True)  # also of files of axes, which a run leaves
    assert_is_as_computed(path, points(SWEEP))
    assert verify_store(path).is_clean, name

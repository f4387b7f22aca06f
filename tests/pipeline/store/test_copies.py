"""Runs that find what a killed growth left, or a store with damaged documents."""

import json
import shutil
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

import pipeline
from pipeline import StoreError, summary, verify_store
from pipeline.store import arrays, create
from pipeline.store.create import find_sweep, writing
from pipeline.store.location import NEW, OLD, ROOT
from pipeline.store.root import FACTS
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.reported import Heard
from tests.helpers.stores import (
    Killed,
    assert_is_as_computed,
    commit,
    commit_all,
    contents,
    done_points,
    fail,
)

SWEEP = tiny.full()
TWO_POINTS = tiny.full(loads=(150.0, 600.0), velocities=(0.5,))
THREE_POINTS = tiny.full(loads=(100.0, 150.0, 600.0), velocities=(0.5,))
CHUNK = "mean_rise/c.0.0.0"


def beside(path, ending):
    return path.with_name(path.name + ending)


def grow_until(renames, path):
    """Enlarge a store in a process that is killed after some renames of folders."""
    rename, left = Path.rename, [renames]

    def rename_some(self, target):
        left[0] -= 1
        if left[0] < 0:
            raise Killed
        rename(self, target)

    def killed(*_):
        raise Killed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "rename", rename_some)
        patch.setattr(create, "sync", killed)  # after the second rename
        with pytest.raises(Killed):
            commit(path, THREE_POINTS, ())


def cut(*keys):
    """Function that cuts files of a copy of the store, by their keys."""

    def harm(copy):
        for file in (copy / key for key in keys):
            content = file.read_bytes()
            file.write_bytes(content[: len(content) // 2])

    return harm


@pytest.mark.parametrize("sweep", [TWO_POINTS, THREE_POINTS], ids=["same scene", "larger scene"])
@pytest.mark.parametrize("renames", [0, 1, 2])
def test_a_growth_that_is_killed_between_its_renames_loses_no_point(renames, sweep, path):
    commit(path, TWO_POINTS)
    grow_until(renames, path)
    assert path.exists() == (renames != 1)
    assert beside(path, NEW).exists() == (renames < 2)
    assert beside(path, OLD).exists() == (renames > 0)
    if renames == 1:
        with pytest.raises(StoreError, match=r"a run ended while it created .*; run its scene ag"):
            summary(path)
    assert find_sweep(path).velocities == TWO_POINTS.velocities
    commit(path, sweep, ())
    assert_is_as_computed(path, points(TWO_POINTS))
    assert verify_store(path).is_clean
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def flip(file, position=0):
    """Change a bit of a file at a position, by default so that a document is none any more."""
    content = bytearray(file.read_bytes())
    content[position] ^= 1
    file.write_bytes(content)


HARMS = {
    "deleted": Path.unlink,
    "cut": lambda file: cut("")(file),
    "empty": lambda file: file.write_bytes(b""),
    "other": lambda file: file.write_text("{}"),
    "flipped": flip,
}


@pytest.mark.parametrize("harm", [HARMS["deleted"], HARMS["cut"]])
def test_a_store_without_its_facts_and_their_copy_is_refused_and_nothing_is_deleted(path, harm):
    commit(path, TWO_POINTS)
    grow_until(2, path)
    for key in (FACTS, ROOT):
        harm(path / key)
    before = contents(path.parent)
    for sweep in (TWO_POINTS, THREE_POINTS):
        with pytest.raises(StoreError, match="run the scene into another store"):
            commit(path, sweep, ())
    assert contents(path.parent) == before


@pytest.mark.parametrize("harm", HARMS.values(), ids=HARMS)
@pytest.mark.parametrize("key", [FACTS, ROOT, f"status/{ROOT}", f"about/message/{ROOT}"])
def test_a_damaged_document_is_named_costs_no_point_and_is_mended_by_the_first_run(
    copy, tiny_store, harm, key
):
    before = contents(copy)
    harm(copy / key)
    harmed = contents(copy)
    assert summary(copy).done == 9
    assert pipeline.boundary(copy).equals(pipeline.boundary(tiny_store))
    verification = verify_store(copy)
    assert (verification.done, verification.damaged, verification.shared) == (9, (), (key,))
    assert contents(copy) == harmed  # answers write nothing
    commit(copy, SWEEP, ())
    assert contents(copy) == before


def test_a_flipped_bit_anywhere_in_the_facts_costs_no_store_and_is_mended(path):
    commit(path, TWO_POINTS, ())
    before = contents(path)
    for position in range(0, len(before[FACTS]), 61):
        flip(path / FACTS, position)
        assert find_sweep(path) == TWO_POINTS
        assert verify_store(path).shared == (FACTS,)
        commit(path, TWO_POINTS, ())
        assert contents(path) == before


def test_arrays_that_users_added_stay_beside_a_copy_of_the_facts(path):
    commit(path, TWO_POINTS)
    zarr.open_group(path, mode="r+").create_array("notes/rig", data=np.arange(3))
    commit(path, TWO_POINTS, ())  # Zarr has dropped the copy
    (path / FACTS).unlink()
    assert summary(path).done == 2
    commit(path, TWO_POINTS, ())
    with_copy = zarr.open_group(path, mode="r", use_consolidated=True)
    assert with_copy["notes/rig"][:].tolist() == [0, 1, 2]
    assert verify_store(path).is_clean


@pytest.mark.parametrize("failing", [(), (Point(600.0, 0.5),)], ids=["done", "one failed"])
def test_a_store_that_has_lost_its_folder_about_has_all_finished_points(path, failing):
    commit(path, TWO_POINTS)
    for point in failing:
        with writing(path, TWO_POINTS) as store:
            store.forget([point])
        fail(path, TWO_POINTS, point, "out of memory")
    finished = [point for point in points(TWO_POINTS) if point not in failing]
    shutil.rmtree(path / "about")
    assert summary(path).done == len(finished)
    assert pipeline.open_sweep(path)["mean_rise"].notnull().sum() > 0
    verification = verify_store(path)
    assert [Point(*damage[:2]) for damage in map(astuple, verification.damaged)] == [*failing]
    assert verification.shared == ("about/message/c.0.0", FACTS, f"about/message/{ROOT}")
    commit(path, TWO_POINTS, ())
    assert_is_as_computed(path, finished)
    assert summary(path).pending == len(failing)
    assert verify_store(path).is_clean


@pytest.mark.parametrize("name", ["x", "pressure", "field_realization"])
def test_a_store_without_the_folder_of_an_array_of_fields_is_extended_by_realizations(path, name):
    axes = {"loads": (150.0,), "velocities": (0.5,)}
    commit_all(path, tiny.full(**axes, case_table=surface_table((3,))))
    shutil.rmtree(path / "fields" / name)
    commit_all(path, tiny.full(**axes, case_table=surface_table((3, 4))))
    assert verify_store(path).is_clean
    assert summary(path).done == 2


@pytest.mark.parametrize(("build", "computed"), [(tiny.full, 1), (tiny.sweep, 0)])
def test_a_point_is_copied_if_it_has_the_fields_that_are_wanted(path, build, computed):
    """A store has the fields of its first realization only."""
    axes = {"loads": (150.0,), "velocities": (0.5,)}
    commit_all(path, tiny.full(**axes, case_table=surface_table((3, 4))))
    second, copy = build(**axes, case_table=surface_table((4,))), beside(path, ".copy")
    heard = Heard()
    outcome = pipeline.run_sweep(second, copy, workers=1, source=path, progress=heard.hear)
    assert f"{1 - computed} points are copied from {path}" in heard
    assert (outcome.done, outcome.computed) == (1, computed)
    assert verify_store(copy).is_clean


def pressure(path):
    """Stored contact pressure of all points, one after another."""
    return xr.open_zarr(path, group="fields", chunks=None)["pressure"].values.ravel()


def test_fields_of_a_further_realization_are_not_copied_over_those_of_the_first(path):
    axes, source = {"loads": (150.0,), "velocities": (0.5,)}, beside(path, ".source")
    commit_all(path, tiny.full(**axes, case_table=surface_table((3,))))
    commit_all(source, tiny.full(**axes, case_table=surface_table((4,))))
    first, further = pressure(path), pressure(source)
    both = tiny.full(**axes, case_table=surface_table((3, 4)))
    assert pipeline.run_sweep(both, path, workers=1, source=source).computed == 0
    assert (first != further).any()
    np.testing.assert_array_equal(pressure(path), first)


def test_a_store_is_readable_however_often_it_grows(path, monkeypatch):
    monkeypatch.setattr(arrays, "_MAX_CHECKSUMS", 3)
    expected = [Point(150.0, 0.5)]
    for count, load in enumerate((250.0, 600.0, 700.0, 200.0, 100.0)):
        commit(
            path,
            tiny.full(loads=tuple(sorted({150.0, load})), velocities=(0.5,)),
            expected if not count else (),
        )
        assert done_points(path) == expected
        assert verify_store(path).is_clean


def test_a_flipped_bit_in_the_text_of_the_scene_is_found_and_mended(path):
    sweep = replace(TWO_POINTS, text='radius = "2 mm"\n')
    commit(path, sweep)
    before = contents(path)
    content = bytearray(before[ROOT])
    content[content.rindex(b"2 mm")] ^= 1
    (path / ROOT).write_bytes(content)
    assert "2 mm" in pipeline.open_sweep(path).attrs["scene"]
    assert verify_store(path).shared == (ROOT,)
    commit(path, sweep, ())
    assert contents(path) == before


def test_facts_that_a_program_wrote_in_another_order_are_read(path):
    commit(path, TWO_POINTS)
    for file in path.rglob(ROOT):
        file.write_text(json.dumps(json.loads(file.read_text()), sort_keys=True))
    assert pipeline.open_sweep(path)["status"].size == 2

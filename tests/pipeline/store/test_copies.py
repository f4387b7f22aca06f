"""Runs that find a store damaged next to the copies of a killed growth, or without its root."""

import dataclasses
import shutil
from pathlib import Path

import pytest

import pipeline
import tribo
from pipeline import StoreError, summary, verify_store
from pipeline.store import arrays, create
from pipeline.store.copies import find_sweep
from pipeline.store.location import NEW, OLD, ROOT
from pipeline.store.root import FACTS
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.scenes import STEEL
from tests.helpers.stores import (
    Killed,
    assert_is_as_computed,
    commit,
    commit_all,
    contents,
    done_points,
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


KILLS = {
    "only the old one": (1, NEW, shutil.rmtree),
    "only the new one": (1, OLD, shutil.rmtree),
    "both between the renames": (1, NEW, lambda _: None),
    "the new one without its root": (1, NEW, cut(FACTS, ROOT)),
    "the new one with half of its root": (1, NEW, cut(FACTS)),
    "the old one without its root": (1, OLD, cut(FACTS, ROOT)),
    "the new one with a damaged chunk": (1, NEW, cut(CHUNK)),
    "the old one with a damaged chunk": (1, OLD, cut(CHUNK)),
    "the store without its root before the renames": (0, "", cut(FACTS, ROOT)),
    "the store with a damaged chunk before the renames": (0, "", cut(CHUNK)),
    "the store removed before the renames": (0, "", shutil.rmtree),
    "the store without its root after the renames": (2, "", cut(FACTS, ROOT)),
}


@pytest.fixture(scope="module")
def killed_growths(tmp_path_factory):
    """Folders with a store whose growth was killed after 0, 1 and 2 renames."""
    folders = [tmp_path_factory.mktemp(f"{renames}-renames") for renames in range(3)]
    for renames, folder in enumerate(folders):
        commit(folder / "tiny.zarr", TWO_POINTS)
        grow_until(renames, folder / "tiny.zarr")
    return folders


@pytest.mark.parametrize("sweep", [TWO_POINTS, THREE_POINTS], ids=["same scene", "larger scene"])
@pytest.mark.parametrize("kill", KILLS)
def test_of_the_copies_of_a_killed_growth_the_one_with_most_sound_points_goes_on(
    kill, sweep, path, killed_growths
):
    renames, ending, harm = KILLS[kill]
    shutil.copytree(killed_growths[renames], path.parent, dirs_exist_ok=True)
    assert beside(path, NEW).exists() or renames == 2
    harm(beside(path, ending))
    assert find_sweep(path).velocities == TWO_POINTS.velocities
    commit(path, sweep, ())
    assert_is_as_computed(path, points(TWO_POINTS))
    assert verify_store(path).is_clean
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_a_copy_that_cannot_be_read_is_not_deleted_for_a_damaged_one(path, killed_growths):
    shutil.copytree(killed_growths[1], path.parent, dirs_exist_ok=True)
    with pytest.raises(StoreError, match=r"a run ended while it created .*; run its scene again"):
        summary(path)
    cut(FACTS, ROOT)(beside(path, NEW))
    cut(CHUNK)(beside(path, OLD))
    before = contents(path.parent)
    with pytest.raises(StoreError, match=r"irg-new: its about/zarr\.json is damaged"):
        commit(path, TWO_POINTS, ())
    after = {key: content for key, content in contents(path.parent).items() if "lock" not in key}
    assert after == before


@pytest.mark.parametrize("key", [FACTS, ROOT])
@pytest.mark.parametrize(
    "harm", [Path.unlink, lambda file: cut("")(file), lambda f: f.write_text("{}")]
)
def test_either_document_with_the_data_of_the_sweep_mends_the_other(copy, harm, key):
    before = contents(copy)
    harm(copy / key)
    assert pipeline.boundary(copy).equals(pipeline.boundary(copy))
    verification = verify_store(copy)
    assert (verification.done, verification.damaged, verification.shared) == (9, (), (key,))
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    assert contents(copy) == before


SEVERAL = tiny.sweep(
    loads=(150.0,), velocities=(0.5,), case_table=surface_table((1, 2)), fields=True
)


@pytest.mark.parametrize("sweep", [TWO_POINTS, SEVERAL, tiny.sweep(loads=(150.0,))])
def test_a_store_that_has_lost_both_is_restored_by_the_scene_of_its_points(path, sweep):
    commit_all(path, sweep)
    commit(path, sweep, ())
    before = contents(path)
    for key in (FACTS, ROOT):
        (path / key).unlink()
    lost = contents(path)
    for other in (
        tiny.full(increments=7),
        tiny.full(velocities=(0.5, 1.0)),
        changed(sweep, loads=(151.0, *sweep.loads[1:])),
        changed(sweep, pin=tribo.Cylinder(9e-3, 3.375e-3, STEEL)),
    ):
        with pytest.raises(StoreError, match=r"its about/zarr\.json is lost; irg run restores it"):
            commit(path, other, ())
        assert contents(path) == lost
    assert pipeline.run_sweep(sweep, path, workers=1).computed == 0
    assert contents(path) == before


@pytest.mark.parametrize("name", ["x", "pressure", "field_realization"])
def test_a_store_without_the_folder_of_an_array_of_fields_is_extended_by_realizations(path, name):
    axes = {"loads": (150.0,), "velocities": (0.5,)}
    commit_all(path, tiny.full(**axes, case_table=surface_table((3,))))
    shutil.rmtree(path / "fields" / name)
    commit_all(path, tiny.full(**axes, case_table=surface_table((3, 4))))
    assert verify_store(path).is_clean
    assert summary(path).done == 2


@pytest.mark.parametrize("harm", [Path.unlink, lambda file: file.write_text("{}")])
def test_the_metadata_of_statuses_are_mended_by_the_first_run(copy, harm):
    before = contents(copy)
    harm(copy / "status" / ROOT)
    assert verify_store(copy).shared == (f"status/{ROOT}",)
    assert pipeline.run_sweep(SWEEP, copy, workers=1).done == 9
    assert contents(copy) == before


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


@pytest.mark.parametrize("key", [FACTS, ROOT])
def test_a_flipped_bit_in_the_text_of_the_scene_is_found_and_mended(path, key):
    sweep = dataclasses.replace(TWO_POINTS, text='radius = "2 mm"\n')
    commit(path, sweep)
    commit(path, sweep, ())
    before = contents(path)
    content = bytearray(before[key])
    content[content.rindex(b"2 mm")] ^= 1
    (path / key).write_bytes(content)
    assert "2 mm" in pipeline.open_sweep(path).attrs["scene"]
    assert verify_store(path).shared == (key,)
    commit(path, sweep, ())
    assert contents(path) == before

"""What a store is taken for, and what holds its root (root.py, begun.py and layout.py)."""

import json
import math
import os
import shutil
from pathlib import Path

import pytest

from pipeline.analysis.dataset import open_sweep
from pipeline.cli import main
from pipeline.run.sweep import run_sweep
from pipeline.store import Store, StoreError, compact_store, prepare, summary, verify_store
from pipeline.store.root import COPY, renew_copy
from pipeline.sweep.model import Point
from pipeline.sweep.plan import run_point
from tests.helpers import tiny

SWEEP = tiny.full()
OTHER = tiny.sweep(increments=7)
POINT = Point(250.0, 1.0)


@pytest.fixture
def copy(alone, tmp_path):
    return shutil.copytree(alone, tmp_path / "copy.zarr")


def everything(path):
    return {file: file.read_bytes() for file in path.rglob("*") if file.is_file()}


def without_root(path):
    (path / "zarr.json").unlink()


def without_root_and_copy(path):
    without_root(path)
    (path / "status" / COPY).unlink()


def with_points_alone(path):
    without_root_and_copy(path)
    shutil.rmtree(path / "status")


def with_a_file_in_a_folder_named_like_a_variable(path):
    shutil.rmtree(path)
    (path / "load").mkdir(parents=True)
    (path / "load" / "mine.csv").write_text("years of work")


def with_a_file_of_its_own(path):
    shutil.rmtree(path)
    path.mkdir()
    (path / "notes.partial").write_text("years of work")


def with_an_array_of_somebody_else(path):
    document = json.loads((path / "load" / "zarr.json").read_text())
    shutil.rmtree(path)
    (path / "load").mkdir(parents=True)
    document["attributes"]["long_name"] = "payload of a truck"
    (path / "load" / "zarr.json").write_text(json.dumps(document))


@pytest.mark.parametrize(
    "make",
    [
        without_root,
        without_root_and_copy,
        with_points_alone,
        with_a_file_in_a_folder_named_like_a_variable,
        with_a_file_of_its_own,
        with_an_array_of_somebody_else,
    ],
)
@pytest.mark.parametrize("sweep", [SWEEP, OTHER], ids=["same", "other"])
def test_nothing_is_written_over(copy, make, sweep):
    make(copy)
    before = everything(copy)
    with pytest.raises(StoreError, match=r"zarr\.json"):
        prepare(copy, sweep)
    assert everything(copy) == before


def test_a_root_that_is_lost_is_restored_from_its_copy(copy, alone, capsys):
    without_root(copy)
    assert main(["status", str(copy)]) == 2
    assert "irg verify --repair restores it" in capsys.readouterr().err
    assert main(["verify", str(copy), "--repair"]) == 1
    assert main(["verify", str(copy)]) == 0
    assert everything(copy).keys() == {copy / file.relative_to(alone) for file in everything(alone)}
    assert (copy / "zarr.json").read_bytes() == (alone / "zarr.json").read_bytes()


def test_a_root_without_a_copy_is_named(copy):
    without_root_and_copy(copy)
    with pytest.raises(StoreError, match=r"has lost its zarr\.json, and there is no copy"):
        verify_store(copy, repair=True)


def edited(path, edit):
    root = json.loads((path / "zarr.json").read_text())
    edit(root)
    (path / "zarr.json").write_text(json.dumps(root))


EDITS = {
    "friction": lambda root: root["attributes"]["conditions"].update(friction=0.5),
    "an axis": lambda root: root["attributes"]["axes"]["load"].__setitem__(0, 152.0),
    "a unit": lambda root: arrays(root)["time"]["attributes"].update(units="h"),
    "a title": lambda root: root["attributes"].update(title="Something else"),
    "a shape": lambda root: arrays(root)["time"]["shape"].__setitem__(2, 10**12),
    "no title": lambda root: root["attributes"].pop("title"),
    "no arrays": lambda root: root.pop("consolidated_metadata"),
    "no hash": lambda root: root["attributes"].pop("root_hash"),
}


def arrays(root):
    return root["consolidated_metadata"]["metadata"]


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS.keys())
def test_a_change_of_what_decides_printed_numbers_is_seen_and_undone(copy, alone, edit):
    edited(copy, edit)
    with pytest.raises(StoreError, match="irg verify --repair"):
        open_sweep(copy)
    with pytest.raises(StoreError, match="irg verify --repair"):
        prepare(copy, SWEEP)
    assert "zarr.json is damaged" in verify_store(copy).shared[0]
    verify_store(copy, repair=True)
    assert verify_store(copy).is_clean
    assert (copy / "zarr.json").read_bytes() == (alone / "zarr.json").read_bytes()


@pytest.fixture(scope="module")
def before(alone, tmp_path_factory):
    """A store of format 1, which has neither hash nor copy, nor places in checksums."""
    path = shutil.copytree(alone, tmp_path_factory.mktemp("before") / "copy.zarr")

    def edit(root):
        root["attributes"]["format"] = 1
        root["attributes"].pop("root_hash")
        root["attributes"].pop("revision")

    edited(path, edit)
    (path / "status" / COPY).unlink()
    store = Store(path)
    store.forget(*store.places())
    store.commit(*(run_point(SWEEP, *point) for point in store.places()))
    return path


@pytest.fixture
def old(before, tmp_path):
    return shutil.copytree(before, tmp_path / "old.zarr")


def test_a_store_of_format_1_is_read_gone_on_with_and_named(old, capsys):
    assert all(Store(old).is_intact(point) for point in Store(old).places())
    assert main(["verify", str(old)]) == 0
    assert "format 1 has no hash" in capsys.readouterr().out
    Store(old).forget(POINT)
    assert run_sweep(SWEEP, old, workers=1).computed == 1
    compact_store(old)
    assert verify_store(old).done == 9
    assert Store(old).attributes["format"] == 1


LEGACY_EDITS = {
    "an absurd shape": lambda root: arrays(root)["time"]["shape"].__setitem__(2, 10**12),
    "absurd chunks": lambda root: arrays(root)["time"]["chunk_grid"]["configuration"].update(
        chunk_shape=[1, 1, 10**9]
    ),
    "no chunks": lambda root: arrays(root)["status"]["chunk_grid"].pop("configuration"),
    "no friction": lambda root: root["attributes"]["conditions"].pop("friction"),
    "friction without end": lambda root: root["attributes"]["conditions"].update(friction=math.inf),
    "no title": lambda root: root["attributes"].pop("title"),
    "loads of another store": lambda root: root["attributes"].update(loads=[1.0]),
    "an unknown variable": lambda root: arrays(root).update(lime=arrays(root)["time"]),
    "a missing variable": lambda root: arrays(root).pop("rise_quantile"),
    "another type": lambda root: arrays(root)["time"].update(data_type="float32"),
    "a codec too few": lambda root: arrays(root)["time"]["codecs"].pop(),
    "a list": lambda root: root.update(attributes=[]),
}


@pytest.mark.parametrize("edit", LEGACY_EDITS.values(), ids=LEGACY_EDITS.keys())
@pytest.mark.parametrize("command", ["boundary", "verify"])
def test_metadata_that_cannot_be_are_refused_without_a_hash_too(old, capsys, edit, command):
    edited(old, edit)
    assert main([command, str(old)]) == 2
    assert "zarr.json is damaged" in capsys.readouterr().err


# A point's own files


def test_a_point_of_another_place_is_found(copy):
    """Every file of it, so that the data are whole, but of another load."""
    for file in copy.glob("*/c.2.1*"):
        shutil.copy(file, file.with_name(file.name.replace("c.2.1", "c.1.1")))
    (damage,) = verify_store(copy).damaged
    assert str(damage) == "250 N, 1 m/s: the data are not those that were computed"


def test_a_missing_chunk_of_a_done_point_is_no_number_to_any_reader(copy, capsys):
    (copy / "rise_quantile" / "c.1.1.0.0").unlink()
    with open_sweep(copy) as ds, pytest.raises(StoreError, match="rise_quantile cannot be read"):
        ds["rise_quantile"].load()
    assert main(["boundary", str(copy)]) == 2
    assert main(["plot", str(copy), "--kind", "diagram", "-o", f"{copy}.png"]) == 2
    assert capsys.readouterr().err.count("irg verify names what is damaged") == 2


def test_a_lost_field_is_damage_and_fields_never_asked_for_are_not(copy):
    (copy / "rise" / "c.1.1.0.0").unlink()
    with open_sweep(copy) as ds, pytest.raises(StoreError, match="rise cannot be read"):
        ds["rise"].load()
    for name in ("pressure", "wear_depth"):
        (copy / name / "c.1.1.0.0").unlink()
    with open_sweep(copy) as ds:
        assert ds["rise"].sel(load=250, velocity=1).isnull().all()
    assert verify_store(copy).damaged[0].point == POINT


def test_steps_added_later_are_no_damage_and_their_loss_is(copy):
    longer = tiny.full(loads=(150.0, 1500.0), velocities=(1.0,))
    store, point = prepare(copy, longer), Point(1500.0, 1.0)
    store.commit(run_point(longer, *point))
    with open_sweep(copy) as ds:
        assert ds["wear_volume"].notnull().sum("step").sel(load=1500, velocity=1) == 12
        assert ds["wear_volume"].sel(load=250, velocity=1).notnull().any()
    assert verify_store(copy).is_clean
    (copy / "wear_volume" / "c.3.1.1").unlink()
    with open_sweep(copy) as ds, pytest.raises(StoreError, match="wear_volume cannot be read"):
        ds["wear_volume"].load()
    assert verify_store(copy).damaged[0].reason == "wear_volume is missing"


@pytest.mark.parametrize("harm", [lambda file: file.unlink(), lambda file: file.write_bytes(b"")])
def test_a_status_that_is_lost_leaves_a_store_that_opens_and_is_found(copy, capsys, harm):
    harm(copy / "status" / "c.1.1")
    assert summary(copy).pending == 1
    with open_sweep(copy) as ds:
        assert ds["time"].sel(load=250, velocity=1).isnull().all()
    assert main(["verify", str(copy)]) == (copy / "status" / "c.1.1").exists()
    assert "complete, but without a status: 250 N, 1 m/s" in capsys.readouterr().out
    assert run_sweep(SWEEP, copy, workers=1).computed == 0
    assert Store(copy).is_done(POINT)


def test_a_status_lost_with_its_data_is_pending(copy):
    for name in ("status/c.1.1", "time/c.1.1.0"):
        (copy / name).write_bytes(b"")
    assert summary(copy).pending == 1
    assert run_sweep(SWEEP, copy, workers=1).computed == 1
    assert verify_store(copy).done == 9


def test_statuses_lost_in_a_large_chunk_cost_no_point(copy):
    compact_store(copy)
    (chunk,) = (file for file in (copy / "status" / "c").rglob("*") if file.is_file())
    chunk.write_bytes(b"")
    assert summary(copy).pending == 9
    assert run_sweep(SWEEP, copy, workers=1).computed == 0
    assert summary(copy).done == 9


@pytest.mark.parametrize("lost", ["message/c.1.1", "wall_time/c.1.1", "finished_at/c.1.1"])
def test_a_run_heals_what_belongs_to_a_point(copy, lost):
    (copy / lost).unlink()
    assert run_sweep(SWEEP, copy, workers=1).computed == 1
    assert verify_store(copy).is_clean


def test_a_run_heals_coordinates_and_the_copy_of_the_root(copy):
    (copy / "velocity" / "c.0").write_bytes(b"")
    (copy / "status" / COPY).write_bytes(b"")
    assert len(verify_store(copy).shared) == 2
    assert run_sweep(SWEEP, copy, workers=1).computed == 0
    assert verify_store(copy).is_clean


@pytest.mark.parametrize(
    "put",
    [Path.mkdir, os.mkfifo, lambda file: file.symlink_to("/dev/zero")],
    ids=["folder", "fifo", "device"],
)
def test_what_is_in_the_place_of_a_file_gives_way_to_it(copy, put):
    """A FIFO or a device would be read without an end, and a folder cannot be written over."""
    whole = (copy / "zarr.json").read_bytes()
    for file in (copy / "zarr.json", copy / "load" / "c.0", copy / "time" / "zarr.json"):
        file.unlink()
        put(file)
    with pytest.raises(StoreError, match="is not a file; irg verify --repair"):
        summary(copy)
    verify_store(copy, repair=True)
    assert (copy / "zarr.json").read_bytes() == whole
    assert verify_store(copy).is_clean


def test_a_folder_with_files_in_the_place_of_one_stays(copy):
    file = copy / "load" / "c.0"
    file.unlink()
    file.mkdir()
    (file / "mine").write_text("years of work")
    with pytest.raises(StoreError, match="not empty"):
        verify_store(copy, repair=True)
    assert (file / "mine").exists()


def test_a_copy_that_is_being_renewed_is_no_damage(tmp_path, monkeypatch):
    path = tmp_path / "tiny.zarr"
    store = prepare(path, tiny.sweep())
    (path / "status" / COPY).unlink()
    monkeypatch.setattr("pipeline.store.root.time.sleep", lambda _: renew_copy(store.path))
    assert verify_store(path).is_clean

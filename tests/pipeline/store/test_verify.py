"""Damage of stores: it is named, never read, and repaired."""

import errno
import itertools
import shutil

import pytest
import zarr

from pipeline.analysis.dataset import open_sweep
from pipeline.run.sweep import run_sweep
from pipeline.store.create import writing
from pipeline.store.place import Folder, StoreError
from pipeline.store.progress import summary
from pipeline.store.schema import COLUMNS, FIELDS
from pipeline.store.verify import verify_store
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    contents,
    done_points,
    killed_after,
)
from tests.pipeline.conftest import commit_all

SWEEP = tiny.full()
POINT, NEXT = Point(250.0, 1.0), Point(600.0, 1.0)
ALL = set(points(SWEEP))
ABOUT = ("message", "warning_flags", "wall_time", "steps")
OTHER = "the data are not those that were computed"


def chunks(path, *names):
    return sorted(itertools.chain.from_iterable((path / name).glob("c.*") for name in names))


def cut(file):
    file.write_bytes(file.read_bytes()[:-3])


def flip_in_the_middle(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


HARMS = [flip_in_the_middle, cut, lambda file: file.unlink()]


def reasons(damages):
    return {Point(damage.load, damage.velocity): damage.message for damage in damages}


def assert_repaired(path, damaged):
    """Let a repair make these points pending, and a run compute them as they were."""
    assert not verify_store(path, repair=True).is_clean
    assert verify_store(path).is_clean
    assert set(done_points(path)) == ALL - damaged
    with open_sweep(path) as ds:
        ds.load()
    commit(path, SWEEP, damaged)
    assert_is_as_computed(path, ALL)


def test_a_store_without_damage_is_clean_and_left_as_it_is(copy):
    before = contents(copy)
    for repair in (False, True):
        verification = verify_store(copy, repair)
        assert verification.is_clean
        assert verification.done == 9
        assert verification.without_status == ()
    assert contents(copy) == before


@pytest.mark.parametrize(
    ("name", "harm"),
    [
        ("mean_rise", HARMS[0]),
        ("checksum", HARMS[0]),
        ("message", HARMS[0]),
        ("wall_time", HARMS[2]),
    ],
)
def test_damage_to_data_is_named_and_computed_again(copy, name, harm):
    harm(*chunks(copy, name))
    verification = verify_store(copy)
    assert reasons(verification.damaged) == dict.fromkeys(ALL, f"{name} cannot be read")
    assert (verification.done, verification.shared) == (0, ())
    assert_repaired(copy, ALL)


def test_damage_to_a_field_costs_its_point_alone(copy):
    (copy / "rise" / "c.1.1.0.0").unlink()
    verification = verify_store(copy)
    assert reasons(verification.damaged) == {POINT: "rise cannot be read"}
    assert verification.done == 8
    assert_repaired(copy, {POINT})


def a_folder(file):
    file.unlink()
    file.mkdir()


def a_link_to_nowhere(file):
    file.unlink()
    file.symlink_to(file.with_name("nothing"))


def a_link_to_itself(file):
    file.unlink()
    file.symlink_to(file)


@pytest.mark.parametrize("harm", [a_folder, a_link_to_nowhere, a_link_to_itself])
@pytest.mark.parametrize(
    "name",
    ["mean_rise/c.0.0.0", "rise/c.1.1.0.0", "status/c.0.0", "load/c.0", "mean_rise/zarr.json"],
)
def test_what_cannot_be_read_now_is_named_and_nothing_is_changed(copy, irg, harm, name):
    """It may be sound: here are points that nobody can read for a while."""
    harm(copy / name)
    before = contents(copy)
    for command in (("verify", copy), ("verify", copy, "--repair")):
        said = irg(*command, code=2)
        assert f"{copy / name} cannot be read: " in said
        assert "nothing was changed" in said
    with pytest.raises(StoreError, match=f"{name} cannot be read: .*; nothing was changed"):
        run_sweep(SWEEP, copy, workers=1)
    assert contents(copy) == before


def test_what_a_repair_replaces_is_kept_and_no_value_made_up(copy):
    time, field = copy / "mean_rise" / "c.0.0.0", copy / "rise" / "c.1.1.0.0"
    flip_in_the_middle(time)
    flip_in_the_middle(field)
    flip_in_the_middle(copy / "load" / "c.0")
    names = [str(file.relative_to(copy)) for file in (time, field, copy / "load" / "c.0")]
    before = contents(copy)
    verify_store(copy, repair=True)
    kept = {
        name.split("/", 2)[2]: content
        for name, content in contents(copy).items()
        if name.startswith("damaged/")
    }
    assert {name: kept[name] for name in names if name in kept} == {
        name: before[name] for name in names if name != "rise/c.1.1.0.0"
    }
    assert not time.exists()
    assert field.read_bytes() == before["rise/c.1.1.0.0"]
    commit(copy, tiny.full(velocities=(0.75,)), ())  # which makes a larger store
    assert kept.items() <= {k.split("/", 2)[-1]: v for k, v in contents(copy).items()}.items()


def values(path, name):
    return zarr.open_group(path, mode="r+")[name]


def test_data_in_the_place_of_others_are_found(copy):
    shutil.copy(copy / "rise" / "c.2.1.0.0", copy / "rise" / "c.1.1.0.0")
    values(copy, "mean_rise")[0, 0, -1] += 1.0
    values(copy, "warning_flags")[0, 1] ^= 1
    others = Point(150.0, 0.5), Point(150.0, 1.0)
    assert reasons(verify_store(copy).damaged) == dict.fromkeys((POINT, *others), OTHER)


def test_points_in_the_places_of_each_other_are_found(copy):
    """Data with their checksums, with which they agree, but not with their place."""
    for name in (*COLUMNS, *FIELDS, "checksum", *ABOUT):
        array = values(copy, name)
        array[1, 1], array[2, 1] = array[2, 1], array[1, 1]
    assert reasons(verify_store(copy).damaged) == {POINT: OTHER, NEXT: OTHER}
    assert_repaired(copy, {POINT, NEXT})


@pytest.mark.parametrize(("name", "harm"), [("load", HARMS[1]), ("step", HARMS[2])])
def test_lost_coordinates_are_not_read_and_are_restored(copy, alone, name, harm):
    """The root has them too, and a hash over them."""
    harm(*chunks(copy, name))
    assert open_sweep(copy)[name].equals(open_sweep(alone)[name])
    verification = verify_store(copy, repair=True)
    assert verification.shared == (f"the coordinate {name} is damaged",)
    assert verify_store(copy).is_clean
    assert_is_as_computed(copy, ALL)


@pytest.mark.parametrize("name", ["time", "sliding_distance"])
def test_data_in_the_place_of_times_or_distances_are_computed_again(copy, name):
    """No other scene has one of these and not the other, so that the root is right all the same."""
    values(copy, name)[...] = 3.0
    for file in chunks(copy, "max_rise"):
        flip_in_the_middle(file)
    verification = verify_store(copy)
    assert verification.shared == (f"the coordinate {name} is damaged",)
    assert {*reasons(verification.damaged)} == ALL
    assert_repaired(copy, ALL)


@pytest.mark.parametrize(
    ("name", "harm", "with_data"),
    [("status", HARMS[0], True), ("status", HARMS[0], False), ("asked", HARMS[2], True)],
)
def test_lost_statuses_cost_no_sound_point(copy, name, harm, with_data):
    """Also if no point of the same chunk is sound."""
    harm(*chunks(copy, name))
    if not with_data:
        for file in chunks(copy, "mean_rise"):
            file.write_bytes(b"")
    verify_store(copy, repair=True)
    verification = verify_store(copy)
    assert verification.is_clean
    assert verification.done == (9 if with_data else 0)
    with open_sweep(copy) as ds:
        assert (ds["status"] == (1 if with_data else 0)).all()
    with writing(copy, SWEEP) as store:
        assert len(store.pending()) == (0 if with_data else 9)


@pytest.mark.parametrize("name", ["status", "asked"])
def test_statuses_that_cannot_be_read_are_no_clean_store(copy, name):
    cut(*chunks(copy, name))
    assert not verify_store(copy).is_clean
    with pytest.raises(StoreError, match="irg verify"):
        open_sweep(copy)
    with pytest.raises(StoreError, match="irg verify"):
        summary(copy)


def test_the_command_names_what_is_damaged(copy, irg):
    flip_in_the_middle(copy / "rise" / "c.1.1.0.0")
    document = irg("verify", copy, "--json", code=1)
    reason = "the data are not those that were computed"
    assert document["done"] == 8
    assert document["damaged"] == [
        {"load": 250.0, "velocity": 1.0, "message": reason, "place": "250 N, 1 m/s"}
    ]
    assert f"damaged: 250 N, 1 m/s: {reason}" in irg("verify", copy, "--repair", code=1)
    irg("verify", copy)
    irg("verify", copy.parent, code=2)


def test_damage_on_one_of_several_surfaces_is_named_and_repaired(tmp_path):
    path = tmp_path / "tiny.zarr"
    sweep = tiny.sweep(loads=(150.0,), velocities=(0.5,), variants=surfaces((1, 2)), fields=True)
    commit_all(path, sweep)
    cut(path / "pressure" / "c.1.0.0.0.0")
    cut(path / "realization" / "c.0")
    verification = verify_store(path, repair=True)
    assert list(map(str, verification.damaged)) == [
        "150 N, 0.5 m/s, surface 2: the data are not those that were computed"
    ]
    assert verification.shared == ("the coordinate realization is damaged",)
    assert verify_store(path).is_clean
    with open_sweep(path) as ds:
        assert ds["status"].values.ravel().tolist() == [1, 0]


def test_a_repair_that_is_killed_leaves_no_damaged_point_done(copy, monkeypatch):
    cut(copy / "mean_rise" / "c.0.0.0")
    harmed = shutil.copytree(copy, copy.with_name("harmed.zarr"))
    for count in itertools.count(0, 12):
        shutil.rmtree(copy)
        shutil.copytree(harmed, copy)
        with killed_after(monkeypatch, count) as was_killed:
            verify_store(copy, repair=True)
        before = set(done_points(copy))
        assert before == (ALL if count == 0 else set())
        verify_store(copy, repair=True)
        assert set(done_points(copy)) == set()
        with open_sweep(copy) as ds:
            ds.load()
        if not was_killed:
            assert count > 1
            return


@pytest.mark.parametrize("method", ["read", "keys", "put"])
def test_what_a_disk_refuses_is_an_error_of_the_store(copy, monkeypatch, method):
    (copy / "mean_rise" / "zarr.json").unlink()  # to be restored

    def refused(*_):
        raise PermissionError(errno.EACCES, "Permission denied")

    calls = {
        "status": lambda: summary(copy),
        "open": lambda: open_sweep(copy),
        "verify": lambda: verify_store(copy),
        "repair": lambda: verify_store(copy, repair=True),
        "write": lambda: commit(copy, SWEEP, [POINT]),
    }
    monkeypatch.setattr(Folder, method, refused)
    said = {}
    for name, call in calls.items():
        try:
            call()
        except StoreError as error:
            said[name] = str(error)
    expected = {"read": set(calls), "keys": {"open", "verify", "repair"}, "put": {"repair"}}
    assert said.keys() >= expected[method]
    assert all("Permission denied" in words for words in said.values())


def test_a_coordinate_whose_chunk_is_lost_is_named_and_written_again(copy):
    (copy / "load" / "c.0").unlink()
    found = verify_store(copy)
    assert (found.done, found.shared) == (9, ("the coordinate load is damaged",))
    verify_store(copy, repair=True)
    assert verify_store(copy).is_clean

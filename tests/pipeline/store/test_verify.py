"""`irg verify` names damage of stores, and one run restores the same bits."""

import itertools
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
import zarr

import pipeline
from pipeline import StoreError
from pipeline.store.create import writing
from pipeline.store.schema import path_of
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.crash.driver import computing
from tests.helpers import tiny
from tests.helpers.entries import bare_test
from tests.helpers.reported import Heard
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    commit_all,
    contents,
    killed_after,
    plain_values,
    record,
)

SWEEP = tiny.full()
ONE_LOAD = tiny.full(loads=(150.0,))
OTHER = "rise cannot be read"
SHORT = tiny.sweep(loads=(250.0,), velocities=tuple(np.linspace(0.5, 1.5, 16).tolist()))
LONG = tiny.sweep(loads=(250.0,), velocities=(*SHORT.velocities, 2.0))


def chunks(path, name):
    """Files of the chunks of a variable."""
    metadata = ("zarr.json",)
    return sorted(file for file in (path / path_of(name)).iterdir() if file.name not in metadata)


def flipped(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


def cut(file):
    file.write_bytes(file.read_bytes()[:-3])


# All columns are written in the same way, and so are flags: one array of each is enough.
HARMED = [
    *((flipped, name, LONG) for name in ("status", "message")),
    (flipped, "rise", ONE_LOAD),
    *((Path.unlink, name, LONG) for name in ("load", "mean_rise", "warning_flags")),
]


def resumed(path, sweep, **options):
    """Run a sweep with points from records; return its outcome and its messages."""
    messages = Heard()
    records = {point: record(point) for point in points(sweep)}
    with computing(records, pace=0.0, writes_each=False):
        return pipeline.run_sweep(sweep, path, progress=messages.hear, **options), messages


def stored(path):
    """All values of a store on disk by name, comparable bit for bit."""
    texts = ("message",)
    return {
        name: values.tolist() if name in texts else values.tobytes()
        for name, values in plain_values(path).items()
    }


def reasons(path):
    return {
        Point(damage.load, damage.velocity): damage.message
        for damage in pipeline.verify_store(path).damaged
    }


@pytest.fixture(scope="session")
def long(tmp_path_factory):
    """A store that has grown by a second chunk of points."""
    path = tmp_path_factory.mktemp("long") / "tiny.zarr"
    commit(path, SHORT)
    commit(path, LONG, [Point(250.0, 2.0)])
    return path


@pytest.mark.parametrize(("harm", "name", "sweep"), HARMED)
def test_damage_of_any_array_is_named_and_one_run_has_the_same_bits(
    long, tmp_path, harm, name, sweep
):
    path = tmp_path / "tiny.zarr"
    if sweep == LONG:
        shutil.copytree(long, path)
    else:
        commit(path, sweep)
    before = stored(path)
    harm(chunks(path, name)[-1])
    harmed = contents(path)
    verification = pipeline.verify_store(path)
    assert not verification.is_clean
    assert contents(path) == harmed
    outcome, messages = resumed(path, sweep)
    assert outcome.computed >= len(verification.damaged)
    if outcome.computed:
        (message,) = messages
        assert "damaged points or files, which are computed again" in message
    assert stored(path) == before
    assert pipeline.verify_store(path).is_clean


def test_a_result_without_a_value_is_named_at_its_point(long, tmp_path):
    path = shutil.copytree(long, tmp_path / "tiny.zarr")
    zarr.open_array(path / path_of("mean_rise"), mode="r+")[:, 0] = math.nan
    assert reasons(path) == {Point(250.0, 0.5): "mean_rise is missing"}


def test_statuses_and_coordinates_are_one_chunk_and_results_are_not(path):
    loads, velocities = np.linspace(100.0, 600.0, 40), np.linspace(0.5, 1.5, 41)
    commit(path, tiny.sweep(loads=tuple(loads.tolist()), velocities=tuple(velocities.tolist())), ())
    group = zarr.open_group(path, mode="r")
    is_whole = {name: array.chunks == array.shape for name, array in group.arrays()}
    assert is_whole["status"]
    assert is_whole["velocity"]
    assert not is_whole["mean_rise"]


def test_a_damaged_chunk_without_points_that_are_done_is_written_over(path):
    commit(path, ONE_LOAD, [Point(150.0, 1.0)])
    with writing(path, ONE_LOAD) as store:
        store.forget([Point(150.0, 1.0)])
    flipped(path / "mean_rise" / "c.0.0.0")
    assert resumed(path, ONE_LOAD)[0].done == 3
    assert pipeline.verify_store(path).is_clean


def test_a_store_that_is_half_done_is_as_sound_as_a_whole_one(path):
    """This holds after a kill between data and statuses, and in a store without data."""
    commit(path, ONE_LOAD, ())
    assert pipeline.verify_store(path).is_clean
    commit(path, ONE_LOAD, [Point(150.0, 0.5)])
    status = (path / "status" / "c.0.0").read_bytes()
    commit(path, ONE_LOAD, [Point(150.0, 1.0)])
    (path / "status" / "c.0.0").write_bytes(status)
    verification = pipeline.verify_store(path)
    assert (verification.done, verification.is_clean) == (1, True)
    assert resumed(path, ONE_LOAD)[0].computed == 2


@pytest.mark.parametrize("name", ["fields/rise/c.0.0.0.0", "status/c.0.0"])
def test_what_cannot_be_read_now_is_named_and_nothing_is_changed(copy, irg, name):
    """The file may be sound: here it is a link that cannot be read for a while."""
    (copy / name).unlink()
    (copy / name).symlink_to(copy / name)
    before = contents(copy)
    assert f"{copy / name} cannot be read: " in irg("verify", copy, code=2)
    with pytest.raises(StoreError, match=f"{name} cannot be read: "):
        pipeline.run_sweep(SWEEP, copy, workers=1)
    assert contents(copy) == before


def test_the_command_names_what_is_damaged(copy, irg):
    (copy / "fields/rise/c.1.1.0.0").unlink()
    document = irg("verify", copy, "--json", code=1)
    assert document["points"]["damaged"] == 1
    (record,) = document["damaged"]
    point = {"load [N]": 250.0, "velocity [m/s]": 1.0, "place": "250 N, 1 m/s"}
    assert record == point | {"message": OTHER}
    output = irg("verify", copy, code=1)
    assert f"damaged: 250 N, 1 m/s: {OTHER}" in output
    assert "irg run repairs it with the same scene" in output


def test_damage_on_one_of_several_surfaces_is_named(tmp_path):
    path = tmp_path / "tiny.zarr"
    sweep = tiny.sweep(
        loads=(150.0,), velocities=(0.5,), case_table=surface_table((1, 2)), fields=True
    )
    commit_all(path, sweep)
    (path / "fields/pressure/c.0.0.0.0").unlink()
    cut(path / "realization" / "c.0")
    verification = pipeline.verify_store(path)
    assert list(map(str, verification.damaged)) == [
        "150 N, 0.5 m/s, surface 1: pressure cannot be read"
    ]
    assert verification.shared == ("fields/pressure/c.0.0.0.0", "realization")


def test_a_run_that_is_killed_while_it_mends_loses_no_point(path, monkeypatch):
    harmed = path.with_name("harmed.zarr")
    commit(harmed, ONE_LOAD)
    cut(harmed / "mean_rise" / "c.0.0.0")
    for count in itertools.chain((0, 1), itertools.count(19, 19)):
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(harmed, path)
        with killed_after(monkeypatch, count) as was_killed:
            resumed(path, ONE_LOAD)
        assert resumed(path, ONE_LOAD)[0].done == 3
        assert_is_as_computed(path, points(ONE_LOAD))
        assert pipeline.verify_store(path).is_clean
        if not was_killed:
            assert count > 1
            return


def test_a_store_whose_tests_are_damaged_is_not_clean(path):
    commit_all(path, tiny.sweep(loads=(150.0,), velocities=(0.5,), tests=(bare_test(250.0, 1.0),)))
    assert pipeline.verify_store(path).is_clean
    for chunk in (path / "tests/mean_rise").rglob("c.*"):
        chunk.unlink()
    verification = pipeline.verify_store(path)
    assert not verification.damaged
    assert len(verification.tests.damaged) == 1
    assert not verification.is_clean

"""What a store counts, notes and keeps beside the numbers of points."""

import pytest
import xarray as xr

import pipeline
from pipeline.store import create
from pipeline.store.create import writing
from pipeline.store.place import StoreError
from pipeline.sweep.model import Point
from pipeline.sweep.stages import Progress
from tests.helpers import tiny
from tests.helpers.stores import commit, make

SWEEP, POINT = tiny.full(), Point(250.0, 1.0)


def test_progress_of_a_verification_counts_points_that_are_done(path):
    commit(path, SWEEP, [POINT, Point(600.0, 1.0)])
    told = []
    pipeline.verify_store(path, progress=told.append)
    assert told == [Progress(done=2, total=2)]


def test_a_store_has_as_many_points_as_its_most_and_no_more(path, monkeypatch):
    make(path, SWEEP)
    monkeypatch.setattr(create, "MOST_POINTS", 9)
    with pytest.raises(StoreError, match=r"would have 12 points; a store has at most 9e\+00"):
        make(path, tiny.full(velocities=(2.0,)))


@pytest.mark.parametrize(("changes", "steps"), [({}, 13), ({"steps": "end"}, 1)])
def test_a_course_has_room_for_the_steps_of_twice_the_reference_load(path, changes, steps):
    make(path, tiny.full(**changes))
    with xr.open_zarr(path, chunks=None) as ds:
        assert ds["step"].values.tolist() == [*range(1 - steps, 1)]


def test_versions_that_computed_are_noted_once(path, monkeypatch):
    commit(path, SWEEP, [POINT])
    for version in ("1.0", "1.0", "2.0"):
        monkeypatch.setattr(create, "package_versions", lambda v=version: {"numpy": v})
        with writing(path, SWEEP):
            pass
    first, *later = pipeline.open_sweep(path).attrs["history"].splitlines()
    assert first.startswith("computed by irg-transition")
    assert [line.split(": ")[1] for line in later] == [
        "computed by numpy 1.0",
        "computed by numpy 2.0",
    ]


def test_what_a_command_caches_is_kept_by_a_run_alone(copy):
    keeper = pipeline.open_sweep(copy)["status"].encoding["keeper"]
    keeper.keep("a", b"content")
    assert keeper.kept("a") is None
    keeper.may_keep = True
    keeper.keep("a", b"content")
    assert keeper.kept("a") == b"content"
    assert pipeline.verify_store(copy).is_clean

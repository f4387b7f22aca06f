"""What a store counts, notes and keeps beside the numbers of points."""

import pytest
import xarray as xr

import pipeline
from tests.helpers import tiny
from tests.helpers.stores import make


@pytest.mark.parametrize(("changes", "steps"), [({}, 13), ({"steps": "end"}, 1)])
def test_a_course_has_room_for_the_steps_of_twice_the_reference_load(path, changes, steps):
    make(path, tiny.full(**changes))
    with xr.open_zarr(path, chunks=None) as ds:
        assert ds["step"].values.tolist() == [*range(1 - steps, 1)]


def test_what_a_command_caches_is_kept_by_a_run_alone(copy):
    keeper = pipeline.open_sweep(copy)["status"].encoding["keeper"]
    keeper.keep("a", b"content")
    assert keeper.kept("a") is None
    keeper.may_keep = True
    keeper.keep("a", b"content")
    assert keeper.kept("a") == b"content"
    assert pipeline.verify_store(copy).is_clean

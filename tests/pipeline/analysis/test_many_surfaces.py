"""Reading a sweep over many surfaces takes no look at its store for each of them."""

import numpy as np
import pytest

import pipeline
from pipeline.analysis import results
from pipeline.analysis.results import Results
from pipeline.store.snapshot import Snapshot
from pipeline.sweep.model import Point
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all

SEEDS = tuple(range(6))
CHOSEN = tuple(
    Point(load, velocity, seed)
    for seed in SEEDS
    for load in (250.0, 600.0)
    for velocity in (0.5, 1.5)
    if seed != 4 or velocity == 1.5
)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("many") / "out.zarr"
    sweep = tiny.sweep(increments=3, realizations=SEEDS, chosen=CHOSEN, velocities=(0.5, 1.5))
    commit_all(path, sweep, skip=CHOSEN[-1:])
    return path


@pytest.mark.parametrize("at_once", [1, 4, 100])
def test_each_surface_is_as_if_it_were_alone(store, monkeypatch, at_once):
    ds = pipeline.open_sweep(store)
    monkeypatch.setattr(results, "_READ", at_once * ds["rise_quantile"].nbytes / len(SEEDS))
    found = pipeline.boundary(ds)
    for seed in SEEDS:
        alone = pipeline.boundary(pipeline.open_sweep(store).sel(realization=seed))
        of_all = found.sel(realization=seed)
        for name in alone.data_vars:
            assert np.array_equal(alone[name], of_all[name], equal_nan=True), name
    missing = found["missing_at_load"].sum("load")
    assert missing.sel(realization=SEEDS[-1]) == 1
    assert missing.sum() == found.attrs["missing_points"] == 1


def test_the_store_is_looked_at_as_often_for_many_as_for_few(store, monkeypatch):
    looks = []
    is_current = Snapshot.is_current
    monkeypatch.setattr(Snapshot, "is_current", lambda self: looks.append(1) or is_current(self))
    ds = pipeline.open_sweep(store)
    counts = []
    for part in (ds.isel(realization=slice(0, 2)), ds):
        looks.clear()
        pipeline.boundary(part)
        pipeline.warned(part)
        counts.append(len(looks))
    assert counts[0] == counts[1] > 0


def test_what_was_chosen_is_read_from_text_and_from_lists(store):
    ds = pipeline.open_sweep(store).sel(realization=4)
    lists = ds.assign_attrs(chosen=[list(point[:3]) for point in CHOSEN])
    for source in (ds, lists, Results.of(store).on_surface(4)):
        asked = Results.of(source).asked()
        assert asked.tolist() == [[False, False], [False, True], [False, True]]

"""A sweep over many surfaces is judged as each of them alone."""

import numpy as np
import pytest

import pipeline
from pipeline.analysis.dataset import asked
from pipeline.sweep.model import Point
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all

SEEDS = tuple(range(6))
CHOSEN = tuple(
    Point(load, velocity, (("realization", seed),))
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


def test_each_surface_is_as_if_it_were_alone(store):
    ds = pipeline.open_sweep(store)
    crossings = pipeline.boundary(ds)
    for seed in SEEDS:
        alone = pipeline.boundary(pipeline.open_sweep(store).sel(realization=seed))
        of_all = crossings.sel(realization=seed)
        for name in alone.data_vars:
            assert np.array_equal(alone[name], of_all[name], equal_nan=True), name
    missing = crossings["missing_at_load"].sum("load")
    assert missing.sel(realization=SEEDS[-1]) == 1
    assert missing.sum() == crossings.attrs["missing_points"] == 1


def test_points_are_asked_for_on_their_own_surface(store):
    wanted = asked(pipeline.open_sweep(store)).sel(realization=4)
    assert wanted.values.tolist() == [[False, False], [False, True], [False, True]]

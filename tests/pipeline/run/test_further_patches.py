"""Further patches at points beside the boundary: which points, what they bring, and what grows."""

import numpy as np
import pytest

import pipeline
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny
from tests.helpers.scenes import SCENE

SEEDS = (1, 2, 3, 4)
VELOCITIES = (0.5, 1.0, 2.0, 3.0)


def several():
    return tiny.sweep(variants=surfaces(SEEDS), velocities=VELOCITIES)


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    path = tmp_path_factory.mktemp("beside") / "beside.zarr"
    outcome = pipeline.run_sweep(several(), path, workers=1, further_patches=True)
    loads = len(tiny.LOADS)
    assert outcome.computed == outcome.done == loads * (len(VELOCITIES) + len(SEEDS) - 1)
    return path


def test_the_first_patch_is_whole_and_others_have_the_point_nearest_to_the_boundary(beside):
    ds = pipeline.open_sweep(beside)
    done = ds["status"].transpose("realization", "load", "velocity").values == DONE
    assert done[0].all()
    first = pipeline.results(pipeline.at(ds, realization=SEEDS[0]))
    y = np.log(first.rises(first.conditions) / 1200.0)
    nearest = np.abs(y).argmin(axis=-1)
    for patch in done[1:]:
        np.testing.assert_array_equal(patch, np.eye(len(VELOCITIES), dtype=bool)[nearest])
    assert pipeline.summary(beside).left_out == (~done).sum()
    assert pipeline.boundary(ds).attrs["missing_points"] == 0


def test_a_later_run_computes_the_rest_and_the_boundary_hardly_moves(beside, tmp_path):
    few = pipeline.boundary(beside)
    grown = pipeline.run_sweep(several(), tmp_path / "all.zarr", workers=2, source=beside)
    assert grown.done == grown.total == len(tiny.LOADS) * len(VELOCITIES) * len(SEEDS)
    whole = pipeline.boundary(tmp_path / "all.zarr")
    moved = np.abs(few["critical_velocity"] / whole["critical_velocity"] - 1)
    surface = whole["surface_error"]
    assert moved.notnull().any()
    assert (moved.fillna(0.0) < surface.fillna(1.0)).all()
    alone = pipeline.boundary(pipeline.at(beside, realization=SEEDS[0]))
    assert (surface < alone["surface_error"]).sel(load=moved["load"][moved.notnull()]).all()


def test_without_a_crossing_the_points_nearest_to_one_are_taken(tmp_path):
    slow = tiny.sweep(variants=surfaces(SEEDS[:2]), velocities=(0.05, 0.1, 0.2))
    pipeline.run_sweep(slow, tmp_path / "slow.zarr", workers=1, further_patches=True)
    done = pipeline.open_sweep(tmp_path / "slow.zarr")["status"].sel(realization=2) == DONE
    assert done.sel(velocity=0.2).all()
    assert not done.sel(velocity=0.1).any()
    assert FAILED not in pipeline.open_sweep(tmp_path / "slow.zarr")["status"]


def test_the_command_counts_patches_and_refuses_them_twice(tmp_path, irg):
    scene, out = tmp_path / "scene.toml", tmp_path / "out.zarr"
    scene.write_text(SCENE.replace("fields = true", ""))
    document = irg("run", scene, "--patches", "2", "-o", out, "--workers", "1", "--json")
    assert (document["points"], document["done"]) == (18, 12)
    assert "12 of 18 points, the rest left out" in irg("status", out)
    twice = irg("run", scene, "--patches", "2", "--set", "sweep.realizations=3", code=2)
    assert "--patches gives sweep.realizations" in twice


def test_a_plain_run_into_a_store_of_patches_names_the_option(beside):
    with pytest.raises(pipeline.StoreMismatchError, match="irg run SCENE --patches N"):
        pipeline.run_sweep(tiny.sweep(velocities=VELOCITIES), beside, workers=1)

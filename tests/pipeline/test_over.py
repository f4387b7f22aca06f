"""Entries with several values (``[sweep] over``), from the scene to every answer."""

import numpy as np
import pytest

import pipeline
from pipeline import verify_store
from pipeline.answers.results import cases_of, sweep_of
from pipeline.sweep.plan import points
from tests.helpers import scenes
from tests.pipeline.conftest import commit_all

SCENE = scenes.SCENE.replace("increments = 10", "increments = 3").replace('"400 N", ', "")
OVER = '{ "pin.radius" = ["4 mm", "2 mm"] }'


def load(folder, over=OVER, scene=SCENE, **overrides):
    (folder / "scene.toml").write_text(scene.replace("fields = true", f"over = {over}"))
    return pipeline.load_scene(folder / "scene.toml", overrides=overrides)


def alone(folder, **entries):
    """Load the scene without `over`, with some entries replaced."""
    (folder / "alone.toml").write_text(SCENE.replace("fields = true", ""))
    names = {name.replace("_", ".", 1): value for name, value in entries.items()}
    return pipeline.load_scene(folder / "alone.toml", overrides=names)


def same(one, other):
    for name in set(other.data_vars) - {"wall_time"}:
        np.testing.assert_array_equal(one[name].values, other[name].values, name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("over")


@pytest.fixture(scope="module")
def swept(folder):
    """Path of the store of a sweep over two radii."""
    sweep = load(folder)
    outcome = pipeline.run_sweep(sweep, folder / "out.zarr", workers=1)
    assert (outcome.done, outcome.total, outcome.failed) == (len(points(sweep)),) * 2 + ((),)
    return folder / "out.zarr"


def test_each_value_gives_the_numbers_of_a_scene_that_has_it_bit_for_bit(swept, folder):
    ds = pipeline.open_sweep(swept)
    assert not load(folder)._single_case().case_table.columns
    assert ds["pin_radius"].values.tolist() == [0.002, 0.004]
    assert ds["pin_radius"].attrs["units"] == "m"
    assert ds["max_rise"].dims == ("pin_radius", "load", "velocity", "step")
    boundaries = pipeline.boundary(ds)
    commit_all(folder / "alone.zarr", alone(folder, pin_radius="4 mm"))
    one, other = ds.sel(pin_radius=0.004), pipeline.open_sweep(folder / "alone.zarr")
    same(one, other)
    same(boundaries.isel(pin_radius=1), pipeline.boundary(other))
    assert cases_of(ds)[1].sweep.scene == sweep_of(other).scene
    assert not np.array_equal(*boundaries["critical_velocity"].values, equal_nan=True)
    assert verify_store(swept).is_clean


def test_a_value_is_chosen_or_asked_for(swept, folder, irg):
    chosen = irg("boundary", swept, "--at", "pin.radius=4 mm", "--json")
    assert chosen == [
        row for row in irg("boundary", swept, "--json") if row.pop("pin radius [mm]") == 4
    ]
    said = irg("plot", swept, "--kind", "temperature", code=2)
    assert "select one by pin_radius" in said
    for words in (("boundary",), ("plot", "-o", folder / "d.png")):
        said = irg(*words, swept, "--at", "pin.radius=3 mm", code=2)
        assert "pin.radius is 3 mm; the sweep has 2 mm, 4 mm" in said

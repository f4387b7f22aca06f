"""Entries with several values (``[sweep] over``), from the scene to every answer."""

import numpy as np
import pytest

import pipeline
from pipeline.store.verify import verify_store
from tests.pipeline.cli.test_commands import SCENE

RADII = ("2 mm", "4 mm")


def load(folder, over='"pin.radius" = ["4 mm", "2 mm"]', more="", scene=SCENE, **overrides):
    path = folder / "scene.toml"
    path.write_text(scene.replace("fields = true", f"over = {{ {over} }}\n{more}"))
    return pipeline.load_scene(path, overrides=overrides)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("over")
    sweep = load(folder, more="fields = true")
    outcome = pipeline.run_sweep(sweep, folder / "out.zarr", workers=1)
    assert (outcome.done, outcome.failed) == (2 * len(sweep.loads) * len(sweep.velocities), ())
    return folder


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A store for each radius, of scenes that have it set."""
    folder = tmp_path_factory.mktemp("alone")
    (folder / "scene.toml").write_text(SCENE)
    stores = {}
    for radius in RADII:
        stores[radius] = folder / f"{radius[0]}.zarr"
        scene = pipeline.load_scene(folder / "scene.toml", overrides={"pin.radius": radius})
        pipeline.run_sweep(scene, stores[radius], workers=1)
    return stores


def same(one, other):
    for name in other.data_vars:
        if name not in ("wall_time", "finished_at"):
            np.testing.assert_array_equal(one[name].values, other[name].values)


def test_each_value_gives_the_numbers_of_a_scene_that_has_it_bit_for_bit(swept, alone):
    ds = pipeline.open_sweep(swept / "out.zarr")
    assert ds["pin.radius"].values.tolist() == [0.002, 0.004]
    assert ds["pin.radius"].attrs["units"] == "m"
    assert ds["max_rise"].dims == ("pin.radius", "load", "velocity", "step")
    for radius, store in alone.items():
        one, other = pipeline.at_entries(ds, {"pin.radius": radius}), pipeline.open_sweep(store)
        same(one, other)
        same(pipeline.boundary(one), pipeline.boundary(other))
    assert verify_store(swept / "out.zarr").is_clean

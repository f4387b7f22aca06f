"""Entries with several values (``[sweep] over``), from the scene to every answer."""

import numpy as np
import pytest

import pipeline
from pipeline.answers.results import cases_of, sweep_of
from tests.helpers import scenes
from tests.helpers.stores import commit_all

SCENE = scenes.SCENE.replace("increments = 10", "increments = 3").replace("fields = true", "")
FEW = {"sweep.loads": ["200 N", "600 N"]}
OVER = {"sweep.over": {"pin.radius": ["4 mm", "2 mm"]}}


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Store of a sweep over two radii, beside its scene."""
    folder = tmp_path_factory.mktemp("over")
    (folder / "scene.toml").write_text(SCENE)
    sweep = pipeline.load_scene(folder / "scene.toml", overrides=FEW | OVER)
    outcome = pipeline.run_sweep(sweep, folder / "out.zarr", workers=1)
    assert (outcome.done, outcome.total, outcome.failed) == (12, 12, ())
    return folder / "out.zarr"


def same(first, second):
    for name in set(second.data_vars) - {"wall_time"}:
        np.testing.assert_array_equal(first[name].values, second[name].values, name)


def test_each_value_gives_the_numbers_of_a_scene_that_has_it_bit_for_bit(swept, path):
    ds = pipeline.open_sweep(swept)
    assert ds["pin_radius"].values.tolist() == [0.002, 0.004]
    assert ds["pin_radius"].attrs["units"] == "m"
    assert ds["max_rise"].dims == ("pin_radius", "load", "velocity", "step")
    boundaries, entries = pipeline.boundary(ds), FEW | {"pin.radius": "4 mm"}
    commit_all(path, pipeline.load_scene(swept.with_name("scene.toml"), overrides=entries))
    other = pipeline.open_sweep(path)
    same(ds.sel(pin_radius=0.004), other)
    same(boundaries.isel(pin_radius=1), pipeline.boundary(other))
    assert cases_of(ds)[1].sweep.scene == sweep_of(other).scene
    assert not np.array_equal(*boundaries["critical_velocity"].values, equal_nan=True)


def test_a_value_is_chosen_or_asked_for(swept, irg):
    chosen, rows = irg("boundary", swept, "--at", "pin.radius=4 mm", "--json"), []
    for row in irg("boundary", swept, "--json"):
        rows += [row] if row.pop("pin radius [mm]") == 4 else []
    assert chosen == rows
    assert "select one by pin_radius" in irg("plot", swept, "--kind", "tests", code=2)
    for command in ("boundary", "plot"):
        output = irg(command, swept, "--at", "pin.radius=3 mm", code=2)
        assert "pin.radius 3 mm is not in the sweep, which has 2 mm, 4 mm" in output
    output = irg("boundary", swept, "--at", "temperature.critcal=150 degC", code=2)
    assert output.endswith('does not vary in this sweep (did you mean "temperature.critical"?)\n')


def test_a_row_is_chosen_by_the_label_under_a_printed_heading(tmp_path, irg):
    (tmp_path / "scene.toml").write_text(SCENE)
    rows = [
        {"place": place, "load": load, "velocity": "1 m/s"}
        for place, load in (("A", "200 N"), ("B", "300 N"), ("B", "400 N"))
    ]
    entries = {"without": ["sweep.loads", "sweep.velocities"], "sweep.along": rows}
    commit_all(
        store := tmp_path / "out.zarr",
        pipeline.load_scene(tmp_path / "scene.toml", overrides=entries),
    )
    (row,) = irg("margin", store, "--at", "place=A", "--json")
    assert row["load [N]"] == 200
    assert [row["load [N]"] for row in irg("margin", store, "--at", "place=B", "--json")] == [
        300,
        400,
    ]
    assert "place C is not in the sweep, which has A, B, B" in irg(
        "margin", store, "--at=place=C", code=2
    )

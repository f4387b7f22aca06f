"""Entries with several values (``[sweep] over``), from the scene to every answer."""

import numpy as np
import pytest

import pipeline
from pipeline import StoreMismatchError, verify_store
from pipeline.answers.results import cases_of, sweep_of
from pipeline.store.create import writing
from pipeline.sweep.plan import points, tasks
from tests.helpers import scenes
from tests.pipeline.conftest import commit_all
from tribo import InputError

SCENE = scenes.SCENE.replace("increments = 10", "increments = 3").replace('"400 N", ', "")
OVER = '{ "pin.radius" = ["4 mm", "2 mm"] }'
RADII = ("2 mm", "4 mm")


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


def test_values_are_added_to_a_store_and_an_interrupted_one_goes_on(tmp_path):
    store, small = tmp_path / "out.zarr", {"sweep.velocities": ["1 m/s", "2 m/s"]}
    first = load(tmp_path, '{ "pin.radius" = ["2 mm"] }', **small)
    commit_all(store, first, skip=points(first)[1:])
    again = load(tmp_path, '{ "pin.radius" = ["3 mm", "2 mm"] }', **small)
    outcome = pipeline.run_sweep(again, store, workers=1)
    assert (outcome.total, outcome.computed) == (len(points(again)), len(points(again)) - 1)
    ds = pipeline.open_sweep(store)
    assert ds["pin_radius"].values.tolist() == [0.002, 0.003]
    commit_all(tmp_path / "alone.zarr", alone(tmp_path, pin_radius="3 mm", **small))
    one = ds.sel(pin_radius=0.003)
    same(one, pipeline.open_sweep(tmp_path / "alone.zarr"))
    assert pipeline.run_sweep(first, store, workers=1).computed == 0


def test_several_entries_and_surfaces_give_their_product_and_share_contacts(tmp_path):
    over = '{ "friction.coefficient" = [0.08, 0.12], "pin.material" = ["hard", "100Cr6"] }'
    materials = SCENE.replace("[pin]", '[materials.hard]\nlike = "AISI 52100"\n[pin]')
    sweep = load(
        tmp_path, over, materials,
        **{"sweep.velocities": ["2 m/s"], "sweep.loads": ["600 N"], "sweep.realizations": [3, 4]},
    )  # fmt: skip
    assert list(sweep.case_table.axes) == ["friction_coefficient", "pin_material", "realization"]
    ramps = {task.ramp for task in tasks(points(sweep), sweep)}
    assert (len(points(sweep)), len(ramps)) == (8, 4)  # both frictions continue one ramp
    commit_all(tmp_path / "out.zarr", sweep)
    surfaces = {"sweep.realizations": [3, 4]}
    alone = '{ "friction.coefficient" = [0.1], "pin.material" = ["hard"] }'
    with (
        pytest.raises(
            StoreMismatchError, match=r"combination .*missing.* 0\.1, pin_material 100Cr6"
        ),
        writing(tmp_path / "out.zarr", load(tmp_path, alone, materials, **surfaces)),
    ):
        pass
    ds = pipeline.open_sweep(tmp_path / "out.zarr")
    assert ds["pin_material"].values.tolist() == ["hard", "100Cr6"]
    one = ds.sel(friction_coefficient=[0.12], pin_material=["hard"])
    assert cases_of(one)[0].sweep.conditions.friction == 0.12
    hottest = pipeline.temperatures(pipeline.end_of_point(ds))["max_temperature"]
    assert hottest.dims == (*sweep.case_table.axes, "load", "velocity")
    rises = hottest - 298.15
    ratio = rises.sel(friction_coefficient=0.12) / rises.sel(friction_coefficient=0.08)
    np.testing.assert_allclose(ratio.values, 1.5, rtol=1e-12)


def test_commands_answer_for_each_value(swept, folder, irg):
    said = irg("run", folder / "scene.toml", "-o", swept, "--workers", "1")  # nothing is left
    assert f"next: irg boundary {swept}" in said
    document = irg("boundary", swept, "--json")
    assert {row["pin radius [mm]"] for row in document} == {2.0, 4.0}
    place = ("--load", "500 N", "--velocity", "1.5 m/s")
    said = irg("margin", swept, *place)
    assert "pin radius 4 mm:" in said
    (one, other) = irg("margin", swept, *place, "--json")
    assert (one["pin radius [mm]"], other["pin radius [mm]"]) == (2.0, 4.0)
    assert one["temperature margin [K]"] < other["temperature margin [K]"]
    (folder / "duty.csv").write_text("load [N],velocity [m/s]\n500,1.5\n")
    table = pipeline.margin(swept, folder / "duty.csv")
    assert table["temperature_margin"].values.ravel().tolist() == pytest.approx(
        [one["temperature margin [K]"], other["temperature margin [K]"]], rel=1e-12
    )


def test_figures_and_pages_show_each_value_or_ask_for_one(swept, folder, irg):
    (legend,) = pipeline.plot(swept, "diagram", friction=0.12).legends
    assert [text.get_text() for text in legend.get_texts()][:2] == list(RADII)
    assert "friction 0.12, bulk temperature 25" in legend.get_title().get_text()
    said = irg("plot", swept, "--kind", "temperature", code=2)
    assert "select one by pin_radius" in said
    with pytest.raises(InputError, match="the sweep has no realization 1"):
        pipeline.run_point(load(folder, OVER + "\nrealizations = 2"), 600.0, 1.5, realization=1)
    for words in (("boundary",), ("plot", "-o", folder / "d.png")):
        said = irg(*words, swept, "--at", "pin.radius=3 mm", code=2)
        assert "pin.radius is 3 mm; the sweep has 2 mm, 4 mm" in said

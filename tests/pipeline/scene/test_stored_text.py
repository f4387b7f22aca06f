"""A store keeps a sweep as plain data in SI."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pipeline
import tribo
from pipeline.answers.results import sweep_of
from pipeline.scene import library
from pipeline.scene.format import RandomSurface
from pipeline.scene.tables import table_of
from pipeline.shipped import shipped_scenes
from pipeline.store.create import writing
from pipeline.sweep.case_table import surfaces
from pipeline.sweep.stored import SweepDataError
from tests.helpers import synthetic, tiny
from tests.helpers.entries import rows
from tests.helpers.scenes import SCENE, STEEL
from tests.helpers.stored import file_contents, parse_sweep, sweep_text
from tests.helpers.stores import places


def back(sweep):
    """Sweep read again from its stored data."""
    return parse_sweep(sweep_text(sweep), file_contents(sweep))


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_shipped_scene_comes_back_equal(name):
    sweep = pipeline.load_scene(name)
    again = back(sweep)
    assert again == sweep
    assert hash(again.scene) == hash(sweep.scene)


RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 750.0]))
SCANNED = tribo.MeasuredRoughness(1e-7 * np.random.default_rng(0).standard_normal((32, 16)))


FORGED = st.sampled_from(
    [
        *(None, True, -1, 10**400, 1e300, "text", [], {}, [1.0, 2.0]),
        {"law": "os:system", "source_sha256": "0"},
        {"file": "/etc/passwd"},
    ]
)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_a_forged_text_is_an_error_or_another_sweep(data):
    text = sweep_text(tiny.sweep(case_table=surfaces((1, 2))))
    document = [json.loads(text)]
    path = (0, *data.draw(st.sampled_from([*places(document[0])])))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = data.draw(FORGED)
    try:
        sweep = parse_sweep(json.dumps(document[0]), {})
    except SweepDataError:
        return
    assert repr(sweep)


SWEEP = """
[sweep]
loads = ["200 N"]
velocities = ["1 m/s", "2 m/s"]
"""


@pytest.fixture
def own(tmp_path):
    """A scene with a default, a preset and values of the library."""
    text = SCENE.replace("seed = 0\n", "").replace("[materials.steel]", "[materials.other]")
    text = text.replace('"steel"', '"AISI 52100"').partition("[fidelity]")[0] + SWEEP
    path = tmp_path / "own.toml"
    path.write_text(text)
    return path


def change_a_default(monkeypatch):
    keys = table_of(RandomSurface).keys
    monkeypatch.setitem(keys, "seed", keys["seed"]._replace(default=1))


def change_a_preset(monkeypatch):
    finer = replace(tribo.PRESETS["standard"], contact_tolerance=1e-3)
    monkeypatch.setitem(tribo.PRESETS, "standard", finer)


def change_the_library(monkeypatch):
    steel = library.library()["materials"]["AISI 52100"]
    monkeypatch.setitem(steel, "density", ["7000 kg/m^3", steel["density"][1]])


@pytest.mark.parametrize(
    ("change", "entry"),
    [
        (change_a_default, "disk.roughness.seed: 0 in the store, 1 in the scene"),
        (change_a_preset, "fidelity.contact_tolerance: 0.12 in the store, 0.001 in the scene"),
        (change_the_library, "material of the pin.density: "),
    ],
)
def test_a_store_keeps_its_meaning_when_the_program_changes(
    own, tmp_path, monkeypatch, change, entry
):
    sweep = pipeline.load_scene(own)
    path = tmp_path / "own.zarr"
    with writing(path, sweep):
        pass
    change(monkeypatch)
    again = sweep_of(pipeline.open_sweep(path))
    assert again == sweep
    assert again.preset == sweep.preset == "standard"
    new = pipeline.load_scene(own)
    assert new != sweep
    with pytest.raises(pipeline.StoreMismatchError) as told, writing(path, new):
        pass
    assert entry in str(told.value)


def test_sweeps_are_equal_if_their_entries_mean_the_same():
    one, other = (
        pipeline.load_scene("first_try", overrides={"disk.roughness.correlation_length": length})
        for length in ("4 um", "0.004 mm")
    )
    assert one == other
    assert one.source.entries != other.source.entries
    assert one != one.changed("pin.radius", "1 mm")


def test_a_stored_sweep_made_coarser_keeps_no_promise_of_its_preset():
    scene = pipeline.load_scene("first_try")
    assert back(scene).preset == "standard"
    for path, value in (("pixels_per_element", 16), ("increments", 2), ("fewest_elements", 1)):
        assert back(scene.changed(f"fidelity.{path}", value)).preset is None
    assert back(scene.changed("fidelity.preset", "fine")).preset == "fine"
    with pytest.raises(tribo.InputError, match="cannot be changed in the sweep of a store"):
        back(scene).changed("fidelity.preset", "fine")


def test_a_surface_whose_heights_are_not_at_hand_says_so():
    sweep = parse_sweep(sweep_text(tiny.full(roughness=SCANNED)), {})
    with pytest.raises(tribo.InputError, match="are missing; open the store"):
        sweep.scene.roughness.heights(sweep.scene.pixels)
    assert sweep.conditions == tiny.full().conditions
    assert sweep._scene_hashes == tiny.full(roughness=SCANNED)._scene_hashes


def test_rows_of_files_are_kept_with_what_was_read_of_them_and_joined(tmp_path):
    names, rng = ("a.npy", "b.npy", "c.npy"), np.random.default_rng(0)
    for name in names:
        np.save(tmp_path / name, 1e-7 * rng.standard_normal((16, 48)))
    rough = 'file = "a.npy"\nheight_unit = "m"\npixel_size = ["8 um", "8 um"]\n\n'
    begin, end = SCENE.index("ra = "), SCENE.index("[window]")
    path = tmp_path / "scans.toml"
    path.write_text((SCENE[:begin] + rough + SCENE[end:]).replace("fields = true", ""))
    for some in (names[:2], names[1:]):
        over = {"sweep.over": {"disk.roughness.file": [*some]}}
        with writing(tmp_path / "scans.zarr", pipeline.load_scene(path, overrides=over)):
            pass
    for name in names:
        (tmp_path / name).unlink()
    ds = pipeline.open_sweep(tmp_path / "scans.zarr")
    copy = sweep_of(ds.drop_vars("inputs"))  # enough where no surface is needed
    assert copy.conditions == sweep_of(ds).conditions
    assert all("are missing" in str(copy.case(n).scene.roughness) for n in copy.case_table.names)
    sweep = sweep_of(ds)
    rows = [sweep.case(name).scene.roughness.digest for name in sweep.case_table.names]
    assert len({*rows}) == 3


@pytest.mark.parametrize(
    "sweep",
    [
        tiny.full(roughness=SCANNED),
        tiny.sweep(loading=RECORD),
        tiny.sweep(case_table=surfaces((7, 1))),
        tiny.sweep(
            case_table=rows("pin", {"a": {"pin": tribo.Cylinder(1e-3, 3e-3, STEEL)}, "b": {}})
        ),
        tiny.sweep(disk=replace(STEEL, hardness=math.inf)),
        synthetic.scene(oil=synthetic.OIL),
    ],
    ids=["scan", "record", "surfaces", "rows by hand", "elastic", "oil"],
)
def test_a_sweep_of_any_kind_comes_back_equal(sweep):
    again = back(sweep)
    assert again == sweep
    assert again.case_table.names == sweep.case_table.names

"""Scene files: their sweeps, and all their faults at once."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline import Conditions, SceneFileError, load_scene
from tests.helpers.entries import bare_test, changed
from tests.helpers.scenes import STEEL
from tests.helpers.stored import file_contents, parse_sweep, sweep_text
from tests.helpers.sweeps import sweep_of_fields
from tests.pipeline.scene.conftest import MEASURED_SURFACE, PAPER, ROUGHNESS, TEXT, WORKFLOWS

LOADS = '["200 N", "400 N", "600 N", "750 N"]'


def test_the_scene_of_the_paper_holds_the_papers_numbers():
    sweep = load_scene(WORKFLOWS / "irg_transition.toml")
    assert sweep == sweep_of_fields(
        pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
        disk=STEEL,
        pixels=tribo.Grid((576, 480), (0.816e-6, 0.95e-6), (False, True)),
        loading=tribo.Ramp(rate=150.0, reference_load=750.0),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=0),
        wear=tribo.Wear(1.2e-15, "swept"),
        oil=tribo.Oil((32e-6, 5e-6), 866.0, 2e-8),
        fidelity=tribo.PRESETS["standard"],
        name="irg_transition",
        title=sweep.title,
        loads=tuple(200.0 + 50.0 * i for i in range(12)),
        velocities=tuple(0.5 + 0.25 * i for i in range(19)),
        conditions=Conditions(0.1, 298.15, 418.15),
        friction_band=(0.09, 0.103),
        tests=(
            bare_test(750.0, 1.25, 0.103, number="1"),
            bare_test(600.0, 1.5, 0.1, number="2"),
            bare_test(400.0, 2.25, 0.091, number="3"),
            bare_test(200.0, 3.75, 0.094, number="4"),
        ),
        fields=True,
        preset="standard",
    )
    assert sweep.scene.grid.shape == (288, 240)
    assert sweep.scene.grid.spacing == pytest.approx((1.632e-6, 1.9e-6), rel=1e-15)


@pytest.mark.parametrize("path", sorted(WORKFLOWS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_scene_loads_says_what_it_shows_and_comes_back_from_a_store(path):
    sweep = load_scene(path)
    header = path.read_text(encoding="utf-8").split("\n\n")[0]
    assert all(word in header for word in ("# Shows", "# Expect", "# Costs"))
    reread = parse_sweep(sweep_text(sweep), file_contents(sweep))
    for other in (pickle.loads(pickle.dumps(sweep)), reread):
        assert (other, hash(other.scene)) == (sweep, hash(sweep.scene))


def test_a_range_gives_the_same_numbers_as_writing_them_out(read):
    written = 'from = "1 m/s", to = "4 m/s", step = "0.6 m/s"'
    sweep = read((written, 'from = "0 m/s", to = "2 m/s", step = "0.1 m/s"'))
    assert sweep.velocities == tuple(float(f"{i // 10}.{i % 10}") for i in range(21))
    sweep = read((written, 'from = "36 km/h", to = "37 km/h", step = "0.5 km/h"'))
    assert sweep.velocities == pytest.approx((10.0, 36.5 / 3.6, 37 / 3.6), rel=1e-15)
    sweep = read((written, 'from = "1 m/s", to = "4 m/s", count = 3'))
    assert sweep.velocities == (1.0, 2.5, 4.0)


PINS = {  # pin, and whether the window is periodic along y and the contact swept over
    "cylinder": ({}, lambda steel: tribo.Cylinder(2e-3, 3.4e-3, steel), True, False),
    "ball": ({"without": "pin.length", "wear": {"pattern": "local"}},
             lambda steel: tribo.Ball(2e-3, steel), False, False),
    "crowned": ({"without": "pin.length", "pin.crown_radius": "8 cm"},
                lambda steel: tribo.Crowned(2e-3, 80e-3, steel), False, True),
}  # fmt: skip


@pytest.mark.parametrize("shape", PINS)
def test_a_pin_has_a_free_or_periodic_window_and_is_swept_over(read, shape):
    entries, pin, is_periodic, is_swept = PINS[shape]
    scene = read(overrides=entries | {"pin.shape": shape}).scene
    assert scene.pin == pin(scene.disk)
    assert scene.pixels.periodic == (False, is_periodic)
    assert scene.sweeps_over == is_swept


def seeds(realizations, **entries):
    scene = load_scene("first_try", overrides={"sweep.realizations": realizations} | entries)
    names = [dict(name)["realization"] for name in scene.case_table.names]
    return names, scene.scene.roughness.seed


def test_realizations_begin_at_the_seed_of_the_scene_or_are_those_given():
    assert seeds(3, **{"disk.roughness.seed": 5}) == ([5, 6, 7], 5)
    assert seeds(2, without=["disk.roughness.seed"]) == ([0, 1], 0)
    assert seeds([9, 4], **{"disk.roughness.seed": 5}) == ([4, 9], 4)


def test_the_slide_roll_ratio_of_a_faster_pin_may_be_uncertain():
    entries = {"motion.slide_roll_ratio": -0.5, "uncertainty": {"motion.slide_roll_ratio": "5 %"}}
    sweep = load_scene("first_try", overrides={"without": ["tests"]} | entries)
    assert sweep.base.uncertainty == ((("motion.slide_roll_ratio",), 0.05),)


def test_what_may_be_left_out_takes_its_default(read):
    paths = ["title", "materials.steel.hardness", "disk.roughness", "wear", "friction.band",
             "temperature.critical_area_fraction", "fidelity", "sweep.fields", "tests"]  # fmt: skip
    sweep = read(overrides={"without": paths})
    assert sweep.title == "scene"
    assert sweep.scene.hardness == math.inf
    assert sweep.scene.roughness is sweep.scene.wear is sweep.base.friction_band is None
    assert sweep.conditions.critical_area_fraction == 0.1
    assert (sweep.preset, sweep.scene.fidelity) == ("standard", tribo.PRESETS["standard"])
    assert not sweep.fields
    assert sweep.tests == ()


def test_a_preset_asked_for_replaces_the_files_fidelity_and_overrides_come_last(read):
    standard = tribo.PRESETS["standard"]
    own_numbers = (
        'preset = "standard"',
        'preset = "standard"\nincrements = 30\nfewest_elements = 50',
    )
    for changes, arguments, preset, fidelity in (
        ([], {}, "standard", {}),
        ([own_numbers], {}, None, {"increments": 30, "fewest_elements": 50}),
        ([own_numbers], {"preset": "standard"}, "standard", {}),
        (
            [own_numbers],
            {"preset": "standard", "overrides": {"increments": 40}},
            None,
            {"increments": 40},
        ),
        ([], {"overrides": {"contact_tolerance": standard.contact_tolerance}}, "standard", {}),
    ):
        sweep = read(*changes, **arguments)
        assert (sweep.preset, sweep.scene.fidelity) == (preset, replace(standard, **fidelity))


def test_a_measured_load_stands_in_place_of_the_ramp(read, faults, tmp_path):
    rows = "time [ms], load [kN]\n0, 0\n2000, 0.4\n5000, 0.8\n"
    (tmp_path / "record.csv").write_text(rows)
    times, loads = np.array([0.0, 2.0, 5.0]), np.array([0.0, 400.0, 800.0])
    ramp, record = 'rate = "150 N/s"\nreference_load = "750 N"', 'file = "record.csv"'
    assert read((ramp, record)).scene.loading == tribo.MeasuredLoad(times, loads)
    record += '\nreference_load = "500 N"'
    (fault,) = faults((ramp, record.replace("500", "900")))
    assert fault.startswith("loading.file: ")
    assert "reaches 800 N" in fault


BRASS = """
[materials.brass]
elastic_modulus = "100 GPa"
poisson_ratio = 0.34
hardness = "1.2 GPa"
density = "8500 kg/m^3"
specific_heat = "380 J/(kg K)"
thermal_conductivity = "110 W/(m K)"
"""


def test_a_material_that_no_part_has_is_noted(read):
    unused = "materials.brass: no part has this material; set pin.material = "
    assert [note.text.partition('"')[0] for note in read(("[pin]", f"{BRASS}[pin]")).notes] == [
        unused
    ]
    for path, value in (
        ("disk.material", "brass"),
        ("sweep.over", {"pin.material": ["brass", "steel"]}),
    ):
        assert read(("[pin]", f"{BRASS}[pin]"), overrides={path: value}).notes == ()
    assert load_scene("mtm").notes == ()  # the scene that it extends has its own steel


FAULTS = {  # scene, other entries, and the keys that are named
    "empty": ("", {}, "pin disk window loading friction temperature sweep"),
    "slips": (TEXT, {"waer.pattern": "local", "title.long": "x", "realizations": 3, "incremnts": 3},
              "incremnts realizations title waer"),
    "conflicts": (TEXT, {"window.pixels": [33, 33], "disk.diameter": "20 mm",
                         "temperature.critical": "20 degC"},
                  "window.pixels disk.width temperature.critical"),
}  # fmt: skip


@pytest.mark.parametrize("kind", FAULTS)
def test_all_faults_are_named_at_once(faults, kind):
    text, overrides, keys = FAULTS[kind]
    scene_faults = faults(text=text, overrides=overrides)
    fault_keys = [fault.partition(":")[0].partition(" ")[0] for fault in scene_faults]
    assert sorted(fault_keys) == sorted(keys.split())


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "irg_transition.toml"
    path.write_bytes(b"\xef\xbb\xbf" + PAPER.replace("\n", "\r\n").encode())
    assert load_scene(path) == load_scene(WORKFLOWS / "irg_transition.toml")


# A scene that extends another is the scene written in full.

EXTENDS = 'extends = "base.toml"\n'


@pytest.fixture
def write(tmp_path):
    """Write scenes; return the path of the last one."""
    (tmp_path / "base.toml").write_text(TEXT, encoding="utf-8")

    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name}.toml"
            path.write_text(text, encoding="utf-8")
        return path

    return write


def faults_of(path, **arguments):
    with pytest.raises(SceneFileError) as caught:
        load_scene(path, **arguments)
    return caught.value.faults


def test_a_scene_that_only_extends_is_the_other_under_its_own_name(write):
    sweep = load_scene(write(own=EXTENDS))
    assert sweep == changed(load_scene(write(base=TEXT)), name="own")


def test_what_an_inherited_entry_excludes_is_replaced_or_named(write):
    counted = EXTENDS + '[sweep]\nvelocities = { to = "4 m/s", count = 3 }'
    assert load_scene(write(own=counted)).velocities == (1.0, 2.5, 4.0)
    fault, *_ = faults_of(write(own=EXTENDS + '[disk.roughness]\nfile = "scan.npy"'))
    assert fault.startswith("disk.roughness.ra (from ")
    assert fault.endswith('leave it out here: without = ["disk.roughness.ra"]')


def test_files_are_looked_for_beside_the_scene_that_names_them(write, tmp_path):
    folder = tmp_path / "surfaces"
    folder.mkdir()
    np.save(folder / "surface.npy", np.eye(480))
    measured = TEXT.replace(ROUGHNESS, MEASURED_SURFACE)
    (folder / "base.toml").write_text(measured, encoding="utf-8")
    sweep = load_scene(write(own='extends = "surfaces/base.toml"'))
    np.testing.assert_array_equal(sweep.scene.roughness.array, np.eye(480) * 1e-6)
    fault, *_ = faults_of(
        write(own='extends = "surfaces/base.toml"\n[disk.roughness]\nfile = "surface.npy"')
    )
    assert str(tmp_path / "surface.npy") in fault


def test_a_shipped_scene_is_named_wherever_a_scene_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped = load_scene("first_try")
    (tmp_path / "mine.toml").write_text('extends = "first_try"\n')
    assert load_scene("mine.toml").loads == shipped.loads
    (tmp_path / "first_try").write_text('extends = "twin_disc"\n')  # files precede shipped scenes
    assert load_scene("first_try").scene.motion is not None


def test_a_scene_with_many_faults_lists_the_first_and_counts_the_others(tmp_path):
    test = '[[tests]]\nlod = "1 N"\nvelocty = "1 m/s"\n'
    (tmp_path / "a.toml").write_text('extends = "first_try"\n' + 4000 * test)
    with pytest.raises(SceneFileError, match=r"(?s)12000 faults.*and 11982 more"):
        load_scene(tmp_path / "a.toml")


ALLOWED = {
    "a band of one friction": {"friction.band": [0.1, 0.1]},
    "a rounded track": {"motion": {"slide_roll_ratio": 1, "disk_track_length": "40.3 mm"},
                        "disk.track_length": "40 mm"},
    "grids of cases": {"sweep.over": {"fidelity.pixels_per_element": [1, 2]},
                       "sweep.fields": False},
}  # fmt: skip


@pytest.mark.parametrize("name", ALLOWED)
def test_what_is_just_allowed_is_read(name):
    assert load_scene("first_try", overrides=ALLOWED[name]).loads

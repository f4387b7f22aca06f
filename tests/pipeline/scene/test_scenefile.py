"""Scene files: the sweep that they give, and every fault at once."""

import copy
import math
import pickle
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import tribo
from pipeline import Conditions, SceneFileError, Sweep, load_scene, to_si
from pipeline.scene.toml import text_of
from tests.helpers.entries import bare_test
from tests.helpers.sweeps import sweep_of_fields
from tests.pipeline.scene.conftest import PAPER, ROUGHNESS, TEXT, WORKFLOWS

LOADS = '["200 N", "400 N", "600 N", "750 N"]'
SMOOTH = ("[disk.roughness]\n" + ROUGHNESS, "")
BALL = ('shape = "cylinder"', 'shape = "ball"'), ('length = "3.4 mm"\n', "")


def test_the_scene_of_the_paper_holds_the_papers_numbers():
    sweep = load_scene(WORKFLOWS / "irg_transition.toml")
    steel = tribo.Material(
        elastic_modulus=210e9,
        poisson_ratio=0.3,
        thermal_conductivity=45.0,
        density=7800.0,
        specific_heat=470.0,
        hardness=6.6e9,
    )
    assert sweep == sweep_of_fields(
        pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=steel),
        disk=steel,
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
def test_every_shipped_scene_loads_and_says_what_it_shows(path):
    sweep = load_scene(path)
    assert sweep.name == path.stem
    header = path.read_text(encoding="utf-8").split("\n\n")[0]
    assert all(word in header for word in ("# Shows", "# Expect", "# Costs"))
    assert pickle.loads(pickle.dumps(sweep)) == sweep
    assert hash(sweep) == hash(load_scene(path))


def test_a_range_gives_the_same_numbers_as_writing_them_out(read):
    written = 'from = "1 m/s", to = "4 m/s", step = "0.6 m/s"'
    sweep = read((written, 'from = "0 m/s", to = "2 m/s", step = "0.1 m/s"'))
    assert sweep.velocities == tuple(float(f"{i // 10}.{i % 10}") for i in range(21))
    assert 0.3 in sweep.velocities
    assert 0.7 in sweep.velocities
    sweep = read((written, 'from = "36 km/h", to = "37 km/h", step = "0.5 km/h"'))
    assert sweep.velocities == pytest.approx((10.0, 36.5 / 3.6, 37 / 3.6), rel=1e-15)
    sweep = read((written, 'from = "1 m/s", to = "4 m/s", count = 3'))
    assert sweep.velocities == (1.0, 2.5, 4.0)


def test_what_may_be_left_out_takes_its_default(read):
    sweep = read(
        (TEXT[TEXT.index("title =") : TEXT.index("[materials")], ""),
        ('hardness = "6.6 GPa"\n', ""),
        SMOOTH,
        (TEXT[TEXT.index("[wear]") : TEXT.index("[friction]")], ""),
        ("band = [0.09, 0.103]\n", ""),
        ("critical_area_fraction = 0.1\n", ""),
        (TEXT[TEXT.index("[fidelity]") : TEXT.index("[sweep]")], ""),
        ("fields = true\n", ""),
        (TEXT[TEXT.index("[[tests]]") :], ""),
    )
    assert sweep.title == "scene"
    assert sweep.scene.hardness == math.inf
    assert sweep.scene.roughness is sweep.scene.wear is sweep.base.friction_band is None
    assert sweep.conditions.critical_area_fraction == 0.1
    assert (sweep.preset, sweep.scene.fidelity) == ("standard", tribo.PRESETS["standard"])
    assert not sweep.fields
    assert sweep.tests == ()


def test_a_ball_has_a_free_window_and_a_cylinder_a_periodic_one(read):
    local = ('"swept"', '"local"')
    assert read().scene.pixels.periodic == (False, True)
    assert read(*BALL, local).scene.pixels.periodic == (False, False)
    assert isinstance(read(*BALL, local).scene.pin, tribo.Ball)


def test_a_preset_asked_for_replaces_the_files_fidelity_and_overrides_come_last(read):
    entries = (
        'preset = "standard"',
        'preset = "standard"\nincrements = 30\nheat_model = "history"',
    )
    assert read().preset == "standard"
    sweep = read(entries)
    own = {"increments": 30, "heat_model": "history"}
    assert sweep.scene.fidelity == replace(tribo.PRESETS["standard"], **own)
    assert sweep.preset is None
    sweep = read(entries, preset="standard")
    assert (sweep.preset, sweep.scene.fidelity) == ("standard", tribo.PRESETS["standard"])
    sweep = read(entries, preset="standard", overrides={"increments": 40})
    assert (sweep.preset, sweep.scene.fidelity.increments) == (None, 40)
    same = tribo.PRESETS["standard"].contact_tolerance
    assert read(overrides={"contact_tolerance": same}).preset == "standard"


def test_any_entry_may_be_given_in_place_of_the_files(read, faults):
    overrides = {
        "wear.pattern": "local",
        "sweep.loads": ["300 N", "500 N"],
        "fidelity.increments": 30,
        "heat_model": "history",
    }
    changed = read(overrides=overrides)
    expected = read(
        ('"swept"', '"local"'),
        (LOADS, '["300 N", "500 N"]'),
        ('"standard"', '"standard"\nincrements = 30\nheat_model = "history"'),
    )
    assert changed == expected
    # A single numerical choice precedes the preset given in the same call.
    assert read(preset="standard", overrides=overrides).scene.fidelity.increments == 30
    assert read(overrides={"fidelity.preset": "fine"}) == read(preset="fine")
    overrides = {"waer.pattern": "local", "title.long": "x", "realizations": 3, "incremnts": 3}
    messages = faults(overrides=overrides)
    paths = ["incremnts", "realizations", "title", "waer"]
    assert sorted(line.split(": ")[0] for line in messages) == paths
    said = "\n".join(messages)
    for hint in ('"increments"?', '"sweep.realizations"?', '"wear"?', "a table is not text"):
        assert hint in said


CROWNED = {"without": "pin.length", "pin.shape": "crowned", "pin.crown_radius": "8 cm"}


def test_a_measured_load_stands_in_place_of_the_ramp(read, faults, tmp_path):
    rows = "time [ms], load [kN]\n0, 0\n2000, 0.4\n5000, 0.8\n"
    (tmp_path / "record.csv").write_text(rows)
    times, loads = np.array([0.0, 2.0, 5.0]), np.array([0.0, 400.0, 800.0])
    ramp, record = 'rate = "150 N/s"\nreference_load = "750 N"', 'file = "record.csv"'
    assert read((ramp, record)).scene.loading == tribo.MeasuredLoad(times, loads)
    record += '\nreference_load = "500 N"'
    fitted = read((ramp, record + "\nfit = true"))
    assert fitted.scene.loading == tribo.MeasuredLoad(times, loads, 500.0).ramp()
    (note,) = fitted.notes
    assert note.place == "loading.file"
    assert "fitted by" in note.words
    assert "N/s" in note.words
    (fault,) = faults((ramp, record.replace("500", "900")))
    assert fault.startswith("loading.file: ")
    assert "reaches 800 N" in fault
    (tmp_path / "record.csv").write_text(rows + "4000, 0.8\n")
    (fault,) = faults((ramp, record))
    assert "row 5: time 4 s after 5 s" in fault


def test_a_crowned_pin_has_two_radii_and_is_swept_over(read):
    sweep = read(overrides=CROWNED)
    assert sweep.scene.pin == tribo.Crowned(2e-3, 80e-3, sweep.scene.disk)
    assert sweep.scene.pixels.periodic == (False, False)
    assert sweep.scene.sweeps_over
    assert not read(overrides=CROWNED | {"wear.pattern": "local"}).scene.sweeps_over


def test_an_empty_file_lacks_every_table(tmp_path):
    (tmp_path / "empty.toml").touch()
    with pytest.raises(SceneFileError) as caught:
        load_scene(tmp_path / "empty.toml")
    needed = ["pin", "disk", "window", "loading", "friction", "temperature", "sweep"]
    assert [line.partition(": missing; give a")[0] for line in caught.value.faults] == needed


@pytest.mark.parametrize(
    ("overrides", "keys"),
    [
        ({"window.pixels": [33, 33], "pin.radius": "2 N"}, {"window.pixels", "pin.radius"}),
        ({"pixels_per_element": 5, "pin.lenght": "1 mm"}, {"window.pixels", "pin.lenght"}),
        ({"disk.diameter": "20 mm", "pin.radius": "2 N"}, {"disk.width", "pin.radius"}),
    ],
)
def test_conflicts_of_entries_are_named_beside_other_mistakes(overrides, keys):
    with pytest.raises(SceneFileError) as caught:
        load_scene("first_try", overrides=overrides)
    assert {fault.partition(":")[0].partition(" ")[0] for fault in caught.value.faults} == keys


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "irg_transition.toml"
    path.write_bytes(b"\xef\xbb\xbf" + PAPER.replace("\n", "\r\n").encode())
    assert load_scene(path) == load_scene(WORKFLOWS / "irg_transition.toml")


def places(value):
    """Yield (container, key) of each value in a nested document."""
    for key, part in list(value.items() if isinstance(value, dict) else enumerate(value)):
        yield value, key
        if isinstance(part, dict | list):
            yield from places(part)


units = st.sampled_from(["um", "N", "N/s", "GPa", "degC", "K", "m/s", "furlong", "m^99", "", "µ"])
numbers = st.integers() | st.floats() | st.sampled_from([0, -1, 10**400, 1e308, 5e-324])
words = st.text(st.characters(codec="utf-8"), max_size=8)
quantities = st.builds("{} {}".format, numbers, units)
values = st.recursive(
    numbers | words | quantities | st.booleans() | st.sampled_from(["ball", "local", "steel"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(words, inner, max_size=3),
    max_leaves=6,
)
unhurried = settings(
    deadline=None, max_examples=16, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def faults_of(path, text):
    """Faults of a scene file; [] if it is valid, None for any other result."""
    path.write_text(text, encoding="utf-8", newline="")
    try:
        return [] if isinstance(load_scene(path), Sweep) else None
    except SceneFileError as error:
        return error.faults or None


@unhurried
@given(st.data())
def test_a_scene_of_wrong_values_is_read_or_refused(tmp_path, data):
    (tmp_path / "base.toml").write_text(TEXT, encoding="utf-8")
    document = copy.deepcopy(tomllib.loads(TEXT))
    if data.draw(st.booleans()):
        document |= {"extends": "base.toml", "without": ["wear.pattern", "tests"]}
        for key in data.draw(st.lists(st.sampled_from(sorted(document)), unique=True)):
            del document[key]
    for _ in range(data.draw(st.integers(1, 3))):
        holder, key = data.draw(st.sampled_from(list(places(document)) or [(document, "pin")]))
        match data.draw(st.sampled_from(["drop", "replace", "rename"])):
            case "drop":
                holder.pop(key, None) if isinstance(holder, dict) else holder.pop(key)
            case "replace":
                holder[key] = data.draw(values)
            case "rename" if isinstance(holder, dict) and key in holder:
                holder[data.draw(words)] = holder.pop(key)
        if not document:
            break
    faults = faults_of(tmp_path / "scene.toml", text_of(document))
    assert all(len(line.splitlines()) == 1 for line in faults)


@unhurried
@given(st.data())
def test_a_scene_of_garbled_text_is_read_or_refused(tmp_path, data):
    start, end = sorted(data.draw(st.tuples(*[st.integers(0, len(TEXT))] * 2)))
    end = min(end, start + data.draw(st.sampled_from([0, 1, 2, 10, 1000])))
    insert = data.draw(st.text(st.characters(codec="utf-8"), max_size=5))
    faults = faults_of(tmp_path / "scene.toml", TEXT[:start] + insert + TEXT[end:])
    assert all(len(line.splitlines()) == 1 for line in faults)


def test_both_bodies_may_move(read):
    moving = [("[wear]", '[motion]\nslide_roll_ratio = 0.5\ntrack_length = "30 mm"\n\n[wear]')]
    sweep = read(*moving)
    assert sweep.scene.motion == tribo.Motion(slide_roll_ratio=0.5, track_length=30e-3)
    assert sweep.scene.velocities_at(1.0) == (1.5, 2.5)
    assert read().scene.motion is None


@pytest.mark.parametrize(
    ("given", "taken"),
    [("60-62 HRC", "61 HRC"), ("60 – 62 HRC", "61 HRC"), ("HRC 60 +4", "62 HRC"),
     ("700±20 HV", "700 HV"), ("225 to 305 HB", "265 HB")],
)  # fmt: skip
def test_the_middle_of_a_range_of_hardness_is_taken_and_told(given, taken):
    sweep = load_scene(WORKFLOWS / "first_try.toml", overrides={"materials.steel.hardness": given})
    assert sweep.scene.hardness == pytest.approx(to_si(taken, "1 Pa"), rel=1e-12)
    (note,) = [note.text for note in sweep.notes if "hardness" in note.text]
    assert f"{taken}, its middle, is taken" in note

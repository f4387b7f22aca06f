import copy
import io
import math
import pickle
import tomllib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import tribo
from pipeline.scene import units as units_module
from pipeline.scene.faults import SceneFileError
from pipeline.scene.quantities import display
from pipeline.scene.scenefile import load_scene
from pipeline.scene.units import UnitError, exact_si, to_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Measurement, Sweep

WORKFLOWS = Path(__file__).parents[3] / "workflows"
PAPER = (WORKFLOWS / "irg_transition.toml").read_text(encoding="utf-8")
# The first scene, written in full.
TEXT = "".join([
    PAPER[: PAPER.index("[fidelity]")],
    '[fidelity]\npreset = "draft"\n\n[sweep]\nloads = ["200 N", "400 N", "600 N", "750 N"]\n',
    'velocities = { from = "1 m/s", to = "4 m/s", step = "0.6 m/s" }\nfields = true\n\n',
    PAPER[PAPER.index("[[measured]]") :],
])  # fmt: skip
ROUGHNESS = TEXT[TEXT.index("ra =") : TEXT.index("[window]")]
MEASURED_SURFACE = 'file = "surface.npy"\nheight_unit = "um"\n'
BALL = ('shape = "cylinder"', 'shape = "ball"'), ('length = "3.4 mm"\n', "")


@pytest.fixture
def read(tmp_path):
    """Read the first scene with texts in it replaced."""

    def read(*changes, **arguments):
        text = TEXT
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        return load_scene(tmp_path / "scene.toml", **arguments)

    return read


@pytest.fixture
def faults(read):
    """The faults of the first scene with texts in it replaced."""

    def faults(*changes, **arguments):
        with pytest.raises(SceneFileError) as caught:
            read(*changes, **arguments)
        return caught.value.faults

    return faults


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.27 um", 2.7e-7),
        ("0.27 µm", 2.7e-7),
        ("0.816 um", 0.816e-6),
        ("0.95 um", 0.95e-6),
        ("1.632 µm", 1.632e-6),
        ("4um", 4e-6),
        ("2 mm", 2e-3),
        ("3.4 mm", 3.4e-3),
        ("150 mm", 0.15),
        ("10 nm", 1e-8),
        ("210 GPa", 210e9),
        ("6.6 GPa", 6.6e9),
        ("1.1 GPa", 1.1e9),
        ("660 kgf/mm^2", 6472389000.0),
        ("45 W/(m K)", 45.0),
        ("45 W/m/K", 45.0),
        ("45 W m^-1 K^-1", 45.0),
        ("45 W/(m degC)", 45.0),
        ("7800 kg/m^3", 7800.0),
        ("7.8 g/cm^3", 7800.0),
        ("470 J/(kg K)", 470.0),
        ("0.47 kJ/kg/K", 470.0),
        ("1.2e-6 mm^3/(N m)", 1.2e-15),
        ("1.2e-6 mm³/(N·m)", 1.2e-15),
        ("1.2e-6 mm**3/N/m", 1.2e-15),
        ("150 N/s", 150.0),
        ("0.75 kN", 750.0),
        ("1.25 m/s", 1.25),
        ("0.1 m/s", 0.1),
        ("9 km/h", 2.5),
        ("25 degC", 298.15),
        ("25 °C", 298.15),
        ("145 degC", 418.15),
        ("77 degF", 298.15),
        ("298 K", 298.0),
    ],
)
def test_a_quantity_is_the_double_nearest_to_its_value_in_si(text, value):
    assert to_si(text, like=text) == value


@pytest.mark.parametrize(
    "text",
    [
        *("", "4", "um", "4 kp", "4,0 um", "4 um um", "4 2 um", "nan um", "inf um", "1e9999 um"),
        *("4 um^9^9^9^9", "4 um**9**9**9", "0x4 um", "1_000 um", "4 um # no", "4 __import__('os')"),
        *("4 (um", "4 um)", "4 ^um", "4 /um", "4 um^-", "4 um^", "25 degC", "4 degC^2 um"),
        *("4 " + "(" * 3000 + "m" + ")" * 3000, "١ um", "4 um\n", "\x00", "4 um^½"),
    ],
)
def test_what_is_not_a_quantity_of_the_dimension_asked_for_is_refused(text):
    with pytest.raises(UnitError):
        exact_si(text, like="1 m")


def test_a_temperature_difference_is_no_temperature():
    with pytest.raises(UnitError):
        to_si("25 delta_degC", like="300 K")


@settings(deadline=None)
@given(st.text(alphabet="mkKNPaWJsg0123456789.eE+-*/^()·°µ²³⁻¹ _%C", max_size=20))
def test_text_in_place_of_a_quantity_is_read_or_refused(text):
    try:
        said = str(exact_si(text, like="1 m"))
    except UnitError as error:
        said = str(error)
    assert len(said.splitlines()) == 1


def test_values_are_displayed_in_the_units_of_the_field():
    assert display(418.15, "°C") == "145 °C"
    assert display(to_si("0.3 m/s", like="1 m/s"), "m/s") == "0.3 m/s"
    assert display(6.6e9, "GPa") == "6.6 GPa"
    assert display(2e-3, "mm") == "2 mm"


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
    assert sweep == Sweep(
        pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=steel),
        disk=steel,
        pixels=tribo.Grid((480, 480), (0.816e-6, 0.95e-6), (False, True)),
        loading=tribo.Ramp(rate=150.0, reference_load=750.0),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=0),
        wear=tribo.Wear(1.2e-15, "swept"),
        oil=tribo.Oil((313.15, 373.15), (32e-6, 5e-6), 866.0, (2e-8, 2e-8)),
        fidelity=tribo.PRESETS["standard"],
        name="irg_transition",
        title=sweep.title,
        loads=tuple(200.0 + 50.0 * i for i in range(12)),
        velocities=tuple(0.5 + 0.25 * i for i in range(19)),
        conditions=Conditions(0.1, 298.15, 418.15, failing_share=0.1),
        friction_band=(0.09, 0.103),
        measured=(
            Measurement(750.0, 1.25, 0.103),
            Measurement(600.0, 1.5, 0.1),
            Measurement(400.0, 2.25, 0.091),
            Measurement(200.0, 3.75, 0.094),
        ),
        store_fields=True,
        independent=False,
        preset="standard",
    )
    assert sweep.grid.shape == (240, 240)
    assert sweep.grid.spacing == pytest.approx((1.632e-6, 1.9e-6), rel=1e-15)


def test_the_first_scene_is_the_system_of_the_paper_at_fewer_points():
    full, first = (load_scene(WORKFLOWS / f"{n}.toml") for n in ("irg_transition", "first_try"))
    for field in fields(tribo.Scene):
        if field.name not in ("fidelity", "pixels"):
            assert getattr(first, field.name) == getattr(full, field.name)
    assert first.pixels.spacing == full.pixels.spacing
    assert first.conditions == full.conditions
    assert first.measured == full.measured
    assert (len(first.loads), len(first.velocities)) == (4, 6)


@pytest.mark.parametrize("path", sorted(WORKFLOWS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_scene_loads_and_says_what_it_shows(path):
    sweep = load_scene(path)
    assert sweep.name == path.stem
    header = path.read_text(encoding="utf-8").split("\n\n")[0]
    assert all(word in header for word in ("# Shows", "# Expect", "# Costs"))
    assert pickle.loads(pickle.dumps(sweep)) == sweep
    assert hash(sweep) == hash(load_scene(path))


def test_a_range_gives_the_same_numbers_as_writing_them_out(read):
    given = 'from = "1 m/s", to = "4 m/s", step = "0.6 m/s"'
    sweep = read((given, 'from = "0 m/s", to = "2 m/s", step = "0.1 m/s"'))
    assert sweep.velocities == tuple(float(f"{i // 10}.{i % 10}") for i in range(21))
    assert 0.3 in sweep.velocities
    assert 0.7 in sweep.velocities
    sweep = read((given, 'from = "36 km/h", to = "37 km/h", step = "0.5 km/h"'))
    assert sweep.velocities == pytest.approx((10.0, 36.5 / 3.6, 37 / 3.6), rel=1e-15)
    assert read((given, 'from = "1 m/s", to = "1 m/s", step = "1 m/s"')).velocities == (1.0,)


def test_a_range_may_have_as_many_velocities_as_a_large_sweep_takes(read):
    given = 'from = "1 m/s", to = "4 m/s", step = "0.6 m/s"'
    sweep = read((given, 'from = "1 m/s", to = "3 m/s", step = "20 um/s"'))
    assert len(sweep.velocities) == 100_001
    assert sweep.velocities[12345] == 1.2469


def test_the_unit_that_is_due_is_read_once_for_many_values(read, monkeypatch):
    parsed, parse = [], units_module._parsed
    monkeypatch.setattr(units_module, "_parsed", lambda text: parsed.append(text) or parse(text))
    values = ", ".join(f'"{100 + i} N"' for i in range(200))
    sweep = read(('["200 N", "400 N", "600 N", "750 N"]', f"[{values}]"))
    assert len(sweep.loads) == 200
    assert len(parsed) < 300


def test_loads_are_sorted(read):
    sweep = read(('["200 N", "400 N", "600 N", "750 N"]', '["0.4 kN", "200 N"]'))
    assert sweep.loads == (200.0, 400.0)


def test_what_may_be_left_out_takes_its_default(read):
    sweep = read(
        (TEXT[TEXT.index("title =") : TEXT.index("[materials")], ""),
        ('hardness = "6.6 GPa"\n', ""),
        ("[disk.roughness]\n" + ROUGHNESS, ""),
        (TEXT[TEXT.index("[wear]") : TEXT.index("[friction]")], ""),
        ("band = [0.09, 0.103]\n", ""),
        ("failing_share = 0.1\n", ""),
        (TEXT[TEXT.index("[fidelity]") : TEXT.index("[sweep]")], ""),
        ("fields = true\n", ""),
        (TEXT[TEXT.index("[[measured]]") :], ""),
    )
    assert sweep.title == "scene"
    assert sweep.hardness == math.inf
    assert sweep.roughness is sweep.wear is sweep.friction_band is None
    assert sweep.conditions.failing_share == 0.1
    assert (sweep.preset, sweep.fidelity) == ("standard", tribo.PRESETS["standard"])
    assert not sweep.store_fields
    assert not sweep.independent
    assert sweep.measured == ()


def test_a_ball_has_a_free_window_and_a_cylinder_a_periodic_one(read):
    local = ('"swept"', '"local"')
    assert read().pixels.periodic == (False, True)
    assert read(*BALL, local).pixels.periodic == (False, False)
    assert isinstance(read(*BALL, local).pin, tribo.Ball)
    free = ("pixels = [480, 480]", "pixels = [480, 480]\nperiodic_y = false")
    assert read(free, local).pixels.periodic == (False, False)


def test_a_lay_has_two_correlation_lengths(read):
    sweep = read(('correlation_length = "4 um"', 'correlation_length = ["4 um", "40 um"]'))
    assert sweep.roughness.correlation_length == (4e-6, 4e-5)


def test_realizations_are_so_many_seeds_or_a_list_of_them(read, faults, tmp_path):
    def realized(given, *changes):
        return read(("fields =", f"realizations = {given}\nfields ="), *changes)

    assert read().realizations == ()
    assert realized("3").realizations == (0, 1, 2)
    assert realized("3", ("seed = 0", "seed = 5")).realizations == (5, 6, 7)
    sweep = realized("[9, 2]")
    assert sweep.realizations == (2, 9)
    assert sweep.roughness.seed == 2  # what takes one surface takes the first
    np.save(tmp_path / "surface.npy", np.zeros((480, 480)))
    for surface, what in (
        (("[disk.roughness]\n" + ROUGHNESS, ""), "smooth"),
        ((ROUGHNESS, MEASURED_SURFACE), "measured"),
    ):
        (fault,) = faults(("fields =", "realizations = 3\nfields ="), surface)
        assert fault.startswith(f"sweep.realizations: 3 does not fit a {what} disk")


def test_a_measured_surface_is_read_from_beside_the_scene(read, tmp_path):
    heights = np.arange(48.0).reshape(8, 6)
    np.save(tmp_path / "surface.npy", heights)
    sweep = read(
        (ROUGHNESS, MEASURED_SURFACE),
        ("[480, 480]", "[8, 6]"),
        ('"draft"', '"draft"\npixels_per_element = 2'),
    )
    np.testing.assert_allclose(sweep.roughness.array, heights * 1e-6, rtol=1e-15)


@pytest.mark.parametrize(
    ("key", "path"),
    [
        ("loads", "sweep.loads"),
        ("critical", "temperature.critical"),
        ("Increment", "increments"),
        ("rate", "loading.rate"),
        ("seed", "disk.roughness.seed"),
    ],
)
def test_the_path_of_an_entry_that_is_named_alone_is_proposed(read, key, path):
    with pytest.raises(SceneFileError, match=rf'{key}: unknown key \(did you mean "{path}"\?\)'):
        read(overrides={key: 1})


def test_a_preset_asked_for_replaces_the_files_fidelity_and_overrides_come_last(read):
    own = ('preset = "draft"', 'preset = "draft"\nincrements = 30\npartition = "uniform"')
    assert read().preset == "draft"
    sweep = read(own)
    assert sweep.fidelity == replace(tribo.PRESETS["draft"], increments=30, partition="uniform")
    assert sweep.preset is None
    sweep = read(own, preset="standard")
    assert (sweep.preset, sweep.fidelity) == ("standard", tribo.PRESETS["standard"])
    sweep = read(own, overrides={"increments": 40})
    expected = replace(tribo.PRESETS["draft"], increments=40, partition="uniform")
    assert (sweep.preset, sweep.fidelity) == (None, expected)
    sweep = read(own, preset="standard", overrides={"increments": 40})
    assert (sweep.preset, sweep.fidelity.increments) == (None, 40)
    assert read(overrides={"increments": tribo.PRESETS["draft"].increments}).preset == "draft"


def test_any_entry_may_be_given_in_place_of_the_files(read, faults):
    given = {
        "wear.pattern": "local",
        "loading.hold": "4 s",
        "sweep.loads": ["300 N", "500 N"],
        "temperature.failing_share": 0,
        "fidelity.increments": 30,
        "partition": "uniform",
    }
    changed = read(overrides=given)
    expected = read(
        ('"swept"', '"local"'),
        ('"150 N/s"', '"150 N/s"\nhold = "4 s"'),
        ('["200 N", "400 N", "600 N", "750 N"]', '["300 N", "500 N"]'),
        ("failing_share = 0.1", "failing_share = 0"),
        ('"draft"', '"draft"\nincrements = 30\npartition = "uniform"'),
    )
    assert changed == expected
    # What is asked for now goes before the preset that is asked for now.
    assert read(preset="standard", overrides=given).fidelity.increments == 30
    assert read(overrides={"fidelity.preset": "fine"}) == read(preset="fine")
    found = faults(
        overrides={
            "wear.pattern": "lcoal",
            "waer.pattern": "local",
            "title.long": "x",
            "realizations": 3,
            "incremnts": 3,
        }
    )
    assert sorted(line.split(": ")[0] for line in found) == [
        "incremnts",
        "realizations",
        "title.long",
        "waer",
        "wear.pattern",
    ]
    said = "\n".join(found)
    for hint in ('"increments"?', '"sweep.realizations"?', '"wear"?', '"local"?', "not a table"):
        assert hint in said


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ('"0.27 um"', "0.27", "disk.roughness.ra", ["0.27 has no unit", "um"]),
        ('"0.27 um"', '"0.27"', "disk.roughness.ra", ['"0.27"', "um"]),
        ('"0.27 um"', '"0.27 GPa"', "disk.roughness.ra", ['"0.27 GPa"', "um"]),
        ('"0.27 um"', '"0.27 parsnip"', "disk.roughness.ra", ["parsnip", "um"]),
        ('"0.27 um"', '"-0.27 um"', "disk.roughness.ra", ["above 0"]),
        (
            '"6.6 GPa"',
            '"6.6 kg"',
            "materials.steel.hardness",
            ["converted to GPa", "a pressure"],
        ),
        ("poisson_ratio = 0.3", "poisson_ratio = 0.7", "materials.steel.poisson_ratio", ["0.5"]),
        ("poisson_ratio = 0.3", "poisson_ratio = true", "materials.steel.poisson_ratio", ["true"]),
        ("poisson_ratio = 0.3", "poisson_ratio = nan", "materials.steel.poisson_ratio", ["nan"]),
        ("hardness =", "hardnes =", "materials.steel.hardnes", ['did you mean "hardness"?']),
        ("hurst_exponent =", "hurst =", "disk.roughness.hurst", ['"hurst_exponent"?']),
        ("hurst_exponent =", "hurst =", "disk.roughness.hurst_exponent", ["missing", "at most 1"]),
        ("[friction]", "[fricton]", "fricton", ['did you mean "friction"?']),
        ("[friction]", "[fricton]", "friction", ["missing", "coefficient"]),
        ('"cylinder"', '"cylindr"', "pin.shape", ['"cylinder", "ball" or "crowned"']),
        ('length = "3.4 mm"\n', "", "pin.length", ["missing", "mm"]),
        ('"cylinder"', '"ball"', "pin.length", ["unknown key", "radius"]),
        ('[disk]\nmaterial = "steel"', '[disk]\nmaterial = "stell"', "disk.material", ['"steel"?']),
        ("[materials.steel]", "[materials.iron]", "pin.material", ['"steel"', 'give "iron"']),
        ("[480, 480]", "[480, 481]", "window.pixels", ["481", "multiples of 4"]),
        ("[480, 480]", "[480, 480.0]", "window.pixels[1]", ["480.0", "whole number"]),
        ("[480, 480]", "[480]", "window.pixels", ["1 entry", "list of 2"]),
        ("[480, 480]", "480", "window.pixels", ["480", "list of 2"]),
        ('"0.95 um"]', "0.95]", "window.pixel_size[1]", ["0.95 has no unit"]),
        ("pixels =", "periodic_y = 1\npixels =", "window.periodic_y", ["true or false"]),
        ('"swept"', '"swetp"', "wear.pattern", ['did you mean "swept"?', '"local" or "swept"']),
        ('"150 N/s"', '"150 N"', "loading.rate", ['"150 N"', "N/s"]),
        ('"150 N/s"', '"150 N/s"\nhold = 4', "loading.hold", ["4 has no unit", '"4 s"']),
        (
            '"150 N/s"',
            '"150 N/s"\nhold = "4 N"',
            "loading.hold",
            ["converted to s", '"4 s"'],
        ),
        ('"150 N/s"', '"150 N/s"\nhold_steps = 0', "loading.hold_steps", ["at least 1"]),
        ('rate = "150 N/s"', 'file = "no.csv"', "loading.file", ["No such file"]),
        ('rate = "150 N/s"', 'file = 3\nhold = "4 s"', "loading.hold", ["unknown key"]),
        ('rate = "150 N/s"', "file = 3", "loading.file", ["3 is not text"]),
        ('"145 degC"', '"24 degC"', "temperature.critical", ["24 °C", "25 °C"]),
        ('"145 degC"', '"25 degC"', "temperature.critical", ["not above", '"145 degC"']),
        ('length = "3.4 mm"', 'length = "0.455 mm"', "pin.length", ["0.456 mm", "at least"]),
        ('"25 degC"', '"-300 degC"', "temperature.bulk", ["above 0", "degC"]),
        ('"25 degC"', "25", "temperature.bulk", ["25 has no unit", "degC"]),
        ("failing_share = 0.1", "failing_share = 1", "temperature.failing_share", ["below 1"]),
        ("[0.09, 0.103]", "[0.103, 0.09]", "friction.band", ["lower one first"]),
        (
            "coefficient = 0.1",
            "coefficient = true",
            "friction.coefficient",
            ["true is not"],
        ),
        ("[pin]", '"a\\u2028b" = 1\n[pin]', 'materials.steel."a\\u2028b"', ["unknown key"]),
        ("coefficient = 0.1", "coefficient = -0.1", "friction.coefficient", ["at least 0"]),
        ('"draft"', '"fast"', "fidelity.preset", ['"draft", "standard", "fine", "reference" or']),
        ('"draft"', '"draft"\nincrements = 0', "fidelity.increments", ["0", "at least 1"]),
        ('"draft"', '"draft"\nincrements = "9"', "fidelity.increments", ["whole number"]),
        ('"draft"', '"draft"\npartition = "x"', "fidelity.partition", ['"local"', '"uniform"']),
        ('"200 N"', '"0 N"', "sweep.loads[0]", ["above 0", "N"]),
        ('"200 N"', '"1,200 N"', "sweep.loads[0]", ['"1.200 N", and', 'a comma: "1200 N"']),
        (" mm^3/", " mm3/", "wear.specific_wear_rate", ["'mm3' is not", 'powers as in "mm^3"']),
        ('"400 N"', '"0.2 kN"', "sweep.loads[1]", ["entry [0]"]),
        ('["200 N", "400 N", "600 N", "750 N"]', "[]", "sweep.loads", ["is empty", "from, to"]),
        (
            '["200 N", "400 N", "600 N", "750 N"]',
            '"2 N"',
            "sweep.loads",
            ["a list", "from, to"],
        ),
        ('"0.6 m/s"', '"0.7 m/s"', "sweep.velocities", ["4.28571 steps"]),
        ('"0.6 m/s"', '"0 m/s"', "sweep.velocities.step", ["above 0"]),
        ('"0.6 m/s"', '"1e-9 m/s"', "sweep.velocities", ["3e+9 steps", "100000"]),
        ('{ from = "1 m/s", to', "{ to", "sweep.velocities.from", ["missing"]),
        ('from = "1 m/s"', 'from = "5 m/s"', "sweep.velocities", ["steps"]),
        ("fields = true", 'fields = "yes"', "sweep.fields", ["true or false"]),
        ("fields =", "realizations = 0\nfields =", "sweep.realizations", ["0", "at least 1"]),
        ("fields =", "realizations = []\nfields =", "sweep.realizations", ["is empty", "list"]),
        ("fields =", "realizations = [3, 3]\nfields =", "sweep.realizations[1]", ["entry [0]"]),
        ("fields =", "realizations = [-1]\nfields =", "sweep.realizations[0]", ["at least 0"]),
        ("fields =", 'realizations = "8"\nfields =', "sweep.realizations", ["whole number"]),
        ('velocity = "3.75 m/s"', 'velocity = "3.75 N"', "measured[3].velocity", ["m/s"]),
        ('title = "', 'title = 3 # "', "title", ["text"]),
        ("seed = 0", "seed = -1", "disk.roughness.seed", ["at least 0"]),
        ('"4 um"', '["4 um"]', "disk.roughness.correlation_length", ["list of 2"]),
    ],
)
def test_a_fault_is_one_line_with_its_key_and_what_is_allowed(faults, old, new, key, said):
    lines = [line for line in faults((old, new)) if line.startswith(f"{key}: ")]
    assert len(lines) == 1
    assert all(text in lines[0] for text in said)
    assert len(lines[0].splitlines()) == 1


@pytest.mark.parametrize(
    "table",
    ["pin", "window", "loading", "friction", "temperature", "sweep"],
)
def test_a_missing_table_is_named(faults, table):
    start = TEXT.index(f"[{table}]")
    rest = TEXT[start + 1 :]
    found = faults((TEXT[start : start + 1 + rest.index("\n[")], ""))
    assert any(line.startswith(f"{table}: missing; give") for line in found)


def test_a_material_that_is_nowhere_is_named_for_each_body(faults):
    start = TEXT.index("[materials.steel]")
    found = faults((TEXT[start : TEXT.index("[pin]")], ""))
    assert [line.split(":")[0] for line in found] == ["pin.material", "disk.material"]
    assert all("neither a table of [materials] nor in the library" in line for line in found)


def test_a_load_is_held(read):
    loading = read(('"150 N/s"', '"150 N/s"\nhold = "4 s"\nhold_steps = 8')).loading
    assert loading == tribo.Ramp(150.0, 750.0, hold=4.0, hold_steps=8)


def test_a_measured_load_stands_in_place_of_the_ramp(read, faults, tmp_path):
    rows = "time [ms], load [kN]\n0, 0\n2000, 0.4\n5000, 0.8\n"
    (tmp_path / "record.csv").write_text(rows)
    times, loads = np.array([0.0, 2.0, 5.0]), np.array([0.0, 400.0, 800.0])
    ramp, record = 'rate = "150 N/s"\nreference_load = "750 N"', 'file = "record.csv"'
    assert read((ramp, record)).loading == tribo.MeasuredLoad(times, loads)
    record += '\nreference_load = "500 N"'
    assert read((ramp, record)).loading == tribo.MeasuredLoad(times, loads, 500.0)
    fitted = read((ramp, record + "\nfit = true"))
    assert fitted.loading == tribo.MeasuredLoad(times, loads, 500.0).ramp()
    (note,) = fitted.notes
    assert "fitted by" in note
    assert "N/s" in note
    (fault,) = faults((ramp, record + '\nfit = "line"'))
    assert fault.startswith("loading.fit: ")
    (fault,) = faults((ramp, record.replace("500", "900")))
    assert fault.startswith("loading.file: ")
    assert "reaches 800 N" in fault
    (tmp_path / "record.csv").write_text(rows + "4000, 0.8\n")
    (fault,) = faults((ramp, record))
    assert "line 5: time 4 s after 5 s" in fault


@pytest.mark.parametrize(
    ("sides", "problem"),
    [
        (["1e308 um", "2 um"], "one side must be at most 1e+06 times the other"),
        (["1e-300 um", "1e-300 um"], "element_area is 0.0"),
        (["1e160 m", "1e160 m"], "element_area is inf"),
    ],
)
def test_elements_of_impossible_sides_are_an_error_of_the_window(faults, sides, problem):
    found = faults(('["0.816 um", "0.95 um"]', str(sides)))
    (fault,) = (line for line in found if line.startswith("window.pixel_size: "))
    assert problem in fault


def test_a_ball_does_not_fit_a_periodic_window(faults):
    found = faults(*BALL, ("[window]\n", "[window]\nperiodic_y = true\n"))
    assert [line.split(":")[0] for line in found] == ["window.periodic_y"]


CROWNED = (
    ('shape = "cylinder"', 'shape = "crowned"'),
    ('length = "3.4 mm"', 'crown_radius = "8 cm"'),
)


def test_a_crowned_pin_has_two_radii_and_is_swept_over(read):
    sweep = read(*CROWNED)
    assert sweep.pin == tribo.Crowned(2e-3, 80e-3, sweep.disk)
    assert sweep.pixels.periodic == (False, False)
    assert sweep.sweeps_over
    assert not read(*CROWNED, ('"swept"', '"local"')).sweeps_over


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        (
            (CROWNED[0], ('length = "3.4 mm"\n', "")),
            "pin.crown_radius: missing; a crowned pin needs its radius across sliding, such as "
            '"100 mm"',
        ),
        (
            (BALL[0], CROWNED[1]),
            'pin.crown_radius: 80 mm does not fit a ball; give shape = "crowned"',
        ),
        (
            (*CROWNED, ('"8 cm"', '"0 cm"')),
            'pin.crown_radius: "0 cm" is out of range; give a length above 0, such as "2 mm"',
        ),
        (
            (*CROWNED, ("[window]\n", "[window]\nperiodic_y = true\n")),
            "window.periodic_y: true does not fit a crowned pin; give false, or leave it out",
        ),
    ],
)
def test_a_crown_that_cannot_be_is_one_fault(faults, changes, fault):
    assert faults(*changes) == [fault]


def test_a_single_pixel_has_no_roughness(read, faults):
    single, smooth = ("[480, 480]", "[1, 1]"), ("[disk.roughness]\n" + ROUGHNESS, "")
    (fault,) = faults(single, overrides={"pixels_per_element": 1})
    assert fault.startswith("window.pixels: ")
    assert read(single, smooth, overrides={"pixels_per_element": 1}).pixels.shape == (1, 1)


def test_all_faults_are_named_at_once(read, faults):
    changes = (
        ('"0.27 um"', "0.27"),
        ('[disk]\nmaterial = "steel"', '[disk]\nmaterial = "stell"'),
        ("specific_heat", "specific_haet"),
        ('"145 degC"', '"20 degC"'),
        ('"750 N"]', '"-750 N"]'),
        ("[480, 480]", "[482, 480]"),
        ("fields =", "realizations = -3\nfields ="),
    )
    found = faults(*changes, preset="slow", overrides={"increment": 3, "increments": -3})
    assert sorted(line.split(":")[0] for line in found) == [
        "disk.material",
        "disk.roughness.ra",
        "increment",
        "increments",
        "materials.steel.specific_haet",
        "materials.steel.specific_heat",
        "preset",
        "sweep.loads[3]",
        "sweep.realizations",
        "temperature.critical",
        "window.pixels",
    ]
    with pytest.raises(SceneFileError, match=r"scene\.toml: 7 faults") as caught:
        read(*changes[:2], *changes[3:], ("poisson_ratio = 0.3", "poisson_ratio = 3"))
    error = caught.value
    assert all(line in str(error) for line in error.faults)
    again = pickle.loads(pickle.dumps(error))
    assert (again.path, again.faults, str(again)) == (error.path, error.faults, str(error))


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "No such file"),
        (npy(np.where(np.eye(480, k=3), np.nan, 1.0)), "row 0, column 3"),
        (npy(np.full((480, 480), np.nan)), "all heights are missing; give another file"),
        (npy(np.ones((479, 480))), "479 rows of 480 heights"),
        (npy(np.ones(480)), "two-dimensional"),
        (npy(np.ones((480, 480)))[:-1], "surface.npy"),
        (npy(np.ones((4, 4))).replace(b"{", b"{{"), "disk.roughness.file"),
        (b"", "surface.npy"),
    ],
    ids=["missing", "nan", "all missing", "shape", "one row", "cut off", "broken header", "empty"],
)
def test_a_faulty_measured_surface_is_a_fault_with_its_place(faults, tmp_path, content, said):
    if content is not None:
        (tmp_path / "surface.npy").write_bytes(content)
    (fault,) = faults((ROUGHNESS, MEASURED_SURFACE))
    assert fault.startswith(("disk.roughness.file: ", "disk.roughness.missing: "))
    assert said in fault


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b'a = 1\ntitle = "no end\n', "line 2"),
        (b"a = 1\nb = 2\na = 3\n", "A key is given twice (at line 3"),
        (b"[pin]\n[pin]\n", "twice"),
        ("title = 'Härte'\n".encode("latin-1"), "line 1 is not UTF-8"),
        (TEXT.encode("utf-16"), "not UTF-8"),
        (b"#" * 10_000_001, "larger than 10 MB"),
        (b"a = " + b"[" * 100_000, "not valid TOML"),
        (b'[disk]\nfile = "C:\\scans\\disk.npy"', "write / in place of \\ in a path"),
        ("title = “Disk”".encode(), "write straight quotes"),
        (b"a = " + b"9" * 10_000, "not valid TOML"),
        (b"\x00\x01", "not valid TOML"),
    ],
    ids=[
        "cut",
        "key",
        "table",
        "latin-1",
        "utf-16",
        "large",
        "deep",
        "path",
        "quotes",
        "digits",
        "binary",
    ],
)
def test_a_file_that_is_no_toml_is_one_clear_fault(tmp_path, content, said):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneFileError) as caught:
        load_scene(path)
    assert len(caught.value.faults) == 1
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["", "missing.toml", "a\x00b.toml", "n" * 300, "x.toml/y.toml"])
def test_a_path_that_cannot_be_read_is_one_clear_fault(tmp_path, name):
    (tmp_path / "x.toml").touch()
    with pytest.raises(SceneFileError, match="cannot be read") as caught:
        load_scene(tmp_path / name)
    assert len(caught.value.faults) == 1


def test_an_empty_file_lacks_every_table(tmp_path):
    (tmp_path / "empty.toml").touch()
    with pytest.raises(SceneFileError) as caught:
        load_scene(tmp_path / "empty.toml")
    assert len(caught.value.faults) == 7
    assert all("missing; give" in line for line in caught.value.faults)


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "irg_transition.toml"
    path.write_bytes(b"\xef\xbb\xbf" + PAPER.replace("\n", "\r\n").encode())
    assert load_scene(path) == load_scene(WORKFLOWS / "irg_transition.toml")


def toml(value):
    """Write a value as TOML, tables inline."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return '"' + "".join(f"\\U{ord(letter):08X}" for letter in value) + '"'
        case list():
            return f"[{', '.join(map(toml, value))}]"
        case dict():
            return f"{{ {', '.join(f'{toml(k)} = {toml(v)}' for k, v in value.items())} }}"
        case _:
            return str(value)


def places(value):
    """Every container in a document, with the key of each of its parts."""
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
    deadline=None, max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def faults_of(path, text):
    """Load a scene; only a sweep or a list of faults may come of it."""
    path.write_text(text, encoding="utf-8", newline="")
    try:
        return [] if isinstance(load_scene(path), Sweep) else None
    except SceneFileError as error:
        return error.faults or None


@unhurried
@given(st.data())
def test_a_scene_of_wrong_values_is_read_or_refused(tmp_path, data):
    document = copy.deepcopy(tomllib.loads(TEXT))
    for _ in range(data.draw(st.integers(1, 3))):
        holder, key = data.draw(st.sampled_from(list(places(document)) or [(document, "pin")]))
        match data.draw(st.sampled_from(["drop", "replace", "rename"])):
            case "drop":
                del holder[key]
            case "replace":
                holder[key] = data.draw(values)
            case "rename" if isinstance(holder, dict):
                holder[data.draw(words)] = holder.pop(key)
        if not document:
            break
    lines = (f"{toml(key)} = {toml(value)}\n" for key, value in document.items())
    faults = faults_of(tmp_path / "scene.toml", "".join(lines))
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
    assert sweep.motion == tribo.Motion(slide_roll_ratio=0.5, track_length=30e-3)
    assert sweep.velocities_at(1.0) == (1.5, 2.5)
    rolling = read(("[wear]", '[motion]\nentrainment_velocity = "2 m/s"\n\n[wear]'))
    assert rolling.velocities_at(0.0) == (2.0, 2.0)
    assert read().motion is None


@pytest.mark.parametrize(
    ("table", "fault"),
    [
        ("", "motion: neither is given; give either slide_roll_ratio or entrainment_velocity"),
        (
            'slide_roll_ratio = 1\nentrainment_velocity = "1 m/s"',
            "motion: both are given; give either slide_roll_ratio or entrainment_velocity",
        ),
        (
            "slide_roll_ratio = 0",
            "motion.slide_roll_ratio: 0 is rolling without a sliding velocity; give another number "
            'such as 0.5, or entrainment_velocity and the velocity "0 m/s"',
        ),
        (
            'slide_roll_ratio = "50 %"',
            'motion.slide_roll_ratio: "50 %" is not a plain number; give a number without a unit',
        ),
        (
            "entrainment_velocity = 2",
            "motion.entrainment_velocity: 2 has no unit; give a velocity of at least 0, such as "
            '"1.25 m/s"',
        ),
        (
            'slide_roll_ratio = 1\ntrack_length = "0.1 mm"',
            "motion.track_length: 0.1 mm is shorter than the window, which is 0.39168 mm along x; "
            "give at least that",
        ),
    ],
)
def test_a_motion_that_cannot_be_is_one_fault(faults, table, fault):
    assert faults(("[wear]", f"[motion]\n{table}\n\n[wear]")) == [fault]

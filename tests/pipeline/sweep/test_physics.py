"""The table of what a scene counts, could count, and what cannot be sized."""

import math
from pathlib import Path

import pytest

import pipeline
from pipeline.sweep.physics import (
    columns_in_closed_form,
    note_on_ends,
    note_on_turns,
    physics_of,
)
from tests.helpers.scenes import SCENE

ROLLING = {"motion": {"slide_roll_ratio": 0.5, "track_length": "314 mm"}}
BALL = {"without": ["pin.length"], "pin.shape": "ball"}
CROWNED = {"without": ["pin.length"], "pin.shape": "crowned", "pin.crown_radius": "50 mm"}
NAMES = {
    "friction by velocity", "friction by temperature", "earlier turns", "warming bulk",
    "stem and holder of the pin", "oxide or tribofilm", "conductivity and specific heat when warm",
    "plastic memory of the track", "kinetics of desorption",
}  # fmt: skip
SCENES = {
    "plain": {},
    "all counted": {
        "pin.stem": {"resistance": "8 K/W"},
        "pin.capacity": "20 J/K",
        "disk": {
            "track_length": "34 cm",
            "loss": "2 W/K",
            "film": {"thickness": "20 nm", "thermal_conductivity": "2 W/(m K)"},
        },
        "friction.by_velocity": [{"velocity": "1 m/s", "coefficient": 0.1}],
    },
    "ball": BALL,
    "crowned pin that rolls": CROWNED | ROLLING,
    "discs": ROLLING,
    "pin that turns on a disk at rest": {"motion": {"slide_roll_ratio": -2}},
    "entrainment": {"motion": {"entrainment_velocity": "3 m/s"}},
    "hold": {"loading.hold": "60 s", "disk.capacity": "650 J/K"},
    "heat of the past": {"fidelity": {"heat_model": "history", "history_coarsening": 1}},
    "two bulk temperatures": {"temperature.bulk": {"pin": "60 degC", "disk": "25 degC"}},
    "nothing moves": {"sweep.velocities": ["0 m/s"]},
    "one velocity measured twice": {
        "sweep.velocities": ["1 m/s"],
        "measured": [
            {"load": "200 N", "velocity": "1 m/s", "friction": 0.1},
            {"load": "400 N", "velocity": "1 m/s", "friction": 0.12},
        ],
    },
    "alumina on AISI 316": {"pin.material": "alumina", "disk.material": "AISI 316"},
    "several": {"sweep.over": {"pin.radius": ["2 mm", "4 mm"]}, "sweep.realizations": 2},
    "pairs": {"sweep.along": [{"pin.radius": "3 mm", "load": "400 N", "velocity": "2 m/s"}]},
    "samples": {
        "sweep.samples": 8,
        "unknown": {"friction.coefficient": {"mean": 0.1, "sd": 0.01}},
    },
}


@pytest.fixture
def scene(tmp_path):
    """A scene with other values of some entries, by their paths."""
    (tmp_path / "plain.toml").write_text(SCENE)
    return lambda entries=None: pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)


def sound(effects):
    assert {effect.name for effect in effects} - {"together"} == NAMES
    assert all(effect.scene is None or effect.state != "cannot be sized" for effect in effects)
    assert len({effect.key for effect in effects}) == len(effects)
    return {effect.name: effect for effect in effects}


@pytest.mark.parametrize("kind", SCENES)
def test_every_kind_of_scene_has_all_effects(scene, kind):
    by_name = sound(physics_of(scene(SCENES[kind])))
    if kind == "all counted":
        counted = {name for name, effect in by_name.items() if effect.state == "counted"}
        assert len(counted) == 5


@pytest.mark.parametrize(
    "path", sorted(Path("workflows").glob("*.toml")), ids=lambda path: path.stem
)
def test_every_shipped_scene_has_all_effects(path):
    sound(physics_of(pipeline.load_scene(path)))


@pytest.mark.parametrize(
    ("kind", "name", "entries"),
    [
        ("plain", "earlier turns", {"disk.track_length": "0.34 m"}),
        ("plain", "stem and holder of the pin",
         {"pin.stem": {"length": "4 mm", "area": "13.6 mm^2"}}),
        ("plain", "oxide or tribofilm",
         {"disk.film": {"thickness": "10 nm", "thermal_conductivity": "2 W/(m K)"}}),
        ("plain", "friction by velocity",
         {"friction.by_velocity": [
             {"velocity": "1 m/s", "coefficient": 0.105},
             {"velocity": "4 m/s", "coefficient": 0.095}]}),
        ("hold", "earlier turns", {"disk.track_length": "0.34 m"}),
        ("discs", "earlier turns", {"pin.track_length": "314 mm", "disk.track_length": "314 mm"}),
        ("pin that turns on a disk at rest", "earlier turns", {"pin.track_length": "0.34 m"}),
        ("discs", "warming bulk",
         {"pin.capacity": {"diameter": "99.94930426 mm", "thickness": "10 mm"},
          "disk.capacity": {"diameter": "108.2253613 mm", "thickness": "10 mm"}}),
    ],
)  # fmt: skip
def test_an_effect_is_what_its_entries_switch_on(scene, kind, name, entries):
    effect = sound(physics_of(scene(SCENES[kind])))[name]
    assert set(effect.entry.split(" and ")) == set(entries)
    switched_on = scene(SCENES[kind] | entries).conditions.corrections.as_dict()
    sized = effect.scene.conditions.corrections.as_dict()
    for part in (switched_on, sized):  # without what only says which body moves
        part.pop("motion", None)
    assert flat(sized) == pytest.approx(flat(switched_on), rel=1e-6)


def test_warm_steel_conducts_worse_and_holds_more_heat(scene):
    """Of a carbon steel from 25 to 85 °C: conductivity 45 to 42 W/(m K), 470 to 520 J/(kg K)."""
    effect = sound(physics_of(scene()))["conductivity and specific heat when warm"]
    assert effect.size.startswith("-7% and +11%")
    warm = effect.scene.scene
    for body in (warm.pin.material, warm.disk):
        assert body.thermal_conductivity == pytest.approx(42.0)
        assert body.specific_heat == pytest.approx(520.0)


COULD, CANNOT = "could be counted", "cannot be sized"
TURNS, WARM = "earlier turns", "conductivity and specific heat when warm"
BOTH_TRACKS = "pin.track_length and disk.track_length and pin.diameter and disk.diameter"
MEASURED = {"measured": [
    {"load": "400 N", "velocity": "2 m/s", "friction": 0.11},
    {"load": "600 N", "velocity": "1 m/s", "friction": 0.12},
    {"load": "200 N", "velocity": "4 m/s"},
]}  # fmt: skip
DISK_AND_PIN = "discs 10 mm thick, 108 mm around the disk and {} mm around the pin, without a loss"


@pytest.mark.parametrize(
    ("entries", "name", "state", "size", "entry"),
    [
        ({}, "friction by velocity", COULD, "falling by 10% from 1 to 4 m/s",
         "friction.by_velocity"),
        (MEASURED, "friction by velocity", COULD,
         "0.11 to 0.12, as measured at the transitions", "friction.by_velocity"),
        ({"friction.coefficient": 0.0}, "friction by velocity", CANNOT, "there is no friction",
         "friction.by_velocity"),
        (SCENES["two bulk temperatures"], "friction by velocity", CANNOT,
         "the bulk temperatures differ, so that the rise is not proportional to friction",
         "friction.by_velocity"),
        ({"sweep.velocities": ["0 m/s", "1 m/s"]}, "friction by velocity", CANNOT,
         "the scene has one sliding velocity", "friction.by_velocity"),
        ({"sweep.velocities": ["1 m/s", "2 m/s"]}, "friction by velocity", COULD,
         "falling by 10% from 1 to 2 m/s", "friction.by_velocity"),
        ({}, "friction by temperature", CANNOT,
         "friction at two temperatures of the contact or more would have to be measured",
         "friction.by_temperature"),
        ({}, TURNS, COULD, "a track of 0.34 m", "disk.track_length"),
        (SCENES["nothing moves"], TURNS, CANNOT, "nothing moves", BOTH_TRACKS),
        ({"motion": {"slide_roll_ratio": 0.5}}, TURNS, COULD,
         "tracks of 0.0126 m around the pin and the disk", "pin.track_length and disk.track_length"
         ),  # the circumference of the pin
        ({"motion": {"slide_roll_ratio": 2}}, TURNS, COULD, "a track of 0.34 m",
         "disk.track_length"),
        ({"motion": {"slide_roll_ratio": -2}}, TURNS, COULD, "a track of 0.34 m",
         "pin.track_length"),
        (ROLLING | {"disk.track_length": "0.5 m"}, TURNS, COULD,
         "tracks of 0.314 m around the pin", "pin.track_length"),
        ({}, "warming bulk", COULD,
         "discs 10 mm thick, 108 mm around the disk, without a loss", "disk.capacity"),
        ({"disk.track_length": "0.6283 m"}, "warming bulk", COULD,
         "discs 10 mm thick, 200 mm around the disk, without a loss", "disk.capacity"),
        (ROLLING, "warming bulk", COULD, DISK_AND_PIN.format(100),
         "disk.capacity and pin.capacity"),
        ({"motion": {"slide_roll_ratio": -2}}, "warming bulk", COULD, DISK_AND_PIN.format(4),
         "disk.capacity and pin.capacity"),
        ({}, "stem and holder of the pin", COULD, "a rod 4 mm long, 13.6 mm² across", "pin.stem"),
        (BALL, "stem and holder of the pin", COULD, "a rod 4 mm long, 12.6 mm² across", "pin.stem"),
        (ROLLING, "stem and holder of the pin", CANNOT,
         "the pin turns, so that heat enters all around it", "pin.stem"),
        ({}, "oxide or tribofilm", COULD, "10 nm of 2 W/(m K) on the disk", "disk.film"),
        ({}, WARM, COULD, "-7% and +11%, a carbon steel at 85 °C", ""),
        ({"disk.material": "alumina"}, WARM, COULD,
         "-7% and +11%, a carbon steel at 85 °C, of the pin alone", ""),
        ({"pin.material": "alumina"}, WARM, COULD,
         "-7% and +11%, a carbon steel at 85 °C, of the disk alone", ""),
        (SCENES["alumina on AISI 316"], WARM, CANNOT,
         "neither body has the constants of a carbon steel, whose change is known", ""),
        ({}, "together", COULD, "all that could be counted, at once", ""),
    ],
)  # fmt: skip
def test_each_effect_says_how_large_it_is_or_why_it_has_no_size(
    scene, entries, name, state, size, entry
):
    effect = sound(physics_of(scene(entries)))[name]
    assert (effect.state, effect.size, effect.entry) == (state, size, entry)


def test_what_a_scene_counts_has_the_scene_without_it(scene):
    sweep = scene(SCENES["all counted"])
    found = {one.name: one for one in physics_of(sweep) if one.state == "counted"}
    assert [(one.name, one.entry, one.size) for one in found.values()] == [
        ("friction by velocity", "friction.by_velocity",
         "friction by velocity: measured, 1 times the coefficient"),
        ("earlier turns", "disk.track_length", "earlier turns of the disk: 0.34 m"),
        ("warming bulk", "pin.capacity and disk.capacity",
         "bulk of the pin: 20 J/K, bulk of the disk: 2 W/K"),
        ("stem and holder of the pin", "pin.stem", "stem of the pin: 8 K/W"),
        ("oxide or tribofilm", "disk.film", "film on the disk: 1e-08 m² K/W"),
    ]  # fmt: skip
    whole = sweep.conditions.corrections
    for name, one in found.items():
        without = one.scene.conditions.corrections
        has = (
            bool(without.friction.by_velocity), bool(without.track),
            bool(without.pin_bulk or without.disk_bulk), bool(without.stem),
            bool(without.film_resistance),
        )  # fmt: skip
        assert [*found][has.index(False)] == name
        assert has.count(False) == 1
        assert one.key == (f"without {name}", one.size)
    assert whole.film_resistance == pytest.approx(1e-8)


def test_all_that_could_be_counted_acts_at_once_and_no_single_one_does(scene):
    by_name = {one.name: one for one in physics_of(scene())}
    together = by_name["together"].scene.conditions.corrections
    assert together.friction.by_velocity == ((1.0, 1.05), (4.0, 0.95))
    assert together.track.length == 0.34
    assert together.film_resistance == pytest.approx(5e-9)
    assert together.disk_bulk.capacity == pytest.approx(
        math.pi / 4 * (0.34 / math.pi) ** 2 * 10e-3 * 7800 * 470
    )
    assert together.stem is not None
    assert by_name["oxide or tribofilm"].key == (
        "oxide or tribofilm", "10 nm of 2 W/(m K) on the disk"
    )  # fmt: skip
    counted = SCENES["all counted"]
    assert "together" not in {one.name for one in physics_of(scene(counted))}
    disk = {name: value for name, value in counted["disk"].items() if name != "film"}
    alone = counted | {"disk": disk}
    two = {name: value for name, value in alone.items() if name != "pin.stem"}
    for entries, is_said in ((alone, False), (two, True)):
        names = {one.name for one in physics_of(scene(entries)) if one.state == COULD}
        assert ("together" in names) == is_said


def test_measured_frictions_are_taken_over_that_of_the_scene_by_velocity(scene):
    (effect,) = (one for one in physics_of(scene(MEASURED)) if one.name == "friction by velocity")
    assert effect.scene.conditions.corrections.friction.by_velocity == (
        (1.0, pytest.approx(1.2)),
        (2.0, pytest.approx(1.1)),
    )
    assert effect.certainty == "as measured; load and velocity changed together in these tests"


@pytest.mark.parametrize(
    ("entry", "ends", "beyond"),
    [
        ("elastic_modulus", ("190 GPa", "220 GPa"), ("189 GPa", "221 GPa")),
        ("density", ("7600 kg/m^3", "8000 kg/m^3"), ("7599 kg/m^3", "8001 kg/m^3")),
        ("thermal_conductivity", ("30 W/(m K)", "60 W/(m K)"), ("29.9 W/(m K)", "60.1 W/(m K)")),
    ],
)
def test_a_carbon_steel_is_known_by_its_constants(scene, entry, ends, beyond):
    states = [
        sound(physics_of(scene({f"materials.steel.{entry}": value})))[WARM].state
        for value in (*ends, *beyond)
    ]
    assert states == [COULD, COULD, CANNOT, CANNOT]


def test_columns_in_closed_form_are_those_of_a_smooth_line_contact(scene):
    """Hertz: p₀ = √(E* F / (π R L)), 2 a = 4 F / (π p₀ L); alike bodies share by √ of speeds."""
    sweep = scene({"motion": {"slide_roll_ratio": 0.5}})
    columns = columns_in_closed_form(sweep, 400.0, 2.0, 1000.0)
    per_length, modulus = 400.0 / 3.4e-3, 210e9 / (1 - 0.3**2) / 2
    peak = math.sqrt(modulus * per_length / (math.pi * 2e-3))
    # Slip is half of the mean speed: 4 m/s, so that the bodies run at 5 and 3 m/s or 3 and 5.
    speeds = sweep.scene.velocities_at(2.0)
    assert sorted(map(abs, speeds)) == [3.0, 5.0]
    share = math.sqrt(abs(speeds.pin)) / (math.sqrt(3) + math.sqrt(5))
    assert columns["mean_pressure"] == pytest.approx(peak)
    assert columns["contact_width"] == pytest.approx(4 * per_length / (math.pi * peak))
    assert columns["pin_heat_share"] == pytest.approx(share)
    assert columns["time"][-1] == pytest.approx(400 / 150)
    assert columns["sliding_distance"][-1] == pytest.approx(2.0 * 400 / 150)
    assert columns["normal_load"][-1] == 400.0
    *before, end = columns["mean_rise"].tolist()
    assert end == 1000.0
    assert all(math.isnan(rise) for rise in before)
    assert {len(values) for values in columns.values()} == {len(columns["time"])}
    at_rest = columns_in_closed_form(scene(), 400.0, 2.0, 1000.0)
    assert at_rest["pin_heat_share"].tolist() == [0.0] * len(at_rest["time"])


def test_earlier_turns_that_are_not_counted_are_said_with_what_they_would_warm(scene):
    said = note_on_turns(scene(ROLLING))
    assert said.startswith(
        "earlier turns of the pin and the disk are not counted, as if each met a cold track: on "
        "tracks of 314 mm they would warm the contact by about "
    )
    assert said.endswith(
        " K more at 400 N and 2 m/s; give pin.diameter and disk.diameter and width, or track_length"
    )
    # All heat of the earlier turns is on the track at the next; half of it as the pin's is half.
    warming = [
        float(note.partition("about ")[2].split()[0])
        for note in (
            said,
            note_on_turns(scene(ROLLING | {"friction.coefficient": 0.2})),
            note_on_turns(scene(ROLLING | {"disk.track_length": "314 mm"})),
            note_on_turns(scene(ROLLING), 800.0, 2.0),
        )
    ]
    assert warming[1] == pytest.approx(2 * warming[0], rel=0.1)
    assert 0 < warming[2] < warming[0] < warming[3]
    at_load = note_on_turns(scene(ROLLING), 800.0, 3.0)
    assert "K more at 800 N and 3 m/s" in at_load
    alone = note_on_turns(scene(ROLLING | {"disk.track_length": "314 mm"}))
    assert "turns of the pin are not" in alone
    assert "give pin.diameter and width" in alone
    for entries in ({}, {"motion": {"slide_roll_ratio": 2}}, {"motion": {"slide_roll_ratio": -2}}):
        assert note_on_turns(scene(entries)) is None
    assert note_on_turns(scene(ROLLING), velocity=0.0) is None
    counted = {"pin.track_length": "314 mm", "disk.track_length": "314 mm"}
    assert note_on_turns(scene(ROLLING | counted)) is None


@pytest.mark.parametrize(
    ("entries", "is_said"), [({}, True), (BALL, False), (ROLLING, False), (CROWNED, False)]
)
def test_sharp_ends_are_said_of_a_cylinder_at_rest(scene, entries, is_said):
    note = note_on_ends(scene(entries))
    assert (note is not None) == is_said
    assert note is None or note.startswith("the pin is computed in its middle: if its ends are")


def flat(parts, path=()):
    """Numbers of nested parts, by their place."""
    if isinstance(parts, dict | list | tuple):
        pairs = parts.items() if isinstance(parts, dict) else enumerate(parts)
        return {k: v for name, part in pairs for k, v in flat(part, (*path, name)).items()}
    return {} if parts is None else {path: parts}

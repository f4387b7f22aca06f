"""The table of what a scene counts, could count, and what cannot be sized."""

from pathlib import Path

import pytest

import pipeline
from pipeline.sweep.physics import physics_of
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


def flat(parts, path=()):
    """Numbers of nested parts, by their place."""
    if isinstance(parts, dict | list | tuple):
        pairs = parts.items() if isinstance(parts, dict) else enumerate(parts)
        return {k: v for name, part in pairs for k, v in flat(part, (*path, name)).items()}
    return {} if parts is None else {path: parts}

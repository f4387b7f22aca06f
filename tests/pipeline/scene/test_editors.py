"""The JSON schema of scene files, as an editor uses it (pipeline/scene/reference.py)."""

import json
import tomllib

import jsonschema
import pytest

from pipeline.scene.reference import schema
from pipeline.scene.shipped import shipped_scenes
from pipeline.scene.template import new_scene

VALIDATOR = jsonschema.Draft7Validator(schema())


def faults(text):
    return list(VALIDATOR.iter_errors(tomllib.loads(text)))


def test_the_schema_is_one():
    jsonschema.Draft7Validator.check_schema(schema())


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_and_new_ones_fit(name, tmp_path):
    assert not faults(shipped_scenes()[name].read_text(encoding="utf-8"))
    new_scene(tmp_path / "mine.toml", like=name)
    assert not faults((tmp_path / "mine.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "text",
    [
        'oil = "medicinal white oil"',
        '[disk]\nmaterial = "AISI 52100"\nroughness.correlation_length = ["10 um", "5 um"]',
        '[sweep.loads]\nfrom = "100 N"\nto = "300N"\nstep = "1e2 N"',
        '[oil]\npressure_viscosity_coefficient = "20 1/GPa"',
        '[materials.mine]\nlike = "AISI 52100"\nhardness = "62 HRC"',
        '[unknown.temperature.critical]\nmean = "145 degC"\nsd = "8 K"',
        '[unknown]\n"disk.roughness.seed" = [0, 1, 2]',
        '[unknown]\n"pin.radius" = { from = "1 mm", to = "2 mm", correlated = { a.b = 0.5 } }',
    ],
)
def test_what_a_scene_may_say_fits(text):
    assert not faults(text)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[pin]\nradius = 2", ["pin", "radius"]),
        ('[pin]\nradius = "2"', ["pin", "radius"]),
        ('[pin]\nradius = "2,5 mm"', ["pin", "radius"]),
        ('[pin]\nshape = "cone"', ["pin", "shape"]),
        ("[pin]\nlenght = 1", ["pin"]),
        ("[friction]\ncoefficient = -0.1", ["friction", "coefficient"]),
        ("[window]\npixels = [1, 2, 3]", ["window", "pixels"]),
        ("[window]\npixels = [1.5, 2]", ["window", "pixels", 0]),
        ('[sweep]\nloads = ["1 N", "1 N"]', ["sweep", "loads"]),
        ('[unknown]\n"friction.coefficient" = { mean = 0.1 }', ["unknown", "friction.coefficient"]),
    ],
)
def test_what_it_may_not_say_is_a_fault_at_its_place(text, place):
    (fault,) = faults(text)
    assert list(fault.absolute_path) == place


def test_every_entry_explains_itself():
    pin = schema()["properties"]["pin"]["properties"]
    assert pin["crown_radius"]["description"].endswith(".")
    assert pin["radius"]["examples"] == ["2 mm"]


def test_the_command_writes_it_once(tmp_path, irg):
    out = tmp_path / "scene.schema.json"
    assert "#:schema ./scene.schema.json" in irg("new", "--schema", out)
    assert json.loads(out.read_text(encoding="utf-8")) == schema()
    assert "exists already" in irg("new", "--schema", out, code=2)
    assert "a schema is a JSON file" in irg("new", "--schema", tmp_path / "scene.toml", code=2)
    assert f"there is no folder {tmp_path / 'no'}" in irg(
        "new", "--schema", tmp_path / "no" / "scene.json", code=2
    )

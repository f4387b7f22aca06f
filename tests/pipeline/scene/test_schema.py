"""The JSON Schema by which editors check scenes: it agrees with the reader."""

import json
import tomllib

import jsonschema
import pytest

import pipeline
from pipeline.scene.shipped import shipped_scenes

WHOLE = shipped_scenes()["irg_transition"].read_text("utf-8")
SHORT = shipped_scenes()["first_try"].read_text("utf-8")


@pytest.fixture(scope="module")
def check(tmp_path_factory):
    path = tmp_path_factory.mktemp("new") / "mine.toml"
    *_, schema = pipeline.new_scene(path, full=True)
    assert path.read_text("utf-8").startswith(f"#:schema ./{schema.name}\n")
    validator = jsonschema.Draft7Validator(json.loads(schema.read_text("utf-8")))
    return lambda text: [fault.message for fault in validator.iter_errors(tomllib.loads(text))]


@pytest.mark.parametrize("name", shipped_scenes())
def test_each_shipped_scene_is_valid(name, check):
    assert check(shipped_scenes()[name].read_text("utf-8")) == []


@pytest.mark.parametrize(
    ("scene", "right", "wrong"),
    [
        (WHOLE, "radius =", "radus ="),
        (WHOLE, '"2 mm"', '"2"'),
        (WHOLE, '"2 mm"', "2"),
        (WHOLE, 'shape = "cylinder"', ""),
        (WHOLE, "[friction]", "[frction]"),
        (WHOLE, "hurst_exponent = 0.8", "hurst_exponent = 1.8"),
        (WHOLE, 'velocity = "1.25 m/s"', ""),
        (SHORT, '"standard"', '"drat"'),
        (SHORT, "step =", "stp ="),
    ],
)
def test_the_schema_refuses_what_the_reader_refuses(scene, right, wrong, check, tmp_path):
    assert scene.count(right) >= 1
    text = scene.replace(right, wrong, 1)
    assert check(text)
    (tmp_path / "wrong.toml").write_text(text, "utf-8")
    with pytest.raises(pipeline.SceneFileError):
        pipeline.load_scene(tmp_path / "wrong.toml")


def test_the_command_prints_it_and_keeps_a_file_that_is_there(tmp_path, irg):
    printed = json.loads(irg("new", "--schema"))
    radius = printed["properties"]["pin"]["properties"]["radius"]
    assert "from 1e-12 m to 1e5 m; usually 0.1 to 1000 mm" in radius["description"]
    assert printed["properties"]["temperature"]["properties"]["failing_share"]["default"] == 0.1
    (tmp_path / "irg.schema.json").write_text("mine")
    irg("new", tmp_path / "mine.toml")
    assert (tmp_path / "irg.schema.json").read_text() == "mine"

"""A place outside the plane gets the command that adds it."""

import json
import re
import shlex

import pytest

import pipeline
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all

RANGE = 'velocities = { from = "1 m/s", to = "2 m/s", step = "0.5 m/s" }'


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Store of a small scene with a list of loads and a range of velocities."""
    scene = tmp_path_factory.mktemp("outside") / "own.toml"
    text = SCENE.replace("increments = 10", "increments = 1")
    scene.write_text(re.sub("velocities = .*", RANGE, text))
    commit_all(scene.with_suffix(".zarr"), pipeline.load_scene(scene))
    return scene.with_suffix(".zarr")


@pytest.mark.parametrize(
    ("load", "velocity", "points"),
    [
        ("300 N", "2.7 m/s", "15: 3 loads, 5 velocities"),  # to 3 m/s
        ("300 N", "0.6 m/s", "12: 3 loads, 4 velocities"),  # from 0.5 m/s
        ("300 N", "0.1 m/s", "12: 3 loads, 4 velocities"),  # a list
        ("650.5 N", "1 m/s", "12: 4 loads, 3 velocities"),
    ],
)
def test_a_place_outside_gets_the_command_that_adds_it(
    store, irg, monkeypatch, load, velocity, points
):
    said = irg("margin", store, "--load", load, "--velocity", velocity, code=2)
    command = shlex.split(re.search("this adds it: irg (.+)", said)[1])
    assert command[:4] == ["run", "own.toml", "-o", str(store)]
    monkeypatch.chdir(store.parent)
    assert f"points   {points}" in irg("check", "own.toml", *command[4:])
    (value,) = re.findall(r"[\d.]+", velocity if "velocity" in said.split(" is ")[0] else load)
    path, _, text = command[-1].partition("=")
    entry = json.loads(text) if text.startswith("[") else text
    wanted = pipeline.load_scene("own.toml", overrides={path: entry})
    ends = wanted.velocities if "velocit" in path else wanted.loads
    assert ends[0] <= float(value) <= ends[-1]

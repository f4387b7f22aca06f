"""A new shape of the pin is a class in `tribo.PINS`; if it has a length, it is a line contact."""

import json

import pytest

from tests.helpers.processes import python
from tests.helpers.scenes import SCENE

PROGRAM = """
import json
from dataclasses import dataclass
import numpy as np
import tribo

@dataclass(frozen=True)
class Roof(tribo.Cylinder):
    def profile(self, grid):
        return 0.5 * super().profile(grid)

@dataclass(frozen=True)
class Knob(tribo.Ball):
    pass

tribo.PINS |= {"roof": Roof, "knob": Knob}  # before the reader is imported

import pipeline

def scene(name, **options):
    return pipeline.load_scene(f"{name}.toml", **options)

def rise(sweep):
    return float(pipeline.run_point(sweep, "400 N", "2 m/s").columns["max_rise"][-1])

roof, wide, knob = scene("roof"), scene("wide"), scene("knob")
cylinder = scene("cylinder")
try:
    scene("short")
except pipeline.SceneFileError as error:
    fault = str(error)
sweeps = {"roof": roof, "wide": wide, "cylinder": cylinder}
print(json.dumps({
    "classes": [type(one.scene.pin).__name__ for one in (roof, knob)],
    "periodic": [one.scene.pixels.periodic for one in (roof, knob)],
    "rises": {name: rise(one) for name, one in sweeps.items()},
    "fault": fault,
}))
"""
LENGTH = 'length = "3.4 mm"\n'


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shapes")
    few = SCENE.replace("increments = 10", "increments = 4")
    scenes = {
        "cylinder": few,
        "roof": few.replace('"cylinder"', '"roof"'),
        "wide": few.replace('radius = "2 mm"', 'radius = "4 mm"'),
        "knob": few.replace('"cylinder"', '"knob"').replace(LENGTH, ""),
        "short": few.replace('"cylinder"', '"roof"').replace(LENGTH, ""),
    }
    for name, text in scenes.items():
        (folder / f"{name}.toml").write_text(text)
    (folder / "shapes.py").write_text(PROGRAM)
    done = python("shapes.py", cwd=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_shape_with_a_length_has_no_free_ends(found):
    """A cylinder whose profile is halved is one of twice the radius."""
    assert found["classes"] == ["Roof", "Knob"]
    assert found["periodic"] == [[False, True], [False, False]]
    rises = found["rises"]
    assert rises["roof"] == pytest.approx(rises["wide"], rel=1e-3)
    assert rises["roof"] != pytest.approx(rises["cylinder"], rel=1e-2)


def test_a_shape_asks_for_the_length_that_its_class_declares(found):
    assert "pin.length: missing; a roof pin needs it" in found["fault"]

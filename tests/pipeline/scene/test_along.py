"""Pairs: rows of a file or of the scene, each with a place and entries of its own."""

import math

import pytest

import pipeline
from pipeline.scene.faults import SceneFileError
from pipeline.sweep.plan import points
from tests.helpers.scenes import SCENE

TABLES = """along = [
  { "pin.radius" = "3 mm", "friction.coefficient" = 0.1, load = "300 N", velocity = "1 m/s" },
  { "pin.radius" = "4 mm", "friction.coefficient" = 0.12, load = "600 N", velocity = "2 m/s" },
]"""
FILE = """pin.radius [mm],friction.coefficient,load [N],velocity [m/s],flank
3,0.1,300,1,a
4,0.12,600,2,b
"""


def scene(tmp_path, along='along = "mesh.csv"', rows=FILE):
    (tmp_path / "mesh.csv").write_text(rows)
    (tmp_path / "scene.toml").write_text(SCENE.replace("[sweep]", f"[sweep]\n{along}"))
    return tmp_path / "scene.toml"


def faults(path):
    with pytest.raises(SceneFileError) as caught:
        pipeline.load_scene(path)
    return " ".join(caught.value.faults)


@pytest.mark.parametrize("along", [TABLES, 'along = "mesh.csv"'])
def test_each_row_has_its_place_and_its_entries(tmp_path, along):
    sweep = pipeline.load_scene(scene(tmp_path, along))
    assert [(point.load, point.velocity) for point in points(sweep)] == [(300.0, 1.0), (600.0, 2.0)]
    first, second = (sweep.variant(name) for name in sweep.variants.names)
    assert (first.scene.pin.radius, second.scene.pin.radius) == (3e-3, 4e-3)
    assert (first.conditions.friction, second.conditions.friction) == (0.1, 0.12)


def test_a_rotation_is_a_velocity_where_a_column_has_the_radius(tmp_path):
    rows = "load [N],speed [rpm],track diameter [mm]\n300,600,50\n"
    (point,) = points(pipeline.load_scene(scene(tmp_path, rows=rows)))
    assert point.velocity == pytest.approx(600 / 60 * math.pi * 0.05)
    assert "at radius" in faults(scene(tmp_path, TABLES.replace("1 m/s", "600 rpm")))

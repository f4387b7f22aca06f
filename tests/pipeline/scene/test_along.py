"""Pairs: rows of a file or of the scene, each with a place and entries of its own."""

import math

import pytest

import pipeline
from pipeline import SceneFileError
from pipeline.cli import main
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
    first, second = (sweep.case(name) for name in sweep.case_table.names)
    assert (first.scene.pin.radius, second.scene.pin.radius) == (3e-3, 4e-3)
    assert (first.conditions.friction, second.conditions.friction) == (0.1, 0.12)
    assert sweep.case_table.column("pin_radius") == (3e-3, 4e-3)


def test_a_label_in_numbers_is_in_si(tmp_path):
    heads = "cycle time [min],angle [deg],flank,load [N],velocity [m/s]"
    rows = f"{heads}\n0.5,30,2a,300,1\n1,60,3b,600,2\n"
    table = pipeline.load_scene(scene(tmp_path, rows=rows)).case_table
    held = {column.name: (table.column(column.name), column.unit) for column in table.columns}
    assert held["cycle_time"] == ((30.0, 60.0), "s")
    assert held["angle"] == (pytest.approx((math.pi / 6, math.pi / 3)), "rad")
    assert held["flank"] == (("2a", "3b"), None)


def test_check_and_run_refuse_a_label_that_the_dataset_uses_before_they_make_a_store(
    tmp_path, capsys
):
    out = tmp_path / "out.zarr"
    for name, command in (("time", ["check"]), ("max_rise", ["run", "-o", str(out)])):
        path = scene(tmp_path, rows=FILE.replace("flank", name))
        assert main([*command, str(path)]) == 2
        assert f"is called {name}, as is one of the dataset; give it" in capsys.readouterr().err
    assert not out.exists()

"""Pairs: rows of a file or of the scene, each with a place and entries of its own."""

import math
from dataclasses import replace

import pytest

import pipeline
from pipeline.sweep.plan import points
from tests.helpers.scenes import SCENE

OTHERS = {  # entries of each kind, with two values
    "pin.radius": ("2 mm", "2.1 mm"), "materials.steel.hardness": ("6 GPa", "700 HV"),
    "wear.specific_wear_rate": ("1e-6 mm^3/(N m)", "2e-15 m^2/N"),
    "temperature.bulk": ("30 degC", "310 K"), "loading.rate": ("150 N/s", "10 N/s"),
    "friction.coefficient": (0.1, "12 %"), "disk.roughness.seed": (0, 1),
    "fidelity.increments": (10, 7), "wear.pattern": ("swept", "local"),
    "pin.material": ("steel", "100Cr6"), "disk.track_length": ("30 cm", "400 mm"),
    "model.bias": (0.06, "5 %"),
}  # fmt: skip
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


@pytest.mark.parametrize("along", [TABLES, 'along = "mesh.csv"'])
def test_each_row_has_its_place_and_its_entries(tmp_path, along):
    sweep = pipeline.load_scene(scene(tmp_path, along))
    assert [(point.load, point.velocity) for point in points(sweep)] == [(300.0, 1.0), (600.0, 2.0)]
    first, second = (sweep.case(name) for name in sweep.case_table.names)
    assert (first.scene.pin.radius, second.scene.pin.radius) == (3e-3, 4e-3)
    assert (first.conditions.friction, second.conditions.friction) == (0.1, 0.12)
    assert sweep.case_table.column("pin_radius") == (3e-3, 4e-3)


@pytest.mark.parametrize("path", OTHERS)
def test_an_entry_in_a_row_is_the_entry_in_the_scene(tmp_path, path):
    (tmp_path / "scene.toml").write_text(SCENE.replace("fields = true", ""))
    both = OTHERS[path]
    rows = [{path: one, "load": "300 N", "velocity": "1 m/s"} for one in both]
    sweep = pipeline.load_scene(tmp_path / "scene.toml", overrides={"sweep.along": rows})
    alone = [pipeline.load_scene(tmp_path / "scene.toml", overrides={path: one}) for one in both]
    assert [replace(case, name=()) for case in sweep.cases] == [one.base for one in alone]
    assert alone[0].base != alone[1].base


def test_a_label_in_numbers_is_in_si(tmp_path):
    heads = "cycle time [min],angle [deg],flank,load [N],velocity [m/s]"
    rows = f"{heads}\n0.5,30,2a,300,1\n1,60,3b,600,2\n"
    table = pipeline.load_scene(scene(tmp_path, rows=rows)).case_table
    held = {column.name: (table.column(column.name), column.unit) for column in table.columns}
    assert held["cycle_time"] == ((30.0, 60.0), "s")
    assert held["angle"] == (pytest.approx((math.pi / 6, math.pi / 3)), "rad")
    assert held["flank"] == (("2a", "3b"), None)


def test_check_refuses_a_label_that_the_dataset_uses(tmp_path, irg):
    path = scene(tmp_path, rows=FILE.replace("flank", "max_rise"))
    assert "is called max_rise, as is one of the dataset; give it" in irg("check", path, code=2)

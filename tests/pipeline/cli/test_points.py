"""Tables of operating points in; tables of margins out."""

import csv

import pandas as pd
import pytest

import pipeline
from pipeline.cli import main
from tests.helpers import synthetic
from tests.helpers.answer_at import asked, named

DUTY = "flank;load [kN];velocity [m/min];remark\nA;0.3;90;cold start\nB;0.5;120;\nC;9;120;\n"


@pytest.fixture
def store(monkeypatch):
    ds = synthetic.sweep()
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    return ds


def test_each_row_gets_the_margin_of_its_point_and_keeps_its_further_columns(store, tmp_path):
    duty, out = tmp_path / "duty.csv", tmp_path / "margins.csv"
    duty.write_text(DUTY)
    assert main(["margin", "out.zarr", "--points", str(duty), "-o", str(out), "-q"]) == 0
    with out.open(newline="") as file:
        first, second, beyond = csv.DictReader(file)
    for row, place in ((first, (300.0, 1.5)), (second, (500.0, 2.0))):
        here = asked(store, *place)
        assert (float(row["load [N]"]), float(row["velocity [m/s]"])) == place
        assert float(row["temperature margin [K]"]) == pytest.approx(
            here.temperature_margin, rel=1e-5
        )
        assert float(row["critical velocity [m/s]"]) == pytest.approx(here.critical_velocity, 1e-5)
        assert row["verdict"] == here.verdict
    assert (first["flank"], first["remark"]) == ("A", "cold start")
    assert beyond["verdict"] == "unknown"
    assert "load 9000 N is outside the sweep" in beyond["reason"]


def test_all_faults_of_a_table_are_named_with_row_and_column(store, tmp_path, irg):
    duty = tmp_path / "duty.csv"
    duty.write_text("load [N],velocity [m/s]\n400,2\n-1,2\n400,fast\n")
    said = irg("margin", "out.zarr", "--points", duty, code=2)
    assert "duty.csv: 2 faults" in said
    assert 'row 3, load [N]: "-1 N" is out of range; give a load above 0' in said
    assert 'row 4, velocity [m/s]: "fast" is not a number' in said
    duty.write_text("load [N],velocity [m/s]\n400,2\n400\n")
    said = irg("margin", "out.zarr", "--points", duty, code=2)
    assert "row 3 has 1 cell below 2 headings" in said


FORMS = {
    "csv": "part,load [N],velocity [m/s],bulk temperature [degC],friction\n"
    "A,400,1.2,60,0.12\nB,400,1.2,25,0.1\n",
    "paths": "part,load [N],velocity [m/s],temperature.bulk [degC],friction.coefficient\n"
    "A,400,1.2,60,0.12\nB,400,1.2,25,0.1\n",
}


@pytest.mark.parametrize("form", [*FORMS, "xlsx", "mapping", "frame"])
def test_a_row_is_judged_by_its_own_friction_and_temperatures(store, tmp_path, form):
    points = tmp_path / "duty.csv"
    if form in FORMS:
        points.write_text(FORMS[form], encoding="utf-8")
    columns = {
        "load [N]": [400.0, 400.0],
        "velocity [m/s]": [1.2, 1.2],
        "bulk temperature [degC]": [60.0, 25.0],
        "friction": [0.12, 0.1],
    }
    if form == "xlsx":
        points = tmp_path / "duty.xlsx"
        pd.DataFrame(columns).to_excel(points, index=False)
    if form == "mapping":
        points = {
            "load": ["400 N"] * 2, "velocity": [1.2, 1.2],
            "bulk_temperature": [333.15, 298.15], "friction": [0.12, 0.1],
        }  # fmt: skip
    if form == "frame":
        points = pd.DataFrame(columns)
    table = pipeline.margin(store, points)
    own = {"bulk_temperature": "60 degC", "friction": 0.12}
    for row, conditions in enumerate((own, {})):
        here = asked(store, 400.0, 1.2, **conditions)
        assert table["temperature_margin"].values[row] == pytest.approx(
            here.temperature_margin, rel=1e-9
        )
        assert named(table["verdict"])[row] == here.verdict
    assert table["temperature_margin"][0] < table["temperature_margin"][1] - 35


def test_further_columns_are_kept_and_the_limit_of_a_row_judges_it(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    text = "part,load [N],velocity [m/s],critical temperature [°C]\nA,400,1.2,100\n"
    points.write_text(text, encoding="utf-8")
    (record,) = irg("margin", "out.zarr", "--points", points, "--json")
    here = asked(store, 400.0, 1.2, critical_temperature="100 degC")
    assert record["part"] == "A"
    assert record["temperature margin [K]"] == pytest.approx(here.temperature_margin, rel=1e-9)
    assert record["probability low"] == pytest.approx(here.probability_low, rel=1e-9)
    assert record["temperature error discretization [K]"] == pytest.approx(
        here.temperature_error_discretization, rel=1e-9
    )


@pytest.mark.parametrize("head", ["pin.radius [mm]", "wear.specific_wear_rate"])
def test_entries_that_need_a_run_are_refused_in_a_table(store, tmp_path, irg, head):
    points = tmp_path / "duty.csv"
    points.write_text(f"load [N],velocity [m/s],{head}\n400,1.2,3\n")
    said = irg("margin", "out.zarr", "--points", points, code=2)
    assert f'the column "{head}" is unknown; rename it to one of load, velocity, friction' in said


def test_each_friction_has_its_verdict_in_at_most_fourteen_lines(store, irg):
    place = ["--load", "400 N", "--velocity", "1.4 m/s"]
    alone = irg("margin", "out.zarr", *place).splitlines()
    assert alone[0].startswith("Mild: probability of severe wear ")
    assert len(alone) <= 14
    assert max(map(len, alone)) <= 100
    both = irg("margin", "out.zarr", *place, "--friction", "0.05", "--friction", "0.2")
    assert {"friction 0.05:", "friction 0.2:"} <= {*both.splitlines()}


def test_a_verdict_states_its_friction_and_temperatures_and_the_frictions_of_tests(store, irg):
    place = ["--load", "400 N", "--velocity", "1.4 m/s"]
    held = (
        "friction 0.12 (tests 0.091 to 0.103), bulk temperature 60 °C, critical temperature 150 °C"
    )
    own = [
        "--friction",
        0.12,
        "--bulk-temperature",
        "60 degC",
        "--critical-temperature",
        "150 degC",
    ]
    said = " ".join(irg("margin", "out.zarr", *place, *own).split())
    assert f" conditions {held} " in said
    said = irg("margin", "out.zarr", *place, "--friction", 0.12, "--without-tests")
    assert "  friction 0.12, bulk temperature 25 °C, critical temperature 145 °C" in said
    said = " ".join(irg("boundary", "out.zarr", *own).split())
    assert said.startswith(f"conditions: {held}")


def test_the_rows_of_a_table_state_their_own_conditions(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text(FORMS["csv"])
    first, second = irg("margin", "out.zarr", "--points", points, "--json")
    assert (first["friction"], first["bulk temperature [°C]"]) == (0.12, 60)
    assert (second["friction"], second["bulk temperature [°C]"]) == (0.1, 25)


def test_a_text_of_too_many_rows_is_refused_before_its_rows_are_read(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s]\n" + "400,1.5\n" * 200_000)
    said = irg("margin", "out.zarr", "--points", points, code=2)
    assert "has 200000 rows; at most 100000" in said


def test_a_long_table_shows_the_worst_points(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    rows = [f"{300 + 10 * k},{1 + 0.05 * k}" for k in range(20)]
    points.write_text("load [N],velocity [m/s]\n" + "\n".join(rows))
    said = irg("margin", "out.zarr", "--points", points)
    lines = said.splitlines()
    assert max(map(len, lines)) <= 100
    assert "12 more rows: use --all, or -o TABLE.csv" in said
    record = irg("margin", "out.zarr", "--points", points, "--json")
    worst = min(record, key=lambda one: one["temperature margin [K]"])
    shown = [line.split() for line in lines if line.split()[:1] and line.split()[0].isdigit()]
    assert f"{worst['load [N]']:g}" in [row[0] for row in shown if len(row) > 2]
    assert len(irg("margin", "out.zarr", "--points", points, "--all").splitlines()) > 24


def test_a_critical_area_fraction_of_a_row_is_judged_and_a_probability_said_in_words(
    store, tmp_path, irg
):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s],critical area fraction [%]\n400,1.2,10\n400,2.2,1\n")
    assert "less than 1 %" in irg("margin", "out.zarr", "--points", points)
    first, second = irg("margin", "out.zarr", "--points", points, "--json")
    usual, few = asked(store, 400.0, 1.2), asked(store, 400.0, 2.2, critical_area_fraction=0.01)
    for row, here in ((first, usual), (second, few)):
        assert row["temperature margin [K]"] == pytest.approx(here.temperature_margin, rel=1e-9)
        assert row["probability"] == pytest.approx(here.probability, rel=1e-9)


def test_a_path_typed_in_a_shell_is_relative_to_the_shell(tmp_path, irg, monkeypatch):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "rows.csv").write_text("load [N],velocity [m/s]\n400,1.2\n500,1.4\n")
    scene = tmp_path / "scenes" / "own.toml"
    scene.write_text('extends = "first_try"\nwithout = ["sweep.loads", "sweep.velocities"]\n')
    monkeypatch.chdir(tmp_path)
    said = irg("check", "scenes/own.toml", "--set", "sweep.along=rows.csv")
    assert "points   2: 2 cases" in said

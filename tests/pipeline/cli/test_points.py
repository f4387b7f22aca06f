"""Tables of operating points in; tables of margins out."""

import csv
import math

import pandas as pd
import pytest

import pipeline
from pipeline.cli import main
from tests.helpers import synthetic

DUTY = "flank;load [kN];velocity [m/min];remark\n1;0.3;90;cold start\n2;0.5;120;\n3;9;120;\n"


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
        margin = pipeline.margin(store, *place)
        assert (float(row["load [N]"]), float(row["velocity [m/s]"])) == place
        assert float(row["distance [K]"]) == pytest.approx(margin.distance, rel=1e-5)
        assert float(row["velocity factor"]) == pytest.approx(margin.velocity_factor, rel=1e-5)
        assert row["verdict"] == margin.verdict
    assert (first["flank"], first["remark"]) == ("1", "cold start")
    assert beyond["verdict"] == "not known"
    assert "load is 9000 N; the sweep has" in beyond["notes"]


def test_all_faults_of_a_table_are_named_with_row_and_column(store, tmp_path, irg):
    duty = tmp_path / "duty.csv"
    duty.write_text("load [N],velocity [m/s]\n400,2\n\n-1,2\n400,fast\n400\n")
    said = irg("margin", "out.zarr", "--points", duty, code=2)
    assert "duty.csv: 2 faults" in said
    assert 'row 4, load: "-1 N" is out of range; give a load above 0' in said
    assert 'row 5, velocity: "fast m/s"' in said
    duty.write_text("load [N],velocity [m/s]\n400,2\n400\n")
    said = irg("margin", "out.zarr", "--points", duty)
    assert said.startswith("2 rows: 1 used, 1 left out: row 3 has no velocity\n1 operating point")


FORMS = {
    "csv": "part,load [N],velocity [m/s],bulk temperature [degC],friction\n"
    "A,400,1.2,60,0.12\nB,400,1.2,25,0.1\n",
    "German": "Teil;Last [N];Geschwindigkeit [m/s];Öltemperatur [°C];Reibwert\n"
    "A;400;1,2;60;0,12\nB;400;1,2;25;0,1\n",
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
        margin = pipeline.margin(pipeline.at(store, **conditions), 400.0, 1.2)
        assert table["distance [K]"][row] == margin.distance
        assert table["verdict"][row] == margin.verdict
    assert table["distance [K]"][0] < table["distance [K]"][1] - 35


def test_what_is_not_used_is_named_and_what_cannot_act_refused(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("part,load [N],velocity [m/s],Grenztemperatur [°C]\nA,400,1.2,100\n")
    assert "columns shown, but not judged by: part" in irg("margin", "out.zarr", "--points", points)
    (record,) = irg("margin", "out.zarr", "--points", points, "--json")
    hot = pipeline.at(store, critical_temperature="100 degC")
    margin = pipeline.margin(hot, 400.0, 1.2)
    assert record["distance [K]"] == margin.distance
    assert (record["lowest probability"], record["highest probability"]) == (
        margin.lowest,
        margin.highest,
    )
    assert record["error by the preset [K]"] == margin.error.preset
    assert record["model error"] == margin.model_error
    points.write_text("oil,pin,load [N],velocity [m/s]\nFVA 3,a,400,1.2\n")
    assert "columns shown, but not judged by: oil, pin" in irg(
        "margin", "out.zarr", "--points", points
    )
    for head in ("pin.radius [mm]", "hold [s]", "wear.specific_wear_rate"):
        points.write_text(f"load [N],velocity [m/s],{head}\n400,1.2,3\n")
        said = irg("margin", "out.zarr", "--points", points, code=2)
        assert f'column "{head}" cannot act after the simulation' in said


def test_the_track_of_a_rotation_counts_as_used_and_a_lone_mu_is_no_unit(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text(
        "load [N],speed [rpm],track diameter [mm],friction coefficient µ\n400,300,80,0.12\n",
        encoding="utf-8",
    )
    assert "not judged by" not in irg("margin", "out.zarr", "--points", points)
    (record,) = irg("margin", "out.zarr", "--points", points, "--json")
    margin = pipeline.margin(pipeline.at(store, friction=0.12), 400.0, math.pi * 0.08 * 5)
    assert record["distance [K]"] == pytest.approx(margin.distance)


def test_conditions_of_a_row_in_another_unit_are_doubted_or_refused(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s],bulk_temperature [degC],friction\n400,1,298,10\n")
    said = irg("margin", "out.zarr", "--points", points)
    assert "friction: 10, where 0 to 1 are usual" in said
    assert "bulk temperature: 298 °C, where" in said
    points.write_text("load [N],velocity [m/s],bulk_temperature [K]\n400,1,25\n")
    assert "out of range, which is from -53 degC" in irg(
        "margin", "out.zarr", "--points", points, code=2
    )


def test_each_friction_has_its_verdict_in_at_most_fourteen_lines(store, irg):
    place = ["--load", "400 N", "--velocity", "1.4 m/s"]
    alone = irg("margin", "out.zarr", *place).splitlines()
    assert alone[0].startswith("Mild: severe wear is ")
    assert len(alone) <= 14
    assert max(map(len, alone)) <= 100
    both = irg("margin", "out.zarr", *place, "--friction", "0.05", "--friction", "0.2")
    assert {"friction_coefficient 0.05:", "friction_coefficient 0.2:"} <= {*both.splitlines()}


def test_a_verdict_states_its_friction_and_temperatures_and_the_frictions_of_tests(store, irg):
    place = ["--load", "400 N", "--velocity", "1.4 m/s"]
    held = "friction 0.12 (tests 0.091 to 0.103), bulk 60 °C, critical temperature 150 °C"
    own = [
        "--friction",
        0.12,
        "--bulk-temperature",
        "60 degC",
        "--critical-temperature",
        "150 degC",
    ]
    assert irg("margin", "out.zarr", *place, *own).splitlines()[1].endswith(f"  {held}")
    said = irg("margin", "out.zarr", *place, "--friction", 0.12, "--without-tests")
    assert "  friction 0.12, bulk 25 °C, critical temperature 145 °C" in said
    assert irg("margin", "out.zarr", *place, *own, "--json")[0]["conditions"] == held
    limit, rest = irg("boundary", "out.zarr", *own).splitlines()[:2]
    assert limit.endswith("above 150 °C; friction 0.12 (tests 0.091 to 0.103), bulk"), rest


def test_the_rows_of_a_table_state_their_own_conditions(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text(FORMS["csv"])
    said, heads = irg("margin", "out.zarr", "--points", points), "friction 0.12 (tests 0.091 to"
    assert f"judged at {heads} 0.103), bulk 60 °C, critical temperature 145 °C; 1 more" in (
        " ".join(said.split())
    )
    first, second = irg("margin", "out.zarr", "--points", points, "--json")
    assert first["conditions"].startswith(heads)
    assert second["conditions"].startswith("friction 0.1 (tests 0.091 to 0.103), bulk 25 °C")


def test_a_text_of_too_many_rows_is_refused_before_its_rows_are_read(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s]\n" + "400,1.5\n" * 200_000)
    said = irg("margin", "out.zarr", "--points", points, code=2)
    assert "has 200001 rows, and at most 100000 can be used here; keep fewer, such as one of 3" in (
        said
    )
    said = irg("check", "first_try", "--set", f"sweep.along={points}", code=2)
    assert "at most 10000 can be used here; keep fewer, such as one of 21" in said


def test_a_long_table_has_fourteen_lines_the_worst_points_and_hours_by_verdict(
    store, tmp_path, irg
):
    points = tmp_path / "duty.csv"
    rows = [f"{300 + 10 * k},{1 + 0.05 * k},{k + 1}" for k in range(20)]
    points.write_text("load [N],velocity [m/s],hours\n" + "\n".join(rows))
    lines = irg("margin", "out.zarr", "--points", points).splitlines()
    assert len(lines) <= 14
    assert max(map(len, lines)) <= 100
    assert "further notes: --all; -o TABLE.csv has all rows" in lines[-1]
    record = irg("margin", "out.zarr", "--points", points, "--json")
    mild = [k + 1 for k, one in enumerate(record) if one["verdict"] == "mild"]
    assert f"{len(mild)} mild ({sum(mild)} h)" in lines[0]
    worst = min(record, key=lambda one: one["distance [K]"])
    first = next(line for line in lines if line.split()[0].isdigit() and "points" not in line)
    assert f"{worst['load [N]']:g}" in first.split()
    assert len(irg("margin", "out.zarr", "--points", points, "--all").splitlines()) > 24


def test_a_failing_share_of_a_row_is_judged_and_a_probability_said_in_words(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s],failing share [%]\n400,1.2,10\n400,2.2,1\n")
    said = irg("margin", "out.zarr", "--points", points)
    assert "less than 1 %" in said
    assert "not judged by" not in said
    first, second = irg("margin", "out.zarr", "--points", points, "--json")
    usual = pipeline.margin(store, 400.0, 1.2)
    assert (first["distance [K]"], first["probability"]) == (usual.distance, usual.probability)
    few = pipeline.margin(pipeline.at(store, share=0.01), 400.0, 2.2)
    assert (second["distance [K]"], second["probability"]) == (few.distance, few.probability)
    assert second["conditions"].endswith("critical temperature 145 °C, failing share 1 %")


def test_an_oil_temperature_that_is_taken_as_the_bulk_is_noted(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s],oil temperature [degC]\n400,1.2,60\n")
    said = irg("margin", "out.zarr", "--points", points)
    assert 'column "oil temperature [degC]" is taken as the bulk temperature of both bodies' in said


def test_a_path_typed_in_a_shell_is_relative_to_the_shell(tmp_path, irg, monkeypatch):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "rows.csv").write_text("load [N],velocity [m/s]\n400,1.2\n500,1.4\n")
    scene = tmp_path / "scenes" / "own.toml"
    scene.write_text('extends = "first_try"\nwithout = ["sweep.loads", "sweep.velocities"]\n')
    monkeypatch.chdir(tmp_path)
    said = irg("check", "scenes/own.toml", "--set", "sweep.along=rows.csv")
    assert "points   2: 2 rows" in said

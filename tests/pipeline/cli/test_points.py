"""`irg margin` reads tables of operating points and writes tables of margins."""

import pytest

import pipeline
from tests.helpers import synthetic
from tests.helpers.answer_at import asked


@pytest.fixture
def store(monkeypatch):
    ds = synthetic.sweep()
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: ds)
    return ds


def test_limits_of_a_row_judge_it_and_further_columns_are_kept(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    heads = "part,load [kN],velocity [m/s],critical temperature [°C],critical area fraction [%]"
    points.write_text(f"{heads}\nA,0.4,1.2,100,10\nB,0.4,2.2,145,1\n", encoding="utf-8")
    rows = irg("margin", "out.zarr", "--points", points, "--json")
    limits = {"critical_temperature": "100 degC"}, {"critical_area_fraction": 0.01}
    for row, part, velocity, conditions in zip(rows, "AB", (1.2, 2.2), limits, strict=True):
        margin = asked(store, 400.0, velocity, **conditions)
        assert row["part"] == part
        assert row["temperature margin [K]"] == pytest.approx(margin.temperature_margin, rel=1e-9)
        assert row["probability low"] == pytest.approx(margin.probability_low, rel=1e-9)
        assert row["temperature error discretization [K]"] == pytest.approx(
            margin.temperature_error_discretization, rel=1e-9
        )


def test_a_verdict_states_its_friction_and_temperatures(store, irg):
    command = "margin", "out.zarr", "--load", "400 N", "--velocity", "1.4 m/s"
    options = "--friction=0.12", "--bulk-temperature=60 degC", "--critical-temperature=150 degC"
    conditions = "friction 0.12, bulk temperature 60 °C, critical temperature 150 °C"
    output = irg(*command, *options)
    assert f" conditions: {conditions} " in " ".join(output.split())
    assert len(output.splitlines()) <= 14
    assert max(map(len, output.splitlines())) <= 100
    assert " ".join(irg("boundary", "out.zarr", *options).split()).startswith(
        f"conditions: {conditions}"
    )
    both = irg(*command, "--friction", "0.05", "--friction", "0.2")
    assert {"friction 0.05:", "friction 0.2:"} <= {*both.splitlines()}


def test_a_text_of_too_many_rows_is_refused_before_its_rows_are_read(store, tmp_path, irg):
    points = tmp_path / "duty.csv"
    points.write_text("load [N],velocity [m/s]\n" + "400,1.5\n" * 200_000)
    output = irg("margin", "out.zarr", "--points", points, code=2)
    assert "has 200000 rows; at most 100000" in output


def test_a_path_typed_in_a_shell_is_relative_to_the_shell(tmp_path, irg, monkeypatch):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "rows.csv").write_text("load [N],velocity [m/s]\n400,1.2\n500,1.4\n")
    scene = tmp_path / "scenes" / "own.toml"
    scene.write_text('extends = "first_try"\nwithout = ["sweep.loads", "sweep.velocities"]\n')
    monkeypatch.chdir(tmp_path)
    output = irg("check", "scenes/own.toml", "--set", "sweep.along=rows.csv")
    assert "points   2: 2 cases" in output

"""What the command says: tables, documents, figures, scenes that run, and mistakes in a line."""

import math
import re
import shlex
import tomllib
from pathlib import Path
from statistics import NormalDist

import pandas as pd
import pytest

import pipeline
import pipeline.gears as gears
from pipeline.analysis.tables import frame_of
from pipeline.sweep.remarks import join_notes

ROOT = Path(__file__).parents[3]
DUTY = "torque [Nm],speed [rpm],hours,bulk temperature [degC],name\n"
CRITICAL = ("--critical-temperature", "250 degC")


@pytest.fixture
def warm(monkeypatch):
    """Replace simulations by the temperature of smooth flanks, with an error of 1 K."""

    def row(one):
        hot, pair = max(one.places, key=lambda place: place.temperature), one.pair
        spread = NormalDist(
            pair.critical, math.hypot(1.0, pair.file.temperature.critical_sd or 0.0)
        )
        severe = spread.cdf(hot.temperature)
        verdict = "mild" if severe < 0.05 else "severe" if severe > 0.95 else "not decided"
        distance = pair.critical - hot.temperature
        return (
            one.duty.torque, one.duty.turns, one.duty.bulk, verdict, severe, hot.temperature, 1.0,
            distance, f"{verdict} by {distance:.0f} K", join_notes(pair.caveats),
        )  # fmt: skip

    def judge(meshes, preset=None, workers=None, progress=None):
        return frame_of(
            ("torque [N m]", "speed [rpm]", "bulk temperature [°C]", "verdict", "probability",
             "decisive temperature [°C]", "temperature error [K]", "distance [K]", "sentence",
             "notes"), map(row, meshes),
        )  # fmt: skip

    for name in ("fzg", "spectrum"):
        monkeypatch.setattr(f"pipeline.gears.{name}.judge", judge)


def facts(document):
    return {head: value for row in document["facts"] for head, value in row.items()}


def column(document, head):
    return [row[head] for row in document["rows"]]


def test_places_are_told_with_their_units(irg):
    document = irg("gears", "fzg_a", "--json")
    assert [*filter(None, column(document, "place"))] == ["A", "C", "B", "D", "E"]
    position = column(document, "position [mm]")
    assert (position[0], position[-1]) == pytest.approx((-3.3177, 14.7637), rel=1e-4)
    assert column(document, "radius 1 [mm]")[-1] == pytest.approx(28.734, rel=1e-4)
    assert "boundary lubrication" in document["caveats"][0]
    assert len({*document["caveats"]}) == len(document["caveats"]) > 2
    assert max(map(len, document["caveats"])) <= 100


def test_a_load_stage_is_a_duty(irg):
    twelve = facts(irg("gears", "fzg_a", "--stage", "12", "--json"))
    assert twelve["torque [N m]"] == 534.5
    assert twelve["bulk temperature [°C]"] == pytest.approx(80 + 0.23 * 534.5)
    assert twelve["pitch pressure of one pair [GPa]"] == pytest.approx(1.84, rel=5e-3)
    assert "has 1 to 12" in irg("gears", "fzg_a", "--stage", "13", code=2)


def test_a_table_and_a_figure_are_written(irg, tmp_path):
    irg("gears", "fzg_a", "-o", tmp_path / "mesh.csv")
    table = pd.read_csv(tmp_path / "mesh.csv")
    assert table["sliding [m/s]"].abs().min() == 0
    assert table["half-width [µm]"].max() == pytest.approx(232.4, abs=0.1)
    irg("gears", "fzg_a", "-o", tmp_path / "mesh.png")
    assert (tmp_path / "mesh.png").stat().st_size > 10_000
    velocities, pressures, temperatures, film = gears.draw_mesh(
        gears.mesh(gears.read_pair("fzg_a"))
    ).axes
    assert film.get_ylabel() == "film parameter Λ, dotted"
    assert temperatures.get_xlabel().endswith("from the pitch point [mm]")
    (sliding,) = (line for line in velocities.lines if line.get_label() == "sliding")
    assert sliding.get_ydata()[-1] == pytest.approx(5.59, abs=5e-3)
    assert max(pressures.lines[0].get_ydata()) == pytest.approx(1.625, abs=1e-3)


def test_a_scene_runs_and_its_margins_are_by_place(irg, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "scene: mesh.toml" in irg("gears", "fzg_a", "--scene", "mesh.toml", *CRITICAL)
    pair = gears.read_pair("fzg_a", {"temperature.critical": "250 degC"})
    Path("mesh.toml").write_text(gears.scene_toml([gears.mesh(pair, 2)]), encoding="utf-8")
    irg("run", "mesh.toml", "-o", "mesh.zarr", "--preset", "draft", "--workers", "1")
    table = pipeline.margin("mesh.zarr")
    temperatures = table["decisive temperature [°C]"]
    places = [p for p in gears.mesh(gears.read_pair("fzg_a"), 2).places if p.sliding]
    assert len(temperatures) == len(places) == 4
    for celsius, place in zip(temperatures, places, strict=True):
        # Rough flanks are hotter than smooth ones, by at most 60 %.
        rise, smooth = celsius + 273.15 - 438.85, place.flash
        assert smooth < rise < 1.6 * smooth
    # The table keeps a column that the scene adds and the format of scenes does not define.
    expected = [1e3 * place.position for place in places]
    assert table["position [mm]"].tolist() == pytest.approx(expected, rel=1e-6)
    assert "position" in irg("margin", "mesh.zarr")
    assert table["notes"].str.startswith("not validated: no scuffing test of gears").all()
    worst = gears.judge([gears.mesh(pair, 2)], "draft", workers=1).iloc[0]
    row = table.loc[table["probability"].idxmax()]
    assert worst["position [mm]"] == row["position [mm]"]
    assert worst["probability"] == pytest.approx(row["probability"], abs=1e-9)
    assert (worst["verdict"], worst["notes"][:13]) == (row["verdict"], "not validated")
    assert worst["sentence"].startswith(row["verdict"].capitalize())


def test_a_simulation_takes_the_hottest_place_of_each_duty():
    pair = gears.read_pair("fzg_a").with_critical(800.0, None)
    duties = [gears.Duty(torque, pair.duty.speed, 373.15) for torque in (372.6, 100.0)]
    table = gears.judge([gears.mesh(pair, 2, duty) for duty in duties], "draft", workers=1)
    hot, cool = table["decisive temperature [°C]"]
    place = next(place for place in gears.mesh(pair, 2, duties[0]).places if place.letter == "D")
    assert table["position [mm]"][0] == pytest.approx(1e3 * place.position)
    assert table["torque [N m]"].tolist() == [372.6, 100.0]
    assert cool < hot
    assert 1.0 < (hot - 100.0) / place.flash < 1.5


@pytest.mark.usefixtures("warm")
def test_a_failure_stage_is_a_temperature_between_two_stages(irg):
    said = irg("gears", "fzg_a", "--failure-stage", "10")
    assert re.search(r"scuffing integral temperature .* 27[78]\S*\n", said)
    found = facts(irg("gears", "fzg_a", "--failure-stage", "10", "--json"))
    passed, failed = (
        found[f"hottest place, {stage} [°C]"] for stage in ("last stage passed", "failed stage")
    )
    assert found["critical temperature [°C]"] == pytest.approx((passed + failed) / 2, abs=1e-8)
    spread = (failed - passed) / math.sqrt(12)
    assert found["standard deviation [K]"] == pytest.approx(math.hypot(spread, 1.0))
    assert failed == pytest.approx(331, abs=1)


@pytest.mark.usefixtures("warm")
def test_the_stage_that_is_predicted_is_the_one_that_was_told(irg):
    """An oil that fails in stage 10 fails there again, and on rougher flanks sooner."""
    given = ("gears", "fzg_a", "--failure-stage", "10", "--stages", "--json")
    stages = irg(*given)
    assert stages["said"][0].startswith("Fails in load stage 10. ")
    assert column(stages, "stage") == [*range(1, 13)]
    assert column(stages, "torque [N m]")[9] == 372.6
    limit = f"{facts(stages)['critical temperature [°C]']} degC"
    rough = ("--set", "pinion.roughness=1 um", "--set", "wheel.roughness=1 um")
    rougher = irg("gears", "fzg_a", "--stages", "--critical-temperature", limit, *rough, "--json")
    assert int(re.search(r"stage (\d+)\.", rougher["said"][0])[1]) < 10
    passes = irg("gears", "fzg_a", "--stages", "--critical-temperature", "900 degC")
    assert "Passes all load stages." in passes


@pytest.mark.usefixtures("warm")
def test_a_spectrum_has_one_verdict_and_a_sentence(irg, tmp_path):
    duty = tmp_path / "duty.csv"
    duty.write_text(
        DUTY + "150,1500,1800,100,cruise\n0,0,99,,parked\n372.6,2170,150,165.7,climb\n"
        "9,100,50,60,start\n"
    )
    given = "gears", "fzg_a", "--points", duty
    severe = irg(*given, *CRITICAL)
    assert "Scuffing in 1 of 3 rows, 150 of 2000 h. Row 4 decides. severe by -81 K." in severe
    assert "4 rows: 3 used, 1 left out: row 3 is at rest" in severe
    assert "columns not used: name" in severe
    document = irg(*given, "--critical-temperature", "400 degC", "--json")
    assert document["said"][0].startswith("No scuffing in 3 of 3 rows, 2000 of 2000 h. Row 4")
    assert column(document, "row") == [2, 4, 5]
    assert column(document, "hours") == [1800, 150, 50]
    assert column(document, "verdict") == ["mild"] * 3
    undecided = irg(*given, "--critical-temperature", "331 degC", "--json")
    assert undecided["said"][0].startswith("Scuffing is not decided in 1 of 3 rows, 150 of 2000")


def test_a_row_of_a_spectrum_has_hours_and_its_own_factor_or_temperature():
    pair = gears.read_pair("fzg_a", {"duty.load_factor": 1.2, "temperature.bulk": "70 degC"})
    columns = {
        "torque": ["100 N m"] * 2, "speed": ["1500 rpm"] * 2, "hours": [1.5, "2.5"],
    }  # fmt: skip
    speed = 1500 * 2 * math.pi / 60
    bulk = {"bulk temperature": ["90 degC", "363.15 K"]}
    factors, _ = gears.spectrum.read_spectrum(columns | bulk | {"load factor": [1.5, 0.5]}, pair)
    assert factors == [
        (1.5, gears.Duty(100.0, pytest.approx(speed), 363.15, 1.5)),
        (2.5, gears.Duty(100.0, pytest.approx(speed), pytest.approx(363.15), 0.5)),
    ]
    for _, duty in gears.spectrum.read_spectrum(columns | bulk, pair)[0]:
        assert duty == gears.Duty(100.0, pytest.approx(speed), pytest.approx(363.15), 1.2)


def test_the_oil_s_temperature_of_a_row_gives_its_teeth_theirs():
    """The bulk temperature follows from the oil's by ISO/TR 13989-2, Eq. 20."""
    columns = {"torque": ["534.5 N m"], "speed": ["2170 rpm"], "oil temperature": ["90 degC"]}
    for without in ({}, {"without": ["temperature.bulk"], "temperature.oil": "40 degC"}):
        pair = gears.read_pair("fzg_a", without)
        ((_, duty),) = gears.spectrum.read_spectrum(columns, pair)[0]
        warmer = 0.7 * gears.integral_temperature(pair, duty).mean_flash
        assert duty.bulk == pytest.approx(363.15 + warmer, abs=1e-6)
    own = {"torque": ["372.6 N m"], "speed": ["2170 rpm"]}
    ((_, duty),) = gears.spectrum.read_spectrum(own, gears.read_pair("fzg_a"))[0]
    assert duty == gears.read_pair("fzg_a").duty


@pytest.mark.usefixtures("warm")
def test_the_doubt_of_a_failure_stage_is_in_all_that_is_written(irg, tmp_path):
    given = ("gears", "fzg_a", "--failure-stage", "10")
    document = irg(*given, "--stages", "--scene", tmp_path / "mesh.toml", "--json")
    found = facts(document)
    value, doubt = found["critical temperature [°C]"], found["standard deviation [K]"]
    scene = tomllib.loads((tmp_path / "mesh.toml").read_text(encoding="utf-8"))
    assert scene["temperature"]["critical"] == f"{value:.7g} degC"
    assert scene["temperature"]["critical_sd"] == f"{doubt:.7g} K"
    assert scene["caveat"].startswith("not validated")
    counted = f"°C ± {doubt:.2g} K, which is counted"
    assert sum(counted in one for one in document["caveats"]) == 1
    for options in ((), ("--failure-stage", "10"), ("--stages", *CRITICAL)):
        irg("gears", "fzg_a", *options, "-o", tmp_path / "table.csv")
        notes = pd.read_csv(tmp_path / "table.csv")["notes"]
        assert notes.str.startswith("not validated: no scuffing test of gears").all()
    assert notes.str.contains("250 °C, taken as exact").all()


def test_values_of_a_pair_are_doubted_as_those_of_a_scene(irg):
    slips = {
        "mesh.face_width=30 m": "mesh.face_width: 3e+04 mm, where 1 to 1000 mm are usual",
        "friction.coefficient=5": "friction.coefficient: 5, where 0 to 1 are usual",
        "temperature.bulk=300 degC": "temperature.bulk: 300 °C, where -50 to 250 °C are usual",
    }
    for setting, doubt in slips.items():
        assert f"warning: {doubt}" in irg("gears", "fzg_a", "--set", setting)
    heavy = "--set", "duty.torque=180 kN m", "--set", "temperature.bulk=90 degC"
    (doubt, *_) = irg("gears", "fzg_a", *heavy, "--json")["caveats"]
    assert doubt.startswith("warning: duty.torque: highest pressure: 35")


def test_teeth_above_the_critical_temperature_are_severe_without_a_simulation():
    pair = gears.read_pair("fzg_a").with_critical(430.0, None)
    one = gears.judge([gears.mesh(pair)]).iloc[0]
    assert (one["verdict"], one["probability"]) == ("severe", 0.9999)
    assert one["notes"].endswith(
        "the bulk temperature is above the critical temperature: not simulated"
    )
    table = gears.judge_spectrum(
        pair,
        {"torque [N m]": [100, 100], "speed [rpm]": [9, 9], "bulk temperature [K]": [500, 450]},
    )
    assert gears.spectrum.conclusion(table).startswith("Scuffing in 2 of 2 rows. Row 1 decides.")


OWN = """
title = "A pair of our own"
[mesh]
module = "3 mm"
face_width = "25 mm"
[pinion]
teeth = 21
material = "nitrided 31CrMoV9"
roughness = "0.4 um"
[wheel]
teeth = 60
material = "bronze CuSn12"
roughness = "0.6 um"
[duty]
torque = "20 Nm"
speed = "157 rad/s"
[temperature]
bulk = "70 degC"
[oil]
like = "ISO VG 46"
"""


def test_a_short_file_has_what_it_leaves_out(irg, tmp_path):
    (tmp_path / "own.toml").write_text(OWN)
    pair = gears.read_pair(tmp_path / "own.toml")
    file, surface = pair.file, pair.file.surface
    assert (file.mesh.quality, file.friction.lubricant_factor) == (6, 1.0)
    assert pair.duty.load_factor == 1.0
    assert (pair.gears.pressure_angle, pair.gears.helix_angle) == (math.radians(20), 0.0)
    assert pair.gears.profile_shifts == (0.0, 0.0)
    assert surface.correlation_length == (4e-6, 4e-6)
    assert (surface.hurst_exponent, surface.specific_wear_rate) == (0.8, 1.2e-15)
    found = facts(irg("gears", tmp_path / "own.toml", "--json"))
    assert found["centre distance [mm]"] == pytest.approx(121.5)
    assert found["contact ratio"] == pytest.approx(1.68, abs=0.02)
    sources = [text for name, text in found.items() if name.startswith("library")]
    assert any("31" in source or "1.8519" in source for source in sources)
    without = OWN[: OWN.index("[oil]")] + "[friction]\ncoefficient = 0.05\n"
    (tmp_path / "own.toml").write_text(without)
    said = irg("gears", tmp_path / "own.toml")
    assert re.search("friction +0.05\n", said)
    assert "Λ" not in said


def test_the_page_leads_from_a_drawing_to_a_verdict(irg, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "workflows" / "YOUR_GEARS.md").read_text(encoding="utf-8")
    pair, duty = re.findall(r"```(?:toml)?\n((?:title|torque).*?)```", page, flags=re.DOTALL)
    Path("pair.toml").write_text(pair, encoding="utf-8")
    Path("duty.csv").write_text(duty, encoding="utf-8")
    written = gears.read_pair("pair.toml").file.surface
    assert (written.correlation_length, written.hurst_exponent) == ((4e-6, 4e-6), 0.8)
    (command,) = re.findall(r"^irg (gears pair.toml .*--points.*)$", page, flags=re.MULTILINE)
    said = irg(*shlex.split(command))
    assert "No scuffing in 3 of 3 rows, 10000 of 10000 h. Row 3 decides. Mild: " in said
    (critical,) = re.findall(r"critical temperature \[°C\] +(\S+)", said)
    (doubt,) = re.findall(r"standard deviation \[K\] +(\S+)", said)
    (limit,) = re.findall(r"scuffing integral .*\] +(\S+)", said)
    assert f"{float(critical):.0f} ± {float(doubt):.0f} °C" in page
    assert f"is {float(limit):.0f} °C" in page
    assert Path("verdicts.csv").read_text().count("mild") == 3

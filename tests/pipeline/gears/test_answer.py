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
from pipeline.gears import model
from pipeline.gears.model import Simulated
from pipeline.sweep.caveats import joined
from tribo import InputError

ROOT = Path(__file__).parents[3]
DUTY = "torque [Nm],speed [rpm],hours,bulk temperature [degC],name\n"
CRITICAL = ("--critical-temperature", "250 degC")


@pytest.fixture
def warm(monkeypatch):
    """A simulation that finds the temperature of smooth flanks, with an error of 1 K in all."""

    def judged(one):
        hot, pair = one.hottest, one.pair
        if pair.critical is None:
            return Simulated(one, hot, hot.temperature, 1.0)
        spread = NormalDist(pair.critical, math.hypot(1.0, pair.critical_sd or 0.0))
        severe = spread.cdf(hot.temperature)
        verdict = "mild" if severe < 0.05 else "severe" if severe > 0.95 else "not decided"
        return Simulated(one, hot, hot.temperature, 1.0, verdict, severe, joined(pair.caveats))

    def simulate(meshes, preset=None, workers=None, progress=None):
        return [judged(one) for one in meshes]

    for name in ("fzg", "spectrum"):
        monkeypatch.setattr(f"pipeline.gears.{name}.simulate", simulate)


def test_places_are_told_in_si(irg):
    document = irg("gears", "fzg_a", "--places", "7", "--json")
    places = document["places"]
    assert [place["letter"] for place in places if place["letter"]] == ["A", "C", "B", "D", "E"]
    for name in ("position", "radius_1", "radius_2", "rolling_1", "rolling_2", "sliding", "load"):
        assert all(isinstance(place[name], float) for place in places)
    first, last = places[0], places[-1]
    assert (first["position"], last["position"]) == pytest.approx(
        (-3.3177e-3, 14.7637e-3), rel=1e-4
    )
    assert last["radius_1"] == pytest.approx(28.734e-3, rel=1e-4)
    assert "boundary lubrication" in document["caveats"][0]
    assert len({*document["caveats"]}) == len(document["caveats"]) > 2
    assert max(map(len, document["caveats"])) <= 100


def test_without_a_number_of_steps_there_are_25_places_and_those_with_letters(irg):
    """A and E are among the even ones, B, C and D are not."""
    assert len(gears.mesh(gears.read_pair("fzg_a")).places) == 25 + 3
    assert len(irg("gears", "fzg_a", "--json")["places"]) == 25 + 3


def test_caveats_are_the_last_lines(irg):
    title, *lines = irg("gears", "fzg_a").splitlines()
    assert title == "FZG test gears A, A/8.3/90"
    assert lines[-4] == ""
    assert lines[-3].startswith("not validated: no scuffing test of gears")
    assert lines[-1].startswith("pressure, flash and film are of smooth flanks")


def test_a_load_stage_is_a_duty(irg):
    twelve = irg("gears", "fzg_a", "--stage", "12", "--json")
    assert twelve["duty"]["torque"] == 534.5
    assert twelve["duty"]["bulk"] == pytest.approx(273.15 + 80 + 0.23 * 534.5)
    assert twelve["pitch_pressure_of_one_pair"] == pytest.approx(1.84e9, rel=5e-3)
    assert "has 1 to 12" in irg("gears", "fzg_a", "--stage", "13", code=2)


def test_teeth_are_warmer_than_their_oil_by_the_rule(irg):
    document = irg("gears", "fzg_a", "--set", "without=temperature.bulk", "--set",
                   "temperature.oil=90 degC", "--json")  # fmt: skip
    warmer = document["duty"]["bulk"] - 363.15
    assert warmer == pytest.approx(0.7 * document["integral"]["mean_flash"], rel=1e-9)
    both = irg("gears", "fzg_a", "--set", "temperature.oil=90 degC", code=2)
    assert "temperature: give one of bulk, that of the teeth, and oil" in both


def test_a_table_and_a_figure_are_written(irg, tmp_path):
    irg("gears", "fzg_a", "--places", "5", "-o", tmp_path / "mesh.csv")
    table = pd.read_csv(tmp_path / "mesh.csv")
    assert table["sliding [m/s]"].abs().min() == 0
    assert table["half-width [µm]"].max() == pytest.approx(231, abs=1)
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
    told = irg("gears", "fzg_a", "--places", "2", "--scene", "mesh.toml", *CRITICAL)
    assert "irg run mesh.toml -o mesh.zarr" in told
    irg("run", "mesh.toml", "-o", "mesh.zarr", "--preset", "draft", "--workers", "1")
    table = pipeline.margin("mesh.zarr")
    temperatures = table["decisive temperature [°C]"]
    places = [p for p in gears.mesh(gears.read_pair("fzg_a"), 2).places if p.sliding]
    assert len(temperatures) == len(places) == 4
    for celsius, place in zip(temperatures, places, strict=True):
        # Rough flanks are hotter than smooth ones, and half as much at most.
        rise, smooth = celsius + 273.15 - 438.85, place.flash
        assert smooth < rise < 1.6 * smooth
    # A column of the scene's own, of which the format of scenes knows nothing.
    expected = [1e3 * place.position for place in places]
    assert table["position [mm]"].tolist() == pytest.approx(expected, rel=1e-6)
    assert "position [mm]" in irg("margin", "mesh.zarr")
    assert table["notes"].str.startswith("not validated: no scuffing test of gears").all()
    pair = gears.read_pair("fzg_a").changed(critical=523.15)
    (worst,) = model.simulate([gears.mesh(pair, 2)], "draft", workers=1)
    row = table.loc[table["probability"].idxmax()]
    assert worst.probability == pytest.approx(row["probability"], abs=1e-9)
    assert (worst.verdict, worst.notes[:13]) == (row["verdict"], "not validated")


def test_a_simulation_takes_the_hottest_place_of_each_duty():
    pair = gears.read_pair("fzg_a")
    duties = [gears.Duty(torque, pair.duty.speed, 373.15) for torque in (372.6, 100.0)]
    meshes = [gears.mesh(pair, 2, duty) for duty in duties]
    hot, cool = model.simulate(meshes, "draft", workers=1)
    assert hot.place.letter == "D"
    assert hot.mesh.duty.torque == 372.6
    assert cool.temperature < hot.temperature
    assert 1.0 < (hot.temperature - 373.15) / hot.place.flash < 1.5


@pytest.mark.usefixtures("warm")
def test_a_failure_stage_is_a_temperature_between_two_stages(irg):
    said = irg("gears", "fzg_a", "--failure-stage", "10")
    assert "in the stage before, and at" in said
    assert "278 °C by the rule of ISO/TR 13989-2, Eq. 94" in said
    critical = irg("gears", "fzg_a", "--failure-stage", "10", "--json")["critical_temperature"]
    assert critical["value"] == (critical["passed"] + critical["failed"]) / 2
    spread = (critical["failed"] - critical["passed"]) / math.sqrt(12)
    assert critical["doubt"] == pytest.approx(math.hypot(spread, 1.0))
    assert critical["failed"] == pytest.approx(331 + 273.15, abs=1)


@pytest.mark.usefixtures("warm")
def test_the_stage_that_is_predicted_is_the_one_that_was_told(irg):
    """An oil that fails in stage 10 fails there again, and on rougher flanks sooner."""
    given = ("gears", "fzg_a", "--failure-stage", "10", "--stages", "--json")
    stages = irg(*given)["stages"]
    assert stages["fails"] == 10
    assert stages["stage"] == [*range(1, 13)]
    assert stages["torque"][9] == 372.6
    told = irg("gears", "fzg_a", "--failure-stage", "10", "--json")["critical_temperature"]
    limit = f"{told['value'] - 273.15} degC"
    rough = ("--set", "pinion.roughness=1 um", "--set", "wheel.roughness=1 um")
    rougher = irg("gears", "fzg_a", "--stages", "--critical-temperature", limit, *rough, "--json")
    assert rougher["stages"]["fails"] < 10
    passes = irg("gears", "fzg_a", "--stages", "--critical-temperature", "900 degC")
    assert "passes all load stages, by a critical temperature of 900 °C, taken as exact" in passes
    doubtful = ("--set", "temperature.critical_sd=25 K", "--critical-temperature", limit)
    told = irg("gears", "fzg_a", "--stages", *doubtful)
    assert f"fails in load stage 10, by a critical temperature of {limit[:3]} °C ± 25 K" in told
    assert "not decided, by all errors together: stage 9, 10\n" in told


@pytest.mark.usefixtures("warm")
def test_the_oil_of_a_pair_is_tested_on_the_test_gears(tmp_path):
    (tmp_path / "own.toml").write_text(OWN)
    own = gears.read_pair(tmp_path / "own.toml")
    thin = gears.critical_temperature(own, 9)
    rig = gears.read_pair("fzg_a", {"oil": "ISO VG 46"})
    assert thin.value == gears.critical_temperature(rig, 9).value


@pytest.mark.usefixtures("warm")
def test_a_spectrum_has_one_verdict_and_a_sentence(irg, tmp_path):
    duty = tmp_path / "duty.csv"
    duty.write_text(
        DUTY + "150,1500,1800,100,cruise\n0,0,99,,parked\n372.6,2170,150,165.7,climb\n"
        "9,100,50,60,start\n"
    )
    given = "gears", "fzg_a", "--points", duty
    severe = irg(*given, *CRITICAL)
    assert "Scuffing is predicted in 1 of 3 rows, 150 of 2000 h. Row 4, 372.6 N m" in severe
    assert "4 rows: 3 used, 1 left out: row 3 is at rest" in severe
    assert "severe with more than 99.99 %, 81 K above the critical temperature (250 °C" in severe
    assert "columns not used: name" in severe
    document = irg(*given, "--critical-temperature", "400 degC", "--json")["spectrum"]
    assert (document["verdict"], document["binding_row"]) == ("mild", 4)
    assert document["rows_read"].startswith("4 rows: 3 used")
    assert document["rows"]["hours"] == [1800, 150, 50]
    assert document["rows"]["verdict"] == ["mild"] * 3
    assert "in 3 of 3 rows, 2000 of 2000 h" in document["sentence"]
    undecided = irg(*given, "--critical-temperature", "331 degC", "--json")["spectrum"]
    assert undecided["verdict"] == "not decided"


def test_a_row_of_a_spectrum_has_hours_and_its_own_factor_or_temperature():
    pair = gears.read_pair("fzg_a", {"duty.load_factor": 1.2, "temperature.bulk": "70 degC"})
    columns = {
        "torque": ["100 N m"] * 2, "speed": ["1500 rpm"] * 2, "hours": ["90 min", 2.5],
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


def test_an_empty_factor_or_temperature_of_a_row_is_a_fault():
    columns = {
        "torque": ["100 N m"] * 3, "speed": ["1500 rpm"] * 3,
        "load factor": [1.5, None, 0.5], "bulk temperature": [None, "90 degC", ""],
    }  # fmt: skip
    with pytest.raises(InputError) as caught:
        gears.spectrum.read_spectrum(columns, gears.read_pair("fzg_a"))
    assert "rows 1 and 3, bulk_temperature: is empty; fill it, or leave out" in str(caught.value)
    assert "row 2, load_factor: is empty" in str(caught.value)


@pytest.mark.usefixtures("warm")
def test_the_doubt_of_a_critical_temperature_counts_in_each_verdict():
    pair = gears.read_pair("fzg_a")
    points = {"torque": ["372.6 N m"], "speed": ["2170 rpm"], "bulk temperature": ["165.7 degC"]}
    near = pair.changed(critical=pair.duty.bulk + 190)
    assert gears.judge_spectrum(near, points).verdict == "mild"
    doubtful = near.changed(critical_sd=40.0)
    assert gears.judge_spectrum(doubtful, points).verdict == "not decided"


def test_the_oil_s_temperature_of_a_row_gives_its_teeth_theirs():
    """As that of the file does, by ISO/TR 13989-2, Eq. 20."""
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
    found = document["critical_temperature"]
    scene = tomllib.loads((tmp_path / "mesh.toml").read_text(encoding="utf-8"))
    assert scene["temperature"]["critical"] == f"{found['value'] - 273.15:.7g} degC"
    assert scene["temperature"]["critical_sd"] == f"{found['doubt']:.7g} K"
    assert scene["caveat"].startswith("not validated")
    doubt = f"°C ± {found['doubt']:.2g} K, which is counted"
    assert sum(doubt in one for one in document["caveats"]) == 1
    for options in ((), ("--failure-stage", "10"), ("--stages", *CRITICAL)):
        irg("gears", "fzg_a", *options, "-o", tmp_path / "table.csv")
        notes = pd.read_csv(tmp_path / "table.csv")["notes"]
        assert notes.str.startswith("not validated: no scuffing test of gears").all()
    assert notes.str.contains("250 °C, taken as exact").all()


@pytest.mark.usefixtures("warm")
def test_friction_that_is_given_holds_for_the_test_gears(irg, tmp_path):
    """Of smooth flanks, whose flash goes with it; the bulk temperature does not."""
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")

    def flash(friction):
        given = ("--failure-stage", "10", "--set", f"friction.coefficient={friction}", "--json")
        found = irg("gears", tmp_path / "own.toml", *given)["critical_temperature"]
        return found["failed"] - gears.stage_bulk(10)

    assert flash(0.06) == pytest.approx(2 * flash(0.03))


def test_values_of_a_pair_are_doubted_as_those_of_a_scene(irg):
    slips = {
        "mesh.face_width=30 m": "mesh.face_width: 3e+04 mm, where 1 to 1000 mm are usual",
        "friction.coefficient=5": "friction.coefficient: 5, where 0 to 1 are usual",
        "temperature.bulk=300 degC": "temperature.bulk: 300 °C, where -50 to 250 °C are usual",
    }
    for setting, doubt in slips.items():
        assert f"warning: {doubt}" in irg("gears", "fzg_a", "--set", setting)
    heavy = "--set", "duty.torque=180 kN m", "--set", "temperature.bulk=90 degC"
    (doubt,) = irg("gears", "fzg_a", *heavy, "--json")["doubts"]
    assert doubt.startswith("warning: duty.torque: highest pressure 35")
    assert irg("gears", "fzg_a", "--json")["doubts"] == []


def test_teeth_above_the_critical_temperature_are_severe_without_a_simulation():
    pair = gears.read_pair("fzg_a").changed(critical=430.0)
    (one,) = model.simulate([gears.mesh(pair)])
    assert (one.verdict, one.probability) == ("severe", 1.0)
    assert one.notes.endswith("the teeth alone are above the critical temperature: not simulated")


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
    assert (pair.quality, pair.lubricant_factor, pair.duty.load_factor) == (6, 1.0, 1.0)
    assert (pair.gears.pressure_angle, pair.gears.helix_angle) == (math.radians(20), 0.0)
    assert pair.gears.profile_shifts == (0.0, 0.0)
    assert pair.correlation_length == (4e-6, 4e-6)
    assert (pair.hurst_exponent, pair.specific_wear_rate) == (0.8, 1.2e-15)
    document = irg("gears", tmp_path / "own.toml", "--json")
    assert document["centre_distance"] == pytest.approx(121.5e-3)
    assert document["contact_ratio"] == pytest.approx(1.68, abs=0.02)
    sources = {one["source"] for one in document["library"]}
    assert any("31" in source or "1.8519" in source for source in sources)
    without = OWN[: OWN.index("[oil]")] + "[friction]\ncoefficient = 0.05\n"
    (tmp_path / "own.toml").write_text(without)
    said = irg("gears", tmp_path / "own.toml")
    assert "0.05, as given" in said
    assert "Λ" not in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--scene", "mesh.csv"], "suffix must be .toml"),
        (["--set", "duty.torque=1 N m", "--set", "duty.torque=2 N m"], "given more than once"),
    ],
)
def test_options_that_do_not_fit_are_refused_before_anything_runs(irg, options, said):
    assert said in irg("gears", "fzg_a", *options, code=2)


def test_faults_of_a_spectrum_are_all_named(irg, tmp_path):
    (tmp_path / "duty.csv").write_text("torque [N m],speed\n1,2\nx,3 rpm\n")
    told = irg("gears", "fzg_a", "--points", tmp_path / "duty.csv", *CRITICAL, code=2)
    assert "row 2, speed" in told
    assert "row 3, torque" in told


def test_the_page_leads_from_a_drawing_to_a_verdict(irg, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "workflows" / "YOUR_GEARS.md").read_text(encoding="utf-8")
    pair, duty = re.findall(r"```(?:toml)?\n((?:title|torque).*?)```", page, flags=re.DOTALL)
    Path("pair.toml").write_text(pair, encoding="utf-8")
    Path("duty.csv").write_text(duty, encoding="utf-8")
    written = gears.read_pair("pair.toml")
    usual = {name: getattr(written, name) for name in ("correlation_length", "hurst_exponent")}
    assert usual == {"correlation_length": (4e-6, 4e-6), "hurst_exponent": 0.8}
    (command,) = re.findall(r"^irg (gears pair.toml .*--points.*)$", page, flags=re.MULTILINE)
    said = irg(*shlex.split(command))
    assert "No scuffing is predicted in 3 of 3 rows, 10000 of 10000 h. Row 3" in said
    (critical,) = re.findall(r"critical temperature: (\d+ ± \d+ °C) by this model", said)
    (limit,) = re.findall(r"scuffing integral temperature: (\d+ °C) by the rule", said)
    assert critical in page
    assert f"is {limit}" in page
    assert Path("verdicts.csv").read_text().count("mild") == 3

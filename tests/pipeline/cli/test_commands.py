"""The command line, as a user types it."""

import json
import shutil

import pytest
import xarray as xr

from pipeline.cli import main

SCENE = """
title = "A small sweep"

[materials.steel]
elastic_modulus = "210 GPa"
poisson_ratio = 0.3
hardness = "6.6 GPa"
thermal_conductivity = "45 W/(m K)"
density = "7800 kg/m^3"
specific_heat = "470 J/(kg K)"

[pin]
shape = "cylinder"
radius = "2 mm"
length = "3.4 mm"
material = "steel"

[disk]
material = "steel"

[disk.roughness]
ra = "0.27 um"
hurst_exponent = 0.8
correlation_length = "16 um"
seed = 0

[window]
pixels = [48, 16]
pixel_size = ["8 um", "8 um"]

[loading]
rate = "150 N/s"
reference_load = "750 N"

[wear]
specific_wear_rate = "1.2e-6 mm^3/(N m)"
pattern = "swept"

[friction]
coefficient = 0.1

[temperature]
bulk = "25 degC"
critical = "145 degC"
failing_share = 0.1

[fidelity]
pixels_per_element = 1
increments = 10

[sweep]
loads = ["200 N", "400 N", "600 N"]
velocities = ["1 m/s", "2 m/s", "4 m/s"]
fields = true
"""

MEASURED = """
[[measured]]
load = "400 N"
velocity = "2 m/s"
"""


def run(*arguments):
    return main([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cli")
    (folder / "small.toml").write_text(SCENE)
    out = folder / "small.zarr"
    assert run("run", folder / "small.toml", "-o", out, "--workers", 1) == 0
    return folder


def test_run_again_has_nothing_left_to_do(swept, capsys):
    assert run("run", swept / "small.toml", "-o", swept / "small.zarr", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["points"], document["done"], document["computed"]) == (9, 9, 0)
    assert document["failed"] == []


def test_points_that_fail_are_listed_and_the_others_are_done(tmp_path, capsys):
    (tmp_path / "heavy.toml").write_text(SCENE.replace('"400 N"', '"1e7 N"'))
    arguments = ("--set", "increments=1", "-o", tmp_path / "heavy.zarr", "--workers", 1)
    assert run("run", tmp_path / "heavy.toml", *arguments) == 1
    out = capsys.readouterr().out
    assert "6 of 9 points done" in out
    assert out.count("failed: 1e+07 N") == 3
    assert "the same command and --retry-failed" in out
    assert run("status", tmp_path / "heavy.zarr") == 1


def test_run_says_what_reading_the_scene_had_to_settle(tmp_path, capsys):
    (tmp_path / "record.csv").write_text("time [s], load [N]\n0, 0\n4, 600\n")
    scene = tmp_path / "scene.toml"
    ramp = 'rate = "150 N/s"\nreference_load = "750 N"'
    scene.write_text(SCENE.replace(ramp, 'file = "record.csv"\nfit = true'))
    one = ("--set", 'sweep.loads=["300 N"]', "--set", 'sweep.velocities=["1 m/s"]')
    assert run("run", scene, "-o", tmp_path / "out.zarr", "--workers", 1, *one) == 0
    assert "note: loading.file: fitted by 150 N/s from 0 s on" in capsys.readouterr().err


def test_check_says_what_would_run_and_runs_nothing(swept, capsys):
    before = sorted(swept.iterdir())
    assert run("check", swept / "small.toml", "--json", "--workers", 2) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["points"] == 9
    # The trunk to 600 N has 8 stations and the lower loads, which lie between stations, leave it
    # by a step each: 8 + 2 contacts at each of 3 velocities.
    assert document["steps"] == 30
    assert document["temperatures"] == 9
    assert document["seconds"] > 0
    assert sorted(swept.iterdir()) == before


def test_status_counts_points(swept, capsys):
    assert run("status", swept / "small.zarr") == 0
    text = capsys.readouterr().out
    assert "9 points: 9 done, 0 failed, 0 pending" in text
    assert "earlier" not in text


def test_status_tells_of_points_that_the_scene_no_longer_asks_for(swept, tmp_path, capsys):
    shutil.copytree(swept / "small.zarr", tmp_path / "small.zarr")
    one = ("--set", 'sweep.loads=["200 N"]', "-o", tmp_path / "small.zarr")
    assert run("run", swept / "small.toml", *one, "-q") == 0
    capsys.readouterr()
    assert run("status", tmp_path / "small.zarr") == 0
    text = capsys.readouterr().out
    assert "3 points: 3 done" in text
    assert "6 more are done, for which an earlier run asked" in text
    assert run("status", tmp_path / "small.zarr", "--json") == 0
    assert json.loads(capsys.readouterr().out)["done_earlier"] == 6


def test_boundary_moves_with_the_conditions_given(swept, capsys):
    found = []
    for friction in (0.08, 0.1, 0.12):
        assert run("boundary", swept / "small.zarr", "--friction", friction, "--json") == 0
        found.append(json.loads(capsys.readouterr().out))
    at_600 = [document["critical_velocity"][2] for document in found]
    assert at_600 == sorted(at_600, reverse=True)
    assert found[0]["conditions"]["friction"] == 0.08
    arguments = ("--bulk-temperature", "60 degC", "--critical-temperature", "180 degC")
    assert run("boundary", swept / "small.zarr", *arguments, "--json") == 0
    # 60 and 180 °C leave the same 120 K as 25 and 145 °C.
    moved = json.loads(capsys.readouterr().out)
    assert moved["critical_velocity"][2] == pytest.approx(found[1]["critical_velocity"][2])


def test_boundary_in_words_names_its_conditions(swept, capsys):
    assert run("boundary", swept / "small.zarr") == 0
    out = capsys.readouterr().out
    assert "friction 0.1, bulk 25 °C, critical 145 °C, failing share 0.1" in out
    assert "critical velocity [m/s]" in out


def test_boundary_takes_several_frictions_at_once(swept, capsys):
    assert (
        run("boundary", swept / "small.zarr", "--friction", 0.08, "--friction", 0.12, "--json") == 0
    )
    both = json.loads(capsys.readouterr().out)
    assert both["conditions"]["friction"] == [0.08, 0.12]
    assert run("boundary", swept / "small.zarr", "--friction", "0.12", "--json") == 0
    assert json.loads(capsys.readouterr().out)["critical_load"] == both["critical_load"][1]
    assert run("boundary", swept / "small.zarr", "--friction", "0.08,0.12") == 0
    words = " ".join(capsys.readouterr().out.split())
    assert "critical velocity [m/s] at friction 0.08 at friction 0.12" in words
    with pytest.raises(SystemExit):
        run("boundary", swept / "small.zarr", "--friction", "0.08,high")
    assert "0.09,0.103" in capsys.readouterr().err


def test_point_alone_equals_the_point_of_the_sweep(swept, capsys):
    arguments = ("--load", "400 N", "--velocity", "2 m/s", "--json")
    assert run("point", swept / "small.toml", *arguments) == 0
    alone = json.loads(capsys.readouterr().out)
    stored = xr.open_zarr(swept / "small.zarr", chunks=None).sel(load=400.0, velocity=2.0)
    last = int(stored["time"].notnull().sum()) - 1
    for name in ("max_rise", "mean_rise", "contact_width", "wear_volume", "max_pressure"):
        assert alone[name] == float(stored[name][last])


def test_point_in_words(swept, capsys):
    arguments = ("--load", "600 N", "--velocity", "4 m/s")
    assert run("point", swept / "small.toml", *arguments) == 0
    out = capsys.readouterr().out
    assert "600 N at 4 m/s" in out
    assert "severe wear" in out
    assert "°C" in out


@pytest.mark.parametrize("load", ["1e5 N", "1e9 N"])
def test_point_names_the_load_that_the_window_does_not_carry(swept, capsys, load):
    assert run("point", swept / "small.toml", "--load", load, "--velocity", "1 m/s") == 2
    assert f"--load: {float(load[:-2]):g} N is more than the window" in capsys.readouterr().err


def test_a_share_below_zero_is_refused_with_what_is_allowed(swept, capsys):
    assert run("boundary", swept / "small.zarr", "--share", "-5%") == 2
    assert "share is -0.05; it must be at least 0" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["diagram", "ramp", "fields"])
def test_plot_writes_a_figure(swept, tmp_path, capsys, kind):
    out = tmp_path / f"{kind}.png"
    assert run("plot", swept / "small.zarr", "--kind", kind, "-o", out, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document.pop("warnings")) == {"points", "kinds", "at_boundary", "example"}
    assert document == {"kind": kind, "file": str(out)}
    assert out.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("kind", "option", "others"),
    [
        ("ramp", ["--given-measured"], "--load, --velocity, --friction"),
        ("temperature", ["--rival", "blok"], "--load, --friction"),
        ("diagram", ["--load", "600 N"], "--friction, --bulk-temperature"),
    ],
)
def test_an_option_that_a_figure_lacks_is_named_as_it_is_typed(swept, capsys, kind, option, others):
    assert run("plot", swept / "small.zarr", "--kind", kind, *option) == 2
    assert f"--kind {kind} takes no {option[0]}; it takes {others}" in capsys.readouterr().err


def test_an_accuracy_is_stored_with_what_it_picked(swept, tmp_path, capsys):
    out = tmp_path / "accurate.zarr"
    arguments = ("run", swept / "small.toml", "-o", out, "--workers", 1, "--accuracy", "10%")
    assert run(*arguments, "--json") == 0
    first = capsys.readouterr()
    picked = json.loads(first.out)["selection"]
    assert picked["error"] <= picked["accuracy"] == 0.1
    assert picked["trials"][-1]["fidelity"] == picked["fidelity"]
    assert picked["seconds"] > 0
    assert "probing" in first.err
    assert run(*arguments) == 0
    second = capsys.readouterr()
    assert "probing" not in second.err
    assert "0 of them now" in second.out
    assert run("status", out) == 0
    assert f"accuracy 10 %: picked {picked['name']}" in capsys.readouterr().out
    assert run(*arguments, "--set", "increments=7") == 2
    assert "leave out --set increments" in capsys.readouterr().err


def test_without_friction_there_is_no_heat_and_no_claim_about_it(tmp_path, capsys):
    scene, out = tmp_path / "slippery.toml", tmp_path / "slippery.zarr"
    text = SCENE.replace("coefficient = 0.1", "coefficient = 0.0")
    scene.write_text(text.replace('["1 m/s", "2 m/s", "4 m/s"]', '["1 m/s", "4 m/s"]'))
    assert run("check", scene, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["temperatures"] == 0
    assert any("friction coefficient is 0" in reason for reason in document["saved"])
    assert run("run", scene, "-o", out, "--workers", 1) == 0
    assert run("boundary", out) == 0
    assert "mild at every velocity computed (to 4 m/s)" in capsys.readouterr().out
    assert run("boundary", out, "--friction", "0.1") == 2
    assert "without any heat" in capsys.readouterr().err
    scene.write_text(SCENE)
    assert run("run", scene, "-o", out, "--workers", 1) == 3
    assert "scene.friction_heat: False in the store, True in the scene" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["diagram", "ramp", "fields"])
def test_friction_0_is_mild_in_every_command(swept, tmp_path, capsys, kind):
    store, figure = swept / "small.zarr", tmp_path / f"{kind}.png"
    assert run("plot", store, "--kind", kind, "--friction", 0, "-o", figure) == 0
    assert figure.stat().st_size > 10_000
    assert run("boundary", store, "--friction", 0, "--json") == 0
    capsys.readouterr()
    assert run("boundary", store, "--friction", 0, "--friction", 0.1, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    slippery, rubbing = document["critical_velocity"]
    assert not any(slippery)
    assert any(rubbing)
    slippery, rubbing = document["outcome_at_load"]
    assert set(slippery) == {"mild throughout"}
    assert "crosses" in rubbing


def test_the_document_says_why_there_is_no_crossing(swept, capsys):
    for friction, why in ((0.001, "mild throughout"), (1.0, "severe throughout")):
        assert run("boundary", swept / "small.zarr", "--friction", friction, "--json") == 0
        document = json.loads(capsys.readouterr().out)
        for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
            assert not any(document[name])
            assert set(document[f"outcome_at_{axis}"]) == {why}


def test_a_point_without_friction_is_as_cold_as_its_bulk(swept, capsys):
    place = ("--load", "400 N", "--velocity", "2 m/s", "--json")
    for way in (("--friction", 0), ("--set", "friction.coefficient=0")):
        assert run("point", swept / "small.toml", *place, *way) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["max_temperature"] == found["decisive_temperature"] == 298.15
        assert found["failed_fraction"] == 0
        assert not found["severe"]


def test_without_friction_there_is_nothing_to_measure_or_infer(swept, tmp_path, capsys):
    scene = tmp_path / "slippery.toml"
    scene.write_text(SCENE.replace("coefficient = 0.1", "coefficient = 0.0") + MEASURED)
    for command in (
        ("infer", scene),
        ("trade", scene),
        ("run", scene, "--accuracy", "2%", "-o", tmp_path / "out.zarr"),
        ("run", scene, "--boundary-only", "-o", tmp_path / "out.zarr"),
    ):
        assert run(*command) == 2
        assert "friction" in capsys.readouterr().err


def test_a_point_takes_conditions_in_place_of_the_scenes_own(swept, capsys):
    place = ("--load", "400 N", "--velocity", "2 m/s", "--json")
    given = ("--friction", 0.13, "--bulk-temperature", "50 degC", "--share", 0.05)
    same = (
        "friction.coefficient=0.13",
        "temperature.bulk=50 degC",
        "temperature.failing_share=0.05",
    )
    assert run("point", swept / "small.toml", *place, *given) == 0
    by_option = json.loads(capsys.readouterr().out)
    assert run("point", swept / "small.toml", *place, *(f"--set={entry}" for entry in same)) == 0
    by_setting = json.loads(capsys.readouterr().out)
    del by_option["wall_time"], by_setting["wall_time"]
    assert by_option == by_setting
    assert by_option["severe"]


def test_a_point_of_a_scene_without_friction_is_warm_at_the_friction_given(swept, capsys):
    arguments = ("point", swept / "small.toml", "--load", "400 N", "--velocity", "2 m/s", "--json")
    assert run(*arguments) == 0
    own = json.loads(capsys.readouterr().out)
    assert run(*arguments, "--set", "friction.coefficient=0", "--friction", 0.1) == 0
    assert json.loads(capsys.readouterr().out)["max_temperature"] == own["max_temperature"]


def test_a_point_says_why_it_has_its_fidelity(swept, capsys):
    at = ("--load", "400 N", "--velocity", "2 m/s", "--json")
    assert run("point", swept / "small.toml", *at, "--accuracy", "10%") == 0
    picked = json.loads(capsys.readouterr().out)["selection"]
    assert picked["error"] <= 0.1
    assert picked["points"] == [{"load": 400.0, "velocity": 2.0}]


def test_another_scene_is_refused_with_what_differs(swept, tmp_path, capsys):
    other = tmp_path / "other.toml"
    other.write_text(SCENE.replace('radius = "2 mm"', 'radius = "3 mm"'))
    assert run("run", other, "-o", swept / "small.zarr", "--workers", 1) == 3
    assert "pin.radius" in capsys.readouterr().err


def test_every_fault_of_a_scene_is_named_with_its_key(tmp_path, capsys):
    scene = tmp_path / "faulty.toml"
    text = SCENE.replace('radius = "2 mm"', 'radius = "-2 mm"').replace("title", "titel")
    text = text.replace('"150 N/s"', '"150 N"').replace("[friction]\ncoefficient = 0.1\n", "")
    scene.write_text(text)
    assert run("check", scene) == 2
    said = capsys.readouterr().err
    for key in ("pin.radius", "titel", "loading.rate", "friction"):
        assert key in said
    assert "Traceback" not in said


def test_an_unknown_preset_is_refused_with_those_known(swept, capsys):
    assert run("run", swept / "small.toml", "--preset", "superb") == 2
    said = capsys.readouterr().err
    assert "superb" in said
    assert "draft" in said


def test_what_is_not_there_is_refused(tmp_path, capsys):
    assert run("check", tmp_path / "missing.toml") == 2
    assert run("status", tmp_path / "missing.zarr") == 2
    assert run("boundary", tmp_path / "missing.zarr") == 2
    assert run("plot", tmp_path / "missing.zarr") == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "SCENE.toml"),
        (["sing", "scene.toml"], "sing"),
        (["run", "scene.toml", "--workers", "none"], "at least 1"),
        (["point", "scene.toml", "--load", "5 kg", "--velocity", "1 m/s"], "750 N"),
        (["point", "scene.toml", "--load", "5", "--velocity", "1 m/s"], "750 N"),
        (["plot", "out.zarr", "--kind", "portrait"], "diagram"),
        (["boundary", "out.zarr", "--bulk-temperature", "60 C"], "write 60 degC"),
        (["boundary", "out.zarr", "--bulk-temperature", "60,5 degC"], 'a point: "60.5 degC"'),
        (["run", "scene.toml", "--workers", "2", "--scheduler", "tcp://a:1"], "not allowed"),
        (["status", "out.zarr", "--friction", "0.1"], "usage: irg status"),
        (["status", "out.zarr", "--friction", "0.1"], "unknown option or argument: --friction 0.1"),
    ],
)
def test_wrong_use_exits_with_2_and_says_why(arguments, said, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert said in capsys.readouterr().err


def test_conditions_out_of_range_are_refused(swept, capsys):
    assert run("boundary", swept / "small.zarr", "--share", "1.5") == 2
    assert "share" in capsys.readouterr().err
    assert run("boundary", swept / "small.zarr", "--critical-temperature", "10 degC") == 2
    assert "critical_temperature is 10 °C" in capsys.readouterr().err
    assert run("boundary", swept / "small.zarr", "--bulk-temperature", "-300 degC") == 2
    assert "bulk_temperature is -300 °C" in capsys.readouterr().err


def test_margin_says_how_far_an_operating_point_is_from_severe_wear(swept, capsys):
    place = ("--load", "300 N", "--velocity", "1.5 m/s")
    assert run("margin", swept / "small.zarr", *place, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    left = document["critical_temperature"] - document["decisive_temperature"]
    assert document["distance"] == pytest.approx(left)
    assert run("margin", swept / "small.zarr", *place) == 0
    out = capsys.readouterr().out
    assert f"{abs(left):.1f} K" in out
    assert "in velocity" in out
    assert "in load" in out


def test_a_scene_in_place_of_a_store_and_a_store_in_place_of_a_scene_are_told_apart(swept, capsys):
    assert run("boundary", swept / "small.toml") == 2
    assert "small.toml is a file, not a store" in capsys.readouterr().err
    assert run("check", swept / "small.zarr") == 2
    assert "cannot be read: a store; give a scene file" in capsys.readouterr().err


def test_a_negative_velocity_is_remarked_on(swept, capsys):
    place = ("--load", "200 N", "--velocity", "-1 m/s", "--set", "increments=1")
    assert run("point", swept / "small.toml", *place, "--set", "window.pixels=[64, 16]") == 0
    assert "the velocity is negative, so the disk slides towards −x" in capsys.readouterr().out


def test_a_wear_rate_says_how_long_the_pin_slid_and_what_more_would_change(swept, capsys):
    scene = swept / "small.toml"
    width = ("--contact-width", "300 um", "--load", "600 N", "--velocity", "1.5 m/s")
    rates = []
    for more, slid in ((), "4 s"), (("--duration", "8 s"), "8 s"):
        assert run("infer", scene, *width, *more) == 0
        said = capsys.readouterr().out
        assert f"for {slid} of sliding" in said
        assert ("give --duration" in said) == (not more)
        assert run("infer", scene, *width, *more, "--json") == 0
        rates.append(json.loads(capsys.readouterr().out)["value"])
    # Wear goes with the load times the time: 4 s of ramp count 2 s, and 4 s more count 4.
    assert rates[0] / rates[1] == pytest.approx(3.0, rel=0.15)
    assert run("infer", scene, *width, "--duration", "3 s") == 2
    assert "at least the 4 s of the ramp" in capsys.readouterr().err

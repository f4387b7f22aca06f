"""The command line, as a user types it."""

import csv
import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.cli import main
from pipeline.constants import PRESET_BOUNDS
from pipeline.run import cluster
from pipeline.run.work import ExecutionError
from pipeline.store.create import writing
from pipeline.store.store import opened
from pipeline.sweep.plan import points
from tests.helpers.scenes import SCENE
from tests.helpers.stores import commit_all, contents, fail

# The numerical error of a preset is known.
STANDARD = SCENE.replace("pixels_per_element = 1\nincrements = 10", 'preset = "standard"')


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cli")
    (folder / "small.toml").write_text(STANDARD)
    command = ["run", folder / "small.toml", "-o", folder / "small.zarr", "--workers", 1]
    assert main([str(word) for word in command]) == 0
    return folder


@pytest.fixture
def scene(swept):
    return swept / "small.toml"


@pytest.fixture
def store(swept):
    return swept / "small.zarr"


def test_run_again_has_nothing_left_to_do(scene, store, irg):
    run = irg("run", scene, "-o", store, "--json", "--workers", 1)
    assert (run["points"], run["done"], run["computed"], run["failed"]) == (9, 9, 0, 0)
    output = irg("run", scene, "-o", store)
    assert f"next: irg boundary {store}, irg plot {store}\n" in output
    assert irg("boundary", store).partition("warning: ")[0] in output


def test_points_that_fail_are_listed_and_the_others_are_done(tmp_path, irg):
    (tmp_path / "heavy.toml").write_text(SCENE.replace('"400 N"', '"7e6 N"'))
    arguments = ("--set", "increments=1", "-o", tmp_path / "heavy.zarr", "--workers", 1)
    output = irg("run", tmp_path / "heavy.toml", *arguments, code=1)
    assert "6 of 9 points done" in output
    assert output.count("failed: 7e+06 N") == 3
    assert "\nto simulate failed points again, add --retry-failed to the command\n" in output


def test_status_and_verify_count_the_points_of_the_dataset(store, tmp_path, irg):
    copy = shutil.copytree(store, tmp_path / "small.zarr")
    sweep = opened(copy).sweep
    with writing(copy, sweep) as half:
        half.forget(points(sweep)[3:6:2])
    fail(copy, sweep, points(sweep)[3], "out of memory")
    (record,) = irg("status", copy, "--json", code=1)
    assert [record[name] for name in ("points", "done", "failed", "pending")] == [9, 7, 1, 1]
    assert (record["title"], record["preset"]) == ("A small sweep", "standard")
    output = irg("status", copy, code=1)
    assert "9 points: 7 done, 1 failed, 1 pending" in output
    assert output.count(": out of memory\n") == output.count("failed: ") == 1
    assert (
        f"discretization error at most {100 * PRESET_BOUNDS['standard']:g} % of critical" in output
    )
    ds = xr.open_zarr(copy, chunks=None)
    flags = ds["warning_flags"].where(ds["status"] == 1, 0).values.astype(int)
    by_bit = [np.count_nonzero(flags & bit) for bit in 1 << np.arange(31)]
    (kinds,) = re.findall(r"a warning \((.*?)\)", " ".join(output.split()))
    counts = sorted(int(number) for number in re.findall(r": (\d+)", kinds))
    assert counts == sorted(filter(None, by_bit)) != []
    assert f"{np.count_nonzero(flags)} points carry" in output
    assert irg("verify", copy, "--json")["points"] == {"done": 7, "damaged": 0}
    assert "points: 7 done and undamaged, 0 damaged" in irg("verify", copy)
    for chunk in (copy / "wall_time").glob("c.*"):
        chunk.write_bytes(b"")
    output = irg("status", copy, code=1)
    assert "9 points: 7 done, 1 failed, 1 pending" in output
    assert f"points with warnings could not be counted: {copy}" in output


def both(irg, folder, *words):
    """Printed text and JSON document of one run of a command."""
    output = irg(*words, "-o", folder / "both.json")
    return output, json.loads((folder / "both.json").read_text())


def test_a_point_alone_is_the_point_of_the_store(scene, store, tmp_path, irg):
    ds = pipeline.open_sweep(store).sel(load=400, velocity=4, step=0)
    output, (row,) = both(irg, tmp_path, "point", scene, "--load=400 N", "--velocity=4 m/s")
    quantiles, highest = ds["rise_quantile"], 298.15 + 0.1 * ds["max_rise"].item()
    temperature = 298.15 + 0.1 * quantiles.sel(area_fraction_below=0.9).item()
    assert row["governing temperature [°C]"] == pytest.approx(temperature - 273.15, rel=1e-9)
    assert row["temperature margin [K]"] == pytest.approx(418.15 - temperature, rel=1e-9)
    (printed,) = re.findall(r"governing temperature: ([\d.]+) °C, simulated at this point", output)
    assert abs(float(printed) - (temperature - 273.15)) <= 0.25 * row["temperature error [K]"]
    for words, value in {
        "highest temperature [°C]": highest - 273.15,
        "heat into the pin [%]": 100 * ds["pin_heat_share"].item(),
        "contact width [µm]": 1e6 * ds["contact_width"].item(),
        "real contact area of the window [%]": 100 * ds["contact_fraction"].item(),
        "mean pressure [GPa]": 1e-9 * ds["mean_pressure"].item(),
        "highest pressure [GPa]": 1e-9 * ds["max_pressure"].item(),
        "wear depth [µm]": 1e6 * ds["wear_depth_max"].item(),
        "wear volume [mm³]": 1e9 * ds["wear_volume"].item(),
        "time [s]": ds["time"].item(),
        "sliding distance [m]": ds["sliding_distance"].item(),
        "failed area fraction [%]": row["failed area fraction [%]"],
    }.items():
        assert row[words] == pytest.approx(value, rel=1e-9)
        assert re.search(
            rf"^{re.escape(words)} +{re.escape(f'{value:.4g}')}$", output, re.MULTILINE
        )
    cooler = np.interp(1200.0, quantiles.values, quantiles["area_fraction_below"].values)
    assert row["failed area fraction [%]"] == pytest.approx(100 * (1 - cooler), abs=2)


def test_a_point_takes_conditions_in_place_of_the_scenes_own_and_is_a_table(scene, tmp_path, irg):
    point = ("point", scene, "--load", "600 N", "--velocity", "4 m/s")
    options = ("--friction=0.13", "--bulk-temperature=50 degC", "--critical-area-fraction=0.05")
    same = ("friction.coefficient=0.13", "temperature.bulk=50 degC",
            "temperature.critical_area_fraction=0.05")  # fmt: skip
    out = tmp_path / "point.csv"
    output = irg(*point, *options, "--set", "note=of no rig", "-o", out)
    assert output.startswith("Severe at 600 N and 4 m/s\nprobability of severe wear ")
    assert "\nnumerical error (95 %): ± " in output
    (written_row,) = csv.DictReader(out.read_text(encoding="utf-8").splitlines())
    assert (written_row["load [N]"], written_row["verdict"]) == ("600", "severe")
    notes = written_row["notes"].split(" | ")
    assert notes[0] == "of no rig"
    assert output.count("\n".join(notes)) == 1
    (row,) = irg(*point, *(f"--set={entry}" for entry in same), "--json")
    assert row["governing temperature [°C]"] == pytest.approx(
        float(written_row["governing temperature [°C]"]), rel=1e-5
    )
    (row,) = irg(*point, "--friction", 0, "--json")
    assert row["highest temperature [°C]"] == row["governing temperature [°C]"] == 25
    assert (row["failed area fraction [%]"], row["verdict"]) == (0, "mild")


TESTS = "".join(
    f'\n[[tests]]\nload = "{load} N"\nvelocity = "{velocity} m/s"\noutcome = "severe"\n'
    for load, velocity in ((200, 1), (600, 4))
)


def test_a_point_counts_the_tests_of_its_scene_unless_they_are_left_out(
    scene, tmp_path, irg, monkeypatch
):
    """Two severe tests where the model is mild raise the probability of severe wear."""
    monkeypatch.chdir(tmp_path)
    tested = tmp_path / "tested.toml"
    tested.write_text(scene.read_text() + TESTS)
    point = ("point", tested, "--load", "400 N", "--velocity", "1 m/s")
    output, (other,) = both(irg, tmp_path, *point)
    untested_output, (row,) = both(irg, tmp_path, *point, "--without-tests")
    assert re.search(
        r"model error: .* of the temperature rise \(90 % range, from [12] tests?", output
    )
    assert "(90 % range, from the prior)" in untested_output.replace("\n    ", " ")
    assert other["probability"] > row["probability"]
    assert "only 0.8, 1 and 1.2 m/s were simulated at this load" in output
    assert "simulated load" not in output
    assert "highest simulated" not in output
    other_oil = "--critical-temperature", "150 degC"
    (untested,) = irg(*point, "--without-tests", *other_oil, "--json")
    (what_if,) = irg(*point, *other_oil, "--json")
    assert what_if["probability"] == pytest.approx(untested["probability"], rel=1e-9)
    assert what_if["notes"].startswith("the tests are left out: they hold for the critical temp")
    assert other["governing temperature [°C]"] == row["governing temperature [°C]"]
    plane = "--set", 'sweep.loads=["400 N"]', "--set", 'sweep.velocities=["1 m/s"]'
    irg("run", tested, *plane, "-o", "results/tested.zarr", "--workers", 1)
    (stored,) = irg(*point, "--json")  # the tests are those of the store
    assert stored["probability"] == pytest.approx(other["probability"], rel=1e-9)


def test_a_point_does_not_simulate_tests_of_another_oil(scene, tmp_path, irg):
    tested = tmp_path / "tested.toml"
    tested.write_text(scene.read_text() + 4 * TESTS)
    point = "point", tested, "--load", "200 N", "--velocity", "1 m/s"
    output = irg(*point, "--critical-temperature", "150 degC")
    assert "the tests are left out: they hold for the critical temperature" in output
    assert "points will be simulated" not in output
    output = irg(*point, "--critical-temperature", "150 degC", "--without-tests")
    assert "the tests are left out" not in output
    assert "11 points will be simulated, including those of tests" in irg(*point)


def untimed(output):
    return re.sub(r"(?m)^time .*", "", output)


def test_a_dry_run_says_what_check_says_and_computes_nothing(scene, tmp_path, irg, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = irg("run", scene, "-n", "-j", 2, "-o", "a.zarr")
    assert untimed(output) == untimed(irg("check", scene, "-j", 2))
    assert [*tmp_path.iterdir()] == []


def test_tables_are_written_as_csv_markdown_and_json(store, tmp_path, irg):
    ask = ("boundary", store, "--by", "velocity")
    document = irg(*ask, "--json")
    for suffix in (".csv", ".md", ".json"):
        assert f"written: {tmp_path / f'table{suffix}'}\n" in irg(
            *ask, "-o", tmp_path / f"table{suffix}"
        )
    assert json.loads((tmp_path / "table.json").read_text()) == document
    critical = pipeline.boundary(store)["critical_load"].values
    printed = np.array([row["critical load [N]"] for row in document], float)
    np.testing.assert_allclose(printed, critical, 1e-12)
    csv_rows = list(
        csv.DictReader((tmp_path / "table.csv").read_text(encoding="utf-8").splitlines())
    )
    assert [float(row["velocity [m/s]"]) for row in csv_rows] == [1.0, 2.0, 4.0]
    assert len((tmp_path / "table.md").read_text(encoding="utf-8").splitlines()) == 2 + len(
        csv_rows
    )


def test_tests_of_a_store_of_another_version_are_simulated_again(tmp_path, monkeypatch, irg):
    monkeypatch.chdir(tmp_path)
    tested = '[[tests]]\nload = "200 N"\nvelocity = "1 m/s"\noutcome = "severe"\n'
    Path("small.toml").write_text(SCENE.replace("increments = 10", "increments = 2") + tested)
    sweep = pipeline.load_scene("small.toml", overrides={"sweep.loads": ["200 N"]})
    commit_all("results/small.zarr", sweep)
    usual = irg("infer", "small.toml")
    assert "cannot be copied" not in usual
    document = Path("results/small.zarr/about/zarr.json")
    facts = json.loads(document.read_text())
    facts["attributes"]["format"] += 1
    document.write_text(json.dumps(facts))
    Path("results/small.zarr/zarr.json").unlink()
    note, *rest = irg("infer", "small.toml").splitlines()[::-1]
    assert "irg: note: the tests are simulated, since no results can be copied: " in note
    assert rest[::-1] == usual.splitlines()


def test_a_run_says_at_once_that_it_waits_for_a_scheduler(tmp_path, monkeypatch, irg):
    def refuse(address, file):
        raise ExecutionError(f"no Dask scheduler answers at {address}")

    monkeypatch.setattr(cluster, "client_of", refuse)
    (tmp_path / "small.toml").write_text(SCENE)
    output = irg("run", tmp_path / "small.toml", "--scheduler", "tcp://a:1", code=2)
    assert "connecting to the Dask scheduler at tcp://a:1, for at most 30 s\n" in output


def test_a_sweep_of_one_point_ends_with_the_command_for_its_margin(tmp_path, monkeypatch, irg):
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(SCENE)
    point = "--set", 'sweep.loads=["200 N"]', "--set", 'sweep.velocities=["1 m/s"]'
    output = irg("run", "small.toml", *point, "--set", "increments=2", "--workers", 1)
    (command,) = re.findall(r"one point has no boundary; next: irg (.*)\n", output)
    assert "1 operating point: " in irg(*shlex.split(command))


def test_commands_that_read_write_nothing_into_a_store(copy, irg, tmp_path):
    before = contents(copy.parent)
    for command in ("status", "boundary", "verify"):
        irg(command, copy)
    irg("margin", copy, "--load", "300 N", "--velocity", "1.1 m/s")
    assert contents(copy.parent) == before
    irg("plot", copy, "-o", tmp_path / "a.png")
    assert contents(copy) == {k.split("/", 1)[1]: v for k, v in before.items() if "/" in k}

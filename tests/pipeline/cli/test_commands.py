"""The command line, as a user types it."""

import csv
import json
import re
import shutil

import pytest

from pipeline.cli import main
from tests.helpers.scenes import SCENE

# The numerical error of a preset is known.
STANDARD = SCENE.replace("pixels_per_element = 1\nincrements = 10", 'preset = "standard"')


def run(*arguments):
    return main([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cli")
    (folder / "small.toml").write_text(STANDARD)
    out = folder / "small.zarr"
    assert run("run", folder / "small.toml", "-o", out, "--workers", 1) == 0
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
    assert f"next: irg boundary {store}, irg plot {store}\n" in irg("run", scene, "-o", store)


def test_points_that_fail_are_listed_and_the_others_are_done(tmp_path, irg):
    (tmp_path / "heavy.toml").write_text(SCENE.replace('"400 N"', '"7e6 N"'))
    arguments = ("--set", "increments=1", "-o", tmp_path / "heavy.zarr", "--workers", 1)
    said = irg("run", tmp_path / "heavy.toml", *arguments, code=1)
    assert "6 of 9 points done" in said
    assert said.count("failed: 7e+06 N") == 3
    assert "to simulate failed points again, add --retry-failed" in said
    irg("status", tmp_path / "heavy.zarr", code=1)


def test_status_counts_done_points_that_the_scene_no_longer_asks_for(scene, store, tmp_path, irg):
    said = irg("status", store)
    assert "9 points: 9 done, 0 failed, 0 pending" in said
    copy = shutil.copytree(store, tmp_path / "small.zarr")
    irg("run", scene, "--set", 'sweep.loads=["200 N"]', "-o", copy, "-q", "--workers", 1)
    said = irg("status", copy)
    assert "9 points: 9 done, 0 failed, 0 pending" in said
    (record,) = irg("status", copy, "--json")
    assert (record["done"], record["pending"], record["preset"]) == (9, 0, "standard")


def test_point_in_words_and_as_a_table(scene, tmp_path, irg):
    out = tmp_path / "point.csv"
    place = ("--load", "600 N", "--velocity", "4 m/s", "--friction", 0.15, "--preset", "standard")
    said = irg("point", scene, *place, "--set", "note=of no rig", "-o", out)
    assert said.startswith("Severe: probability of severe wear ")
    assert "  numerical error (95 %)  ± " in said
    (held,) = csv.DictReader(out.read_text(encoding="utf-8").splitlines())
    assert (held["load [N]"], held["verdict"]) == ("600", "severe")
    notes = held["notes"].split(" | ")
    assert notes[0] == "of no rig"
    assert said.count("\n".join(notes)) == 1
    width = float(held["contact width [µm]"])
    assert re.search(rf"contact width \[µm\] +{width:.4g}\n", said)
    said = irg("point", scene, "--load", "200 N", "--velocity", "-1 m/s", code=2)
    assert "velocity is -1 m/s; it must be above 0" in said


TESTS = """
[[tests]]
load = "200 N"
velocity = "1 m/s"
outcome = "severe"

[[tests]]
load = "600 N"
velocity = "4 m/s"
outcome = "severe"
"""


def test_a_point_counts_the_tests_of_its_scene_unless_they_are_left_out(
    scene, tmp_path, irg, irg_both, monkeypatch
):
    """Two severe tests where the model is mild make a place likelier severe."""
    monkeypatch.chdir(tmp_path)
    tested = tmp_path / "tested.toml"
    tested.write_text(scene.read_text() + TESTS)
    point = ("point", tested, "--load", "400 N", "--velocity", "1 m/s")
    said, (other,) = irg_both(*point)
    alone, (row,) = irg_both(*point, "--without-tests")
    assert re.search(
        r"model error   .* of the temperature rise \(90 % range, from [12] tests? and", said
    )
    assert "(90 % range, from the prior)" in alone.replace("\n    ", " ")
    assert "some verdicts are withheld" not in alone
    other_surface = irg(*point, "--set", "sweep.realizations=[3, 4]", "--realization", 4)
    assert re.search(r"\(90 % range, from [12] tests? and the", other_surface)
    assert other["probability"] > row["probability"]
    assert other["governing temperature [°C]"] == row["governing temperature [°C]"]
    irg("run", tested, "-o", "results/tested.zarr")
    (stored,) = irg(*point, "--json")  # the tests are those of the store
    assert stored["probability"] == pytest.approx(other["probability"], rel=1e-9)


def test_a_point_takes_conditions_in_place_of_the_scenes_own(scene, irg):
    point = ("point", scene, "--load", "400 N", "--velocity", "2 m/s", "--json")
    options = (
        "--friction",
        0.13,
        "--bulk-temperature",
        "50 degC",
        "--critical-area-fraction",
        0.05,
    )
    same = (
        "friction.coefficient=0.13",
        "temperature.bulk=50 degC",
        "temperature.critical_area_fraction=0.05",
    )
    by_option, by_setting = (
        irg(*point, *words)[0] for words in (options, [f"--set={entry}" for entry in same])
    )
    assert by_option == by_setting
    assert by_option["failed area fraction [%]"] > 5
    (document,) = irg(*point, "--friction", 0)
    assert document["highest temperature [°C]"] == document["governing temperature [°C]"] == 25
    assert (document["failed area fraction [%]"], document["verdict"]) == (0, "mild")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", "scen.toml"], 'scene.toml"?)'),
        (["check", "first_tri"], 'did you mean "first_try"?'),
        (["boundary", "result/scene.zarr"], 'results/scene.zarr"?)'),
        (["margin", "results/scene.zarr", "--points", "dutty.csv"], 'duty.csv"?)'),
    ],
)
def test_a_misspelt_path_is_answered_with_one_that_may_be_meant(
    store, tmp_path, monkeypatch, capsys, arguments, said
):
    (tmp_path / "results").mkdir()
    (tmp_path / "results/scene.zarr").symlink_to(store)
    for name in ("scene.toml", "duty.csv"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    words = capsys.readouterr().err
    assert said in words
    assert "did you mean" in words


def untimed(said):
    return re.sub(r"(?m)^time .*", "", said)


def test_a_dry_run_says_what_check_says_and_computes_nothing(scene, tmp_path, irg, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = irg("run", scene, "-n", "-j", 2, "-o", "a.zarr")
    assert untimed(said) == untimed(irg("check", scene, "-j", 2))
    assert [*tmp_path.iterdir()] == []


def test_percent_and_quoted_paths_are_taken_as_in_a_scene(scene, store, irg):
    place = ("margin", store, "--load", "300 N", "--velocity", "2 m/s", "--json")
    same = irg(*place, "--friction", 0.12)
    assert irg(*place, "--friction", "12%") == irg(*place, "--at=friction.coefficient=12 %") == same
    paths = 'sweep.over."friction.coefficient"', "sweep.over.friction.coefficient"
    said = [irg("check", scene, "--set", f"{path}=[0.09, 0.11]") for path in paths]
    assert untimed(said[0]) == untimed(said[1])
    assert "in 18 tasks" in said[0]


def test_tables_are_written_as_csv_markdown_and_json_and_printed_in_part(store, tmp_path, irg):
    ask = ("boundary", store, "--by", "velocity")
    document = irg(*ask, "--json")
    for suffix in (".csv", ".md", ".json"):
        assert f"written: {tmp_path / f'table{suffix}'}\n" in irg(
            *ask, "-o", tmp_path / f"table{suffix}"
        )
    assert json.loads((tmp_path / "table.json").read_text()) == document
    held = list(csv.DictReader((tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["velocity [m/s]"]) for row in held] == [1.0, 2.0, 4.0]
    assert len((tmp_path / "table.md").read_text(encoding="utf-8").splitlines()) == 2 + len(held)
    frictions = [f"--friction={0.08 + 0.005 * step}" for step in range(5)]
    few, whole = (irg("boundary", store, *frictions, *more) for more in ([], ["--all"]))
    rows = [[line for line in text.splitlines() if line.startswith("0.")] for text in (few, whole)]
    assert [*map(len, rows)] == [8, 15]
    assert (rows[0][0], rows[0][-1]) == (rows[1][0], rows[1][-1])
    assert "7 more rows: use --all, or -o TABLE.csv" in few
    assert max(map(len, few.splitlines())) <= 100
    refused = irg("boundary", store, "--by", "test", code=2)
    assert "the scene has no tests" in refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "SCENE.toml"),
        (["sing", "scene.toml"], "sing"),
        (["point", "scene.toml", "--load", "5", "--velocity", "1 m/s"], "750 N"),
        (["margin", "out.zarr", "--load", "5 N"], "give --velocity, too"),
        (["plot", "out.zarr", "--width", "8,5 cm"], "decimals with a point"),
        (["run", "scene.toml", "--workers", "2", "--scheduler", "tcp://a:1"], "not allowed"),
        (["run", "scene.toml", "--acuracy=2%"], 'did you mean "--accuracy"?'),
        (["status", "out.zarr", "--friction", "0.1"], "unknown option or argument: --friction 0.1"),
        (["boundry", "out.zarr"], 'command is "boundry"; did you mean "boundary"?'),
        (["plot", "out.zarr", "--kind", "ram"], '--kind is "ram"; did you mean "ramp"?'),
        (["version"], 'command is "version"; did you mean "--version"?'),
        (["init"], 'command is "init"; did you mean "new"?'),
        (
            ["margin", "a.zarr", "--force", "3 N", "--speed=2 m/s"],
            'mean "--load" and "--velocity"?',
        ),
        (["--Version"], 'did you mean "--version"?'),
        (["run", "first_try", "--speed", "2"], 'did you mean "--set sweep.velocities=…"?'),
        (["check", "first_try", "--friction", "0.1"], '"--set friction.coefficient=…"?'),
        (["status", "out.zarr", "--force"], "unknown option or argument: --force; see"),
        (["--quiet", "status"], "options stand after the command: irg status … --quiet"),
        (["margin", "a.zarr", "--load", "3 N", "--load", "5 N"], "--load is given twice; give it"),
    ],
)
def test_wrong_use_exits_with_2_and_says_why_in_one_line(arguments, said, irg):
    words = irg(*arguments, code=2)
    assert said in words
    assert words.count("\n") == 1

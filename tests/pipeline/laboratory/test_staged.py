"""Logs with columns of run, stage and hold: `irg tests` prints the stages of each specimen."""

import pytest

import pipeline

HEAD = "run,stage,load [N],velocity [m/s],hold [s],friction,outcome\n"
RUNS = (
    HEAD
    + """A,1,100,2.25,60,0.1,mild
A,2,200,2.25,60,0.1,mild
A,3,400,2.25,120,0.11,severe
B,1,100,3,60,0.1,mild
C,1,150,3,30,0.1,severe
"""
)
BEGIN = 'extends = "first_try"\nwithout = ["measured"]\n'


@pytest.fixture
def printed(tmp_path, irg):
    def ask(text):
        (tmp_path / "log.csv").write_text(text)
        return irg("tests", tmp_path / "log.csv", "--json")["toml"]

    return ask


def test_each_run_is_one_specimen_with_its_past(printed, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(BEGIN + printed(RUNS))
    tests = pipeline.load_scene(scene).tests
    loads = [test.simulated.scene.loading.loads for test in tests]
    assert loads[:2] == [(100.0, 200.0, 400.0)] * 2
    assert tests[1].simulated.scene.loading.holds == (60.0, 60.0, 120.0)
    assert [(test.run, test.normal_load, test.outcome) for test in tests] == [
        ("A", 200.0, "mild"), ("A", 400.0, "severe"), ("B", 100.0, "mild"), ("C", 150.0, "severe"),
    ]  # fmt: skip
    assert tests[1].friction == 0.11


def test_the_column_of_stages_counts_as_used(tmp_path, irg):
    (tmp_path / "log.csv").write_text(RUNS)
    told = irg("tests", tmp_path / "log.csv", "--json")
    assert told["columns"]["stage"] == "stage"
    assert not told["unused"]


def test_stages_of_velocity_are_those_of_a_run_at_one_load(printed):
    rows = "A,1,400,1,60,0.1,mild\nA,2,400,2,60,0.1,severe\n"
    text = printed(HEAD + rows)
    assert 'stages = [["1 m/s", "60 s"], ["2 m/s", "60 s"]]' in text
    assert 'load = "400 N"' in text


@pytest.mark.parametrize(
    "text",
    [
        RUNS.replace("stage", "number"),
        RUNS.replace("hold [s]", "remark"),
        RUNS.replace("A,2,200", "A,2,50"),
        RUNS.replace("A,1,100,2.25,60,0.1,mild", "A,1,100,2.25,60,0.1,severe"),
        RUNS.replace("A,2,200,2.25", "A,2,200,2.5"),
    ],
    ids=["no stages", "no holds", "a load falls", "severe first", "both rise"],
)
def test_what_is_no_run_by_stages_stays_a_log(printed, text):
    assert 'file = "log.csv"' in printed(text)

"""What is understood of a laboratory's files, and the lines of a scene for them."""

import numpy as np
import pytest

import pipeline

LOG = "Normalkraft F_N / N;v in m/s;Ergebnis\n400;1,75;ok\n400;2,75;Fresser\n"


def test_the_lines_that_are_printed_make_the_scene_read_the_log(tmp_path, irg):
    (tmp_path / "log.csv").write_text(LOG, encoding="utf-8")
    said = irg("tests", tmp_path / "log.csv")
    assert "2 tests: 1 mild, 1 severe" in said
    table = said[said.index("[[tested]]") :]
    scene = f'extends = "first_try"\nwithout = ["measured"]\n{table}'
    (tmp_path / "lab.toml").write_text(scene, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").about.tested
    assert [(test.velocity, test.outcome) for test in tested] == [(1.75, "mild"), (2.75, "severe")]


def test_what_is_missing_is_said_and_may_be_given(tmp_path, irg):
    (tmp_path / "log.csv").write_text("a;b;c\n400;1,75;kaputt\n", encoding="utf-8")
    assert "load (needed)" in irg("tests", tmp_path / "log.csv", code=2)
    given = ["--column", "load=a", "--column", "velocity=b", "--column", "outcome=c"]
    said = irg("tests", tmp_path / "log.csv", *given, code=2)
    assert "row 2, load: 400 has no unit" in said
    assert "no test has" in irg("tests", tmp_path / "log.csv", "--column", "lod=a", code=2)


def test_two_columns_of_outcomes_are_asked_about_and_units_doubted(tmp_path, irg):
    log = tmp_path / "log.csv"
    log.write_text("load [N],velocity [m/s],result,verdict\n400,1.2,mild,severe\n")
    said = irg("tests", log, code=2)
    assert '2 columns may be outcome: "result", "verdict"' in said
    assert "[[measured]]" not in said
    log.write_text("load [N],velocity [m/s],bulk temperature [degC],outcome\n400,1.2,333,mild\n")
    said = irg("tests", log)
    assert "the test of 400 N at 1.2 m/s: the bulk temperature is 333 °C, where" in said


@pytest.mark.parametrize(
    ("step", "words"), [(0.15, "at 30 s, at a load of 300 N"), (0.0, "no transition")]
)
def test_a_trace_of_friction_gives_its_transition(tmp_path, irg, step, words):
    time = np.arange(0.0, 60.0, 0.5)
    friction = 0.1 + 0.002 * np.sin(7 * time) + step * (time >= 30)
    rows = "".join(f"{t:g}\t{10 * t:g}\t{mu:.4f}\n" for t, mu in zip(time, friction, strict=True))
    (tmp_path / "trace.txt").write_text(f"Time (s)\tFn (N)\tCOF\n{rows}", encoding="utf-8")
    said = irg("tests", tmp_path / "trace.txt")
    assert words in said
    assert ('load = "300 N"' if step else 'outcome = "mild"') in said

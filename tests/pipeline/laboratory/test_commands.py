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


ROWS = """run;Öl;Last [N];v [m/s];Befund;Prüfer
1;A;400;2;ok;M
1;A;500;2;Fresser;M
1;A;500;2;Fresser;M
Mittel;;;;;
2;B;400;2;ok;
"""
SAID = """log.csv: semicolons between cells, decimal points

column     read as    first cell
run        run        1
Öl         oil        A
Last [N]   load       400 N
v [m/s]    velocity   2 m/s
Befund     outcome    ok, mild
Prüfer     not used   M
without a column: load_scatter, velocity_scatter, friction, friction_scatter, bulk_temperature, \
hold, number

3 tests of 2 runs, 2 oils: 2 mild, 1 severe; to paste into a scene beside the log:

[[tested]]
file = "log.csv"
columns = { load = "Last [N]", velocity = "v [m/s]", oil = "Öl", outcome = "Befund" }
words = { ok = "mild", Fresser = "severe" }

row 4 the same as rows before, and not counted
1 row without load and velocity left out
""".replace("\\\n", "")
TRANSITIONS = """tr.csv: commas between cells, decimal points

column         read as    first cell
load [N]       load       400 N
velocity [m/s] velocity   2 m/s
without a column: load_scatter, velocity_scatter, friction, friction_scatter, bulk_temperature, \
hold, number, oil, run, outcome (needed)

2 tests: 2 of a transition; to paste into a scene beside the log:
(read as transitions, since no column has outcomes; if they are tests, name the column with \
--column "outcome=HEADING")

[[measured]]
file = "tr.csv"
""".replace("\\\n", "")
TURNS = """rot.csv: commas between cells, decimal points

column              read as        first cell
load [N]            load           400 N
velocity            velocity       500 rpm at radius 20 mm
track radius [mm]   for the form   20 mm
outcome             outcome        mild
without a column: load_scatter, velocity_scatter, friction, friction_scatter, bulk_temperature, \
hold, number, oil, run

1 test: 1 mild; to paste into a scene beside the log:

[[tested]]
file = "rot.csv"

2 faults:
  row 3, velocity: "500 rpm" cannot be converted to m/s; give its track, too, such as "500 rpm at \
radius 30 mm"; give a velocity of at least 0, such as "1.25 m/s"
  row 4, velocity: missing; give a velocity of at least 0, such as "1.25 m/s"
""".replace("\\\n", "")


def test_a_column_that_is_not_found_is_asked_for_by_its_own_name(tmp_path, irg):
    (tmp_path / "log.csv").write_text("load [N],v\n100,1\n")
    said = irg("tests", tmp_path / "log.csv", code=2)
    assert 'columns = { velocity = "HEADING" } or --column "velocity=HEADING"' in said


@pytest.mark.parametrize(
    ("log", "said"),
    [
        (ROWS, SAID),
        ("load [N],velocity [m/s]\n400,2\n500,1.5\n", TRANSITIONS),
        (
            "load [N],speed [rpm],track radius [mm],outcome\n"
            "400,500,20,mild\n500,500,,mild\n600,,20,mild\n",
            TURNS,
        ),
    ],
)
def test_all_that_is_understood_of_a_log_is_printed(tmp_path, irg, monkeypatch, log, said):
    monkeypatch.chdir(tmp_path)
    name = said.partition(":")[0]
    (tmp_path / name).write_text(log, encoding="utf-8")
    found = irg("tests", name, code=2 if "faults:" in said else 0)
    words = [[line.split() for line in text.strip().splitlines()] for text in (found, said)]
    assert words[0] == words[1]


def test_some_rows_of_a_log_and_a_measured_wear_are_told(tmp_path, irg):
    path = tmp_path / "log.csv"
    path.write_text(ROWS, encoding="utf-8")
    document = irg("tests", path, "--where", "Öl=A", "--json")
    assert document["columns"]["oil"] == "Öl"
    assert document["unused"] == ["Prüfer"]
    assert [test["number"] for test in document["tests"]] == ["row 2", "row 3"]
    assert 'where = { "Öl" = "A" }' in document["toml"]
    unlike = irg("tests", path, "--where", "Oel=A", "--where", "Öl=C", code=2)
    assert 'where: there is no column "Oel"; give one of run, Öl, Last [N], v [m/s]' in unlike
    assert 'where: no row has "C" as Öl; give one of A, B' in unlike
    path.write_text("load [N],velocity [m/s],Brugger area [mm2]\n400,1,20\n", encoding="utf-8")
    document = irg("tests", path, "--json", code=2)
    assert document["tests"] == []
    assert document["faults"][0].startswith("no column says whether wear was mild or severe")

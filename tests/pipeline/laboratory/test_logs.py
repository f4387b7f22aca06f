"""Tests of a laboratory: tables of the scene, or rows of a log in CSV."""

import pandas as pd
import pytest

import pipeline
from pipeline.cli import main
from pipeline.laboratory.logs import outcome_of, read_log, read_trace
from pipeline.laboratory.spreadsheet import read_rows
from pipeline.scene.format import TRANSITION
from pipeline.scene.units import to_si
from pipeline.sweep.about import Measurement
from tests.helpers import tiny
from tribo import InputError

SCENE = """
extends = "first_try"
without = ["measured"]

[[tested]]
load = "400 N"
velocity = "2 m/s"
outcome = "mild"

[[tested]]
file = "log.csv"
"""


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab.toml").write_text(SCENE, encoding="utf-8")

    def load(log):
        (tmp_path / "log.csv").write_text(log, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return load


def test_rows_of_a_log_stand_beside_tables(lab):
    head = "date;Normal load [kN];velocity [m/s];friction;bulk temperature [degC];outcome;hold [s]"
    scene = lab(f"{head}\n1 May;0.4;2.5;0.1;60;severe;\n\n2 May;0.6;1.5;;;mild;10\n")
    assert scene.about.tested == (
        Measurement(400.0, 2.0, outcome="mild", number="1"),
        Measurement(400.0, 2.5, 0.1, bulk_temperature=333.15, outcome="severe", number="row 2"),
        Measurement(600.0, 1.5, hold=10.0, outcome="mild", number="row 4"),
    )
    assert "tested[1].file: columns not used: date" in [note.worded for note in scene.about.notes]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("0.4,-2,mild", ["row 2, velocity", "out of range"]),
        ("0.4,2,mlid", ["row 2, outcome", 'did you mean "mild"?']),
        ("0.4,2", ["row 2: 2 cells below 3 headings"]),
        ('"1,400",2,severe', ["row 2, load", '"1,400 kN"', "thousands without a comma"]),
    ],
)
def test_a_fault_is_named_by_row_and_column(lab, row, words):
    with pytest.raises(pipeline.SceneFileError) as caught:
        lab(f"load [kN],velocity [m/s],outcome\n{row}\n")
    assert all(word in str(caught.value) for word in words)


def test_a_transition_counts_with_its_own_bulk_and_hold():
    sweep = tiny.sweep(wear=None)  # so that it gets warmer in the hold
    plain, warm, held = (
        pipeline.critical_temperatures(
            sweep.changed(measured=(Measurement(300.0, 1.0, 0.1, **conditions),))
        ).mean
        for conditions in ({}, {"bulk_temperature": 333.15}, {"hold": 2.0})
    )
    bulk = sweep.conditions.bulk_temperature
    assert warm - 333.15 == pytest.approx(plain - bulk, rel=1e-9)
    assert held == pytest.approx(
        pipeline.critical_temperatures(
            sweep.held(2.0).changed(measured=(Measurement(300.0, 1.0, 0.1),))
        ).mean,
        rel=1e-12,
    )
    assert held > plain


@pytest.mark.parametrize(
    "log",
    [
        '"Last in kN","v in m/s","Befund"\n"0,4","1,75","kein Fresser"\n',
        '"Load (mN)",speed [m/s],Pass/Fail\n"400,000.0",1.75,pass\n',
        "# rig 3\n# load_N velocity_m/s outcome\n400 1.75 mild\n",
    ],
)
def test_a_log_is_read_in_other_languages_and_forms(tmp_path, log):
    path = tmp_path / "log.txt"
    path.write_text(log, encoding="utf-8")
    log = read_log(path)
    assert log.faults == []
    (test,) = log.tests
    assert [to_si(test["load"], "1 N"), to_si(test["velocity"], "1 m/s")] == [400.0, 1.75]
    assert test["outcome"] == "mild"


def test_a_trace_of_forces_and_a_speed_in_rpm_are_understood(tmp_path):
    path = tmp_path / "trace.txt"
    lines = ["# time_s load_N friction_N"]
    lines += [f"{t} {10 * t} {10 * t * (0.1 if t < 30 else 0.2)}" for t in range(60)]
    path.write_text("\n".join(lines))
    trace = read_trace(path)
    assert trace.load[trace.row] == 300.0
    (fault,) = read_log_faults(path, "load [N],speed [rpm],outcome\n400,300,mild\n")
    assert "give its track, too" in fault


def read_log_faults(path, log):
    path.write_text(log)
    return read_log(path).faults


OFFICE = (
    "Prüfer: Müller;;;;;\nNr.;Normalkraft F_N / N;Gleitgeschw. v in m/s;T_oil (°C);COF;Ergebnis\n"
    "1;400;1,75;25;0,098;ok\n2;1.200,5;2,75;25;;Fresser\n;;;;;\nMittelwert;;;;0,1;\n"
)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
def test_a_log_of_an_office_is_read_as_it_is(tmp_path, encoding):
    (tmp_path / "lab.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "log.csv").write_bytes(OFFICE.encode(encoding))
    about = pipeline.load_scene(tmp_path / "lab.toml").about
    assert about.tested[1:] == (
        Measurement(400.0, 1.75, 0.098, bulk_temperature=298.15, outcome="mild", number="1"),
        Measurement(1200.5, 2.75, bulk_temperature=298.15, outcome="severe", number="2"),
    )
    assert any('"Normalkraft F_N / N" as load' in note.words for note in about.notes)
    assert any("row 6 without load and velocity left out" in note.words for note in about.notes)


def test_a_sheet_of_excel_is_read_as_the_same_csv(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["Scuffing tests"], [], ["F_N/N", "v/(m/s)", "scuffed"], [400, 1.75, "no"]):
        book.active.append(row)
    book.save(tmp_path / "log.xlsx")
    scene = SCENE.replace("log.csv", "log.xlsx")
    (tmp_path / "lab.toml").write_text(scene, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").about.tested
    assert tested[1] == Measurement(400.0, 1.75, outcome="mild", number="row 4")


def test_rows_of_one_run_are_told_and_kept_apart_between_logs(tmp_path, capsys):
    log = "run,load [N],velocity [m/s],outcome\n3,300,2,ok\n3,400,2,Fresser\n4,400,2,ok\n"
    (tmp_path / "log.csv").write_text(log, encoding="utf-8")
    (tmp_path / "other.csv").write_text(log, encoding="utf-8")
    both = SCENE + '\n[[tested]]\nfile = "other.csv"\n'
    (tmp_path / "lab.toml").write_text(both, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").about.tested[1:]
    runs = [*["log.csv 3"] * 2, "log.csv 4", *["other.csv 3"] * 2, "other.csv 4"]
    assert [test.run for test in tested] == runs
    assert tested[0].number == "log.csv row 2"
    assert main(["tests", str(tmp_path / "log.csv")]) == 0
    assert "3 tests of 2 runs: 2 mild, 1 severe" in capsys.readouterr().out


def test_columns_words_and_decimals_of_the_user_come_first(tmp_path):
    own = '\ncolumns = { load = "Soll [N]" }\nwords = { kaputt = "severe" }\ndecimal = ","\n'
    (tmp_path / "lab.toml").write_text(SCENE + own, encoding="utf-8")
    log = 'Soll [N],Ist [N],v [m/s],Befund\n400,398,"1,75",kaputt\n'
    (tmp_path / "log.csv").write_text(log, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").about.tested
    assert tested[1] == Measurement(400.0, 1.75, outcome="severe", number="row 2")


def test_faults_of_one_kind_stand_in_one_line(lab):
    rows = "".join(f"400,{velocity},kaputt\n" for velocity in range(1, 9))
    with pytest.raises(pipeline.SceneFileError) as caught:
        lab(f"load [N],velocity [m/s],outcome\n{rows}")
    (fault,) = caught.value.faults
    assert "rows 2, 3, 4, 5, 6, 7 and 2 more, outcome" in fault


def test_columns_that_are_missing_are_said_once_with_those_found(lab):
    with pytest.raises(pipeline.SceneFileError) as caught:
        lab("Kraft [N],speed [rpm],result\n400,500,ok\n600,500,ok\n")
    fault, how = caught.value.faults
    assert 'no column "velocity [m/s]" in "Kraft [N]", "speed [rpm]", "result"' in fault
    assert '"speed [rpm]": "1 rpm" cannot be converted to m/s; give its track' in fault
    assert "irg tests" in how


def test_what_may_be_thousands_is_refused_unless_the_decimal_mark_is_given(lab, tmp_path):
    heads = "load [N];velocity [m/s];outcome\n"
    with pytest.raises(pipeline.SceneFileError, match=r'"1.250" .* 1.25 or 1250'):
        lab(heads + "1.250;1,5;mild\n")
    for mark, load in ((",", 1250.0), (".", 1.25)):
        (tmp_path / "lab.toml").write_text(f'{SCENE}\ndecimal = "{mark}"\n', encoding="utf-8")
        assert lab(heads + "1.250;2;mild\n").about.tested[1].normal_load == load


def test_a_scar_is_no_track_and_an_area_no_transition(tmp_path):
    path = tmp_path / "scars.csv"
    log = "load [N],speed [rpm],wear scar diameter [mm],outcome\n400,1450,0.6,mild\n"
    *_, fault = read_log_faults(path, log)
    assert 'none of "wear scar diameter [mm]" is surely its track' in fault
    assert not read_log_faults(path, log.replace("wear scar", "track"))
    for head in ("radius", "ball diameter"):
        *_, fault = read_log_faults(path, log.replace("wear scar diameter", head))
        assert "is surely its track" in fault
    path.write_text("load [N],velocity [m/s],Brugger area [mm2]\n400,1,20\n")
    assert read_log(path, row_of=TRANSITION).is_only_wear
    path.write_text("load of transition [N],velocity [m/s],Brugger area [mm2]\n400,1,20\n")
    assert not read_log(path, row_of=TRANSITION).is_only_wear


def test_exact_names_win_and_negations_are_known(tmp_path):
    path = tmp_path / "log.csv"
    head = "load [N],velocity [m/s],friction,friction_scatter,outcome\n"
    path.write_text(f"{head}400,1,0.1,0.01,not severe\n500,1,0.1,0.01,nicht bestanden\n")
    log = read_log(path)
    assert not log.faults
    assert [test["outcome"] for test in log.tests] == ["mild", "severe"]
    assert [test["friction_scatter"] for test in log.tests] == [0.01, 0.01]
    assert outcome_of("not true", "scuffed") is None
    (fault,) = read_log_faults(path, f"{head}400,1,0.1,0.01,hardly severe\n")
    assert "did you mean" not in fault
    assert 'words = { "hardly severe" = "OUTCOME" }' in fault


def test_rows_of_several_oils_are_told_apart_and_counted_once(tmp_path):
    rows = "1,FVA 3,400,1,mild\n2,PAO 8,400,1,mild\n3,PAO 8,800,1,severe\n3,PAO 8,800,1,severe\n"
    path = tmp_path / "oils.csv"
    assert read_log_faults(path, f"run,Öl,load [N],velocity [m/s],outcome\n{rows}") == []
    assert [test["oil"] for test in read_log(path).tests] == ["FVA 3", "PAO 8", "PAO 8"]
    log = read_log(path, {"where": {"Öl": "PAO 8"}})
    assert (len(log.tests), log.twice, log.faults) == (2, [5], [])
    assert "no row has" in read_log(path, {"where": {"Öl": "X"}}).faults[0]
    book = tmp_path / "book.xlsx"
    with pd.ExcelWriter(book) as written:
        pd.DataFrame({"a": [1]}).to_excel(written, sheet_name="Cover", index=False)
        pd.read_csv(path).to_excel(written, sheet_name="Log", index=False)
    log = read_log(book, {"where": {"Öl": "PAO 8"}, "sheet": "Log"})
    assert len(log.tests) == 2
    assert 'sheet "Log" (not read: Cover)' in log.sheet.form
    with pytest.raises(InputError, match='no sheet "Lag"; give one of Cover, Log'):
        read_log(book, {"sheet": "Lag"})


def test_empty_cells_at_the_end_of_headings_are_no_columns_and_remarks_no_headings(tmp_path):
    (tmp_path / "log.csv").write_text("# rig 3;;\nalpha;beta;;\n1;2;;\n3;4;5;\n")
    sheet = read_rows(tmp_path / "log.csv", lambda *_: False)
    assert [heading.text for heading in sheet.headings] == ["alpha", "beta"]
    assert [(row.number, row.cells) for row in sheet.rows] == [(3, ["1", "2"])]
    assert (sheet.above.strip(), sheet.of_rows[0].partition(";")[0]) == (
        "rig 3",
        "row 4: 3 cells below 2 headings",
    )


def test_an_outcome_that_is_missing_is_no_unknown_word(tmp_path):
    log = "load [N],velocity [m/s],outcome\n400,2,mild\n500,2,\n"
    (fault,) = read_log_faults(tmp_path / "log.csv", log)
    assert fault.startswith("row 3, outcome: ")
    assert "words = " not in fault


def test_headings_are_sought_at_the_top_alone(tmp_path):
    """A long file without headings that are known is read at once."""
    (tmp_path / "long.csv").write_text("alpha;beta\n" + "1;2\n" * 5000)
    asked = []
    sheet = read_rows(tmp_path / "long.csv", lambda cells, _: bool(asked.append(cells)))
    assert len(asked) < 1000
    assert (len(sheet.rows), sheet.headings[1].text) == (5000, "beta")


def test_columns_that_no_test_or_log_has_are_told(tmp_path):
    (tmp_path / "log.csv").write_text("F [N],velocity [m/s]\n300,2\n")
    columns = {"lode": "F [N]", "load": "P [N]"}
    faults = read_log(tmp_path / "log.csv", {"columns": columns}).faults
    assert faults[0].startswith('columns.lode: no entry (did you mean "load"?); give one of load,')
    assert faults[1] == 'columns.load: there is no column "P [N]"'

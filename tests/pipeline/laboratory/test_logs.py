"""Logs of tests, by `irg tests` and in the place of the tests of a scene."""

import pytest

import pipeline
from pipeline.sweep.measurement import Measurement
from tests.helpers.processes import python

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

    def load(log, choices="", more=""):
        file = f'file = {{ path = "log.csv"{choices} }}' if choices else 'file = "log.csv"'
        scene = SCENE.replace('file = "log.csv"', file)
        (tmp_path / "lab.toml").write_text(scene + more, encoding="utf-8")
        (tmp_path / "log.csv").write_bytes(log if isinstance(log, bytes) else log.encode())
        return pipeline.load_scene(tmp_path / "lab.toml")

    return load


@pytest.fixture
def tests(tmp_path, irg):
    """Function that runs `irg tests` on a log; tests of its document are in N and m/s."""

    def ask(log, *options, code=0):
        path = tmp_path / "log.csv"
        path.write_bytes(log if isinstance(log, bytes) else log.encode())
        document = irg("tests", path, *options, "--json", code=code)
        for test in document["tests"]:
            for name in ("load", "velocity", "mild_up_to", "severe_at"):
                if name in test:
                    unit = "1 m/s" if name == "velocity" else "1 N"
                    test[name] = pytest.approx(pipeline.to_si(test[name], unit), rel=1e-4)
        return document

    return ask


def contacts(document):
    return [(one["load"], one["velocity"], one["outcome"]) for one in document["tests"]]


def test_rows_of_a_log_stand_beside_tables(lab):
    head = "date;Normal load [kN];velocity [m/s];friction;bulk temperature [degC];outcome;hold [s]"
    scene = lab(f"{head}\n1 May;0.4;2.5;0.1;60;severe;5\n\n2 May;0.6;1.5;;70;mild;10\n")
    assert scene.tests == (
        Measurement(400.0, 2.0, outcome="mild", number="1"),
        Measurement(
            400.0, 2.5, 0.1, bulk_temperature=333.15, outcome="severe", number="row 2", hold=5.0
        ),
        Measurement(600.0, 1.5, hold=10.0, outcome="mild", number="row 4", bulk_temperature=343.15),
    )
    notes = [note.text for note in scene.notes]
    assert "tested[1].file: columns not used: date" in notes


def test_rows_that_lack_what_a_test_needs_are_left_out_and_counted(lab, tests):
    log = "load [N],velocity [m/s],outcome\n400,2,mild\n,2,mild\n0,2,mild\n500,2,\n# pause\n"
    document = tests(log + "700,2,severe\nMean,,\n")
    assert contacts(document) == [(400, 2, "mild"), (700, 2, "severe")]
    assert document["left_out"] == {
        "3": "has no load", "4": "is at rest", "5": "has no outcome", "6": "is commented out",
        "8": "has no number",
    }  # fmt: skip
    (fault,) = tests(log + "#600,2,severe\n", code=2)["faults"]
    assert 'row 7, load: "#600 N" is not a number' in fault


OFFICE = (
    "Prüfer: Müller;;;;;\nNr.;Normalkraft F_N / N;Gleitgeschw. v in m/s;T_oil (°C);COF;Ergebnis\n"
    "1;400;1,75;25;0,098;ok\n2;1.200,5;2,75;25;;Fresser\n;;;;;\nMittelwert;;;;0,1;\n"
)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", ";\n"])
def test_a_log_of_an_office_is_read_as_it_is(lab, encoding, end):
    scene = lab(OFFICE.replace("\n", end).encode(encoding))
    assert scene.tests[1:] == (
        Measurement(400.0, 1.75, 0.098, bulk_temperature=298.15, outcome="mild", number="1"),
        Measurement(1200.5, 2.75, bulk_temperature=298.15, outcome="severe", number="2"),
    )
    notes = " ".join(note.words for note in scene.notes)
    assert "3 rows: 2 used, 1 left out: row 6 has no load and no velocity" in notes


ONE = (400, 1.75, "mild")
TWO = [(49.03, 1.0472, "mild")]
LOGS = {
    # separators, marks and units
    "thousands": ('"Load (mN)",speed [m/s],Pass/Fail\n"400,000.0",1.75,pass\n', [ONE]),
    "blanks": ("# rig 3\n# load_N velocity_m/s outcome\n400 1.75 mild\n", [ONE]),
    "bars": ("| load (N) | speed (m/s) | outcome |\n|---|---|---|\n| 400 | 1.75 | mild |\n", [ONE]),
    "units below": ("Load,Speed,Result\nN,m/s,\n400,1.75,ok\n", [ONE]),
    "units in cells": ("load,velocity,outcome\n400 N,1.75 m/s,mild\n0.4 kN,1750 mm/s,mild\n",
                       [ONE, ONE]),
    "grams": ("Load (g),Speed (m/s),Result\n500,1,pass\n", [(4.903, 1, "mild")]),
    "a head of many lines": ("".join(f"entry {k}: 7\n" for k in range(22))
                             + "load [N],velocity [m/s],outcome\n400,1.75,mild\n", [ONE]),
    "an index": (",load [N],velocity [m/s],outcome\n0,400,1.75,mild\n1,400,1.75,mild\n", [ONE] * 2),
    "headings again": ("load [N],velocity [m/s],outcome\n400,1.75,mild\n\n"
                       "load [N],velocity [m/s],outcome\n500,1.75,severe\n",
                       [ONE, (500, 1.75, "severe")]),
    "units in columns": ("Load,Unit,Speed,Unit,Result\n0.4,kN,1750,mm/s,ok\n", [ONE]),
    # words
    "german": ("Kraft [N];Geschwindigkeit [m/s];Bewertung\n400;1,75;i.O.\n", [ONE]),
    "french": ("Charge (N);Vitesse (m/s);Résultat\n400;1,75;ok\n", [ONE]),
    "asked": ("load [N],velocity [m/s],scuffed?\n400,1.75,no\n400,1.75,yes\n",
              [ONE, (400, 1.75, "severe")]),
    "wished loads": ("Set load [N],Load [N],Speed [m/s],Result\n410,400,1.75,ok\n", [ONE]),
    # speeds
    "radius": ("Test,Load [kg],Speed [rpm],Track radius [mm],Result\n1,5,500,20,pass\n", TWO),
    "radians": ("Load [kgf],Speed [rad/s],Wear track radius [mm],Result\n5,52.36,20,ok\n", TWO),
    "reciprocation": ("Load [N],Frequency [Hz],Stroke [mm],Result\n400,50,17.5,ok\n", [ONE]),
    "slip": ("Load [N],SRR [%],Rolling speed [m/s],Result\n400,35,5,ok\n", [ONE]),
    "discs": ("Load [N],u1 [m/s],u2 [m/s],Result\n400,5,3.25,ok\n", [ONE]),
}  # fmt: skip


@pytest.mark.parametrize("name", LOGS)
def test_a_log_is_read_in_many_forms(tests, name):
    log, right = LOGS[name]
    document = tests(log)
    assert contacts(document) == right
    assert document["faults"] == []


def near(contact):
    """Load and velocity for comparison within 1e-4, and an outcome."""
    return (*(pytest.approx(x, rel=1e-4) for x in contact[:2]), contact[2])


ASKED = {
    # what a log lacks, the question, and the result after the answer
    "track": ("Load [N],Speed [rpm],Result\n400,500,ok\n", "track_radius=33.42 mm", ONE),
    "stroke": ("Load [N],Frequency [Hz],Result\n400,50,ok\n", "stroke=17.5 mm", ONE),
    "velocity": ("Load [N],Result\n400,ok\n", "velocity=1.75 m/s", ONE),
    "load": ("Speed [m/s],Result\n1.75,ok\n", "load=400 N", ONE),
    "outcome": ("Load [N],Speed [m/s]\n400,1.75\n", "outcome=mild", ONE),
}  # fmt: skip


@pytest.mark.parametrize("name", ASKED)
def test_what_a_log_lacks_is_asked_and_may_be_given(tests, irg, tmp_path, name):
    log, given, right = ASKED[name]
    document = tests(log, code=2)
    quantity = given.partition("=")[0]
    assert any(f'--given "{quantity}=' in fault for fault in document["faults"])
    (found,) = contacts(tests(log, "--given", given))
    assert (*(x.expected for x in found[:2]), found[2]) == near(right)
    toml = irg("tests", tmp_path / "log.csv", "--given", given, "--json")["toml"]
    (tmp_path / "lab.toml").write_text(
        f'extends = "first_try"\nwithout = ["measured"]\n{toml}', encoding="utf-8"
    )
    (test,) = pipeline.load_scene(tmp_path / "lab.toml").tests
    assert (test.normal_load, test.velocity, test.outcome) == near(right)


def test_a_ratio_above_two_is_asked_whether_it_is_in_percent(tests):
    log = "Load [N],SRR,Rolling speed [m/s],Result\n400,1.5,5,ok\n400,35,5,ok\n"
    document = tests(log, code=2)
    (fault,) = (one for one in document["faults"] if "above 2" in one)
    assert '--column "slide_roll_ratio=SRR [%]"' in fault
    found = tests(log, "--column", "slide_roll_ratio=SRR [%]")
    assert [one["velocity"] for one in found["tests"]] == [0.075, 1.75]


def test_columns_words_and_decimals_of_the_user_come_first(lab):
    own = ', columns = { load = "Soll [N]" }, decimal = ","'
    log = 'Soll [N],Ist [N],v [m/s],Befund\n400,398,"1,75",kaputt\n'
    tested = lab(log, own, '\nwords = { kaputt = "severe" }\n').tests
    assert tested[1] == Measurement(400.0, 1.75, outcome="severe", number="row 2")


def test_what_may_be_thousands_is_refused_unless_the_decimal_mark_is_given(lab):
    heads = "load [N];velocity [m/s];outcome\n"
    with pytest.raises(pipeline.SceneFileError, match=r'or decimal = ",", in { path = "FILE" }'):
        lab(heads + "1.250;2;mild\n")
    assert lab(heads + "1.250;1,5;mild\n").tests[1].normal_load == 1250.0
    for mark, load in ((",", 1250.0), (".", 1.25)):
        scene = lab(heads + "1.250;2;mild\n", f', decimal = "{mark}"')
        assert scene.tests[1].normal_load == load


def test_an_outcome_that_is_negated_means_the_contrary(tests):
    head = "load [N],velocity [m/s],friction,hold,outcome\n"
    document = tests(f"{head}400,1,0.1,2 s,not severe\n500,1,0.1,2 s,nicht bestanden\n")
    assert contacts(document) == [(400, 1, "mild"), (500, 1, "severe")]
    (fault,) = tests(f"{head}400,1,0.1,2 s,hardly severe\n", code=2)["faults"]
    assert "did you mean" not in fault
    assert '--word "hardly severe=severe"' in fault
    said = tests(f"{head}400,1,0.1,2 s,hardly severe\n", "--word", "hardly severe=mild")
    assert contacts(said) == [(400, 1, "mild")]


@pytest.mark.parametrize(
    ("heading", "cells", "known", "other"),
    [
        ("scuffed", ["", "", "x"], "severe", "mild"), ("scuffed", ["-", "", "1"], "severe", "mild"),
        ("Fresser", ["n/a", "–", "ja"], "severe", "mild"), ("passed", ["yes", "yes", ""], "mild",
         "severe"), ("result", ["ok", "ok", "---"], "mild", "severe"),
    ],
)  # fmt: skip
def test_empty_outcomes_beside_one_kind_of_outcome_are_asked(tests, heading, cells, known, other):
    rows = "".join(f"{100 * k},1,{cell}\n" for k, cell in enumerate(cells, 1))
    log = f"load [N],velocity [m/s],{heading}\n{rows}Mean,,\n"
    (fault,) = tests(log, code=2)["faults"]
    assert f"no outcome, where all others are {known}; say what it is by" in fault
    assert f'--word "={other}"' in fault
    document = tests(log, "--word", f"={other}")
    is_empty = [cell not in ("x", "1", "ja", "yes", "ok") for cell in cells]
    right = [(100 * k, 1, other if empty else known) for k, empty in enumerate(is_empty, 1)]
    assert contacts(document) == right
    assert f'"" = "{other}"' in document["toml"]
    alone = tests(log, "--where", fault[fault.index("outcome=") :].rstrip('"'))
    assert contacts(alone) == [one for one in right if one[2] == known]


OILS = (
    "run,Öl,load [N],velocity [m/s],outcome\n1,FVA 3,400,1,mild\n2,PAO 8,400,1,mild\n"
    "3,PAO 8,800,1,severe\n3,PAO 8,800,1,severe\n"
)


def test_rows_of_several_oils_are_told_apart_and_counted_once(tests, irg, tmp_path):
    document = tests(OILS)
    assert [test["oil"] for test in document["tests"]] == ["FVA 3", "PAO 8", "PAO 8"]
    assert document["left_out"] == {"5": "repeats an earlier row"}
    assert (
        "3 tests of 3 runs, 2 oils, of which a scene takes one (--where): 2 mild, 1 severe"
        in irg("tests", tmp_path / "log.csv")
    )
    some = tests(OILS, "--where", "Öl=PAO 8")
    assert len(some["tests"]) == 2
    assert 'where = { "Öl" = "PAO 8" }' in some["toml"]
    assert tests(OILS, "--skip", "oil=FVA 3")["tests"] == some["tests"]
    faults = tests(OILS, "--where", "Öl=X", "--skip", "Oel=A", code=2)["faults"]
    assert 'no row has "X" as Öl; give one of FVA 3, PAO 8' in faults
    assert any('skip: there is no column "Oel"; give one of run, Öl, load' in x for x in faults)


def test_rows_of_one_run_are_kept_apart_between_logs(tmp_path):
    log = "run,load [N],velocity [m/s],outcome\n3,300,2,ok\n3,400,2,Fresser\n4,400,2,ok\n"
    (tmp_path / "log.csv").write_text(log, encoding="utf-8")
    (tmp_path / "other.csv").write_text(log, encoding="utf-8")
    both = SCENE + '\n[[tested]]\nfile = "other.csv"\n'
    (tmp_path / "lab.toml").write_text(both, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").tests[1:]
    runs = [*["log.csv 3"] * 2, "log.csv 4", *["other.csv 3"] * 2, "other.csv 4"]
    assert [test.run for test in tested] == runs
    assert tested[0].number == "log.csv row 2"


def test_a_run_of_two_oils_is_named_by_file_and_row(tests):
    log = "run,oil,load [N],velocity [m/s],outcome\n1,A,400,2,mild\n1,B,500,2,mild\n"
    faults = tests(log, code=2)["faults"]
    assert any(one.startswith("log.csv, row 3, run: 1 has two oils") for one in faults)


def test_a_specimen_that_was_severe_at_an_easier_place_is_taken(tests):
    log = "run,load [N],velocity [m/s],outcome\n1,400,2,severe\n1,500,2,mild\n"
    assert [one["outcome"] for one in tests(log)["tests"]] == ["severe", "mild"]


def test_a_specimen_has_one_transition(tests):
    log = "Specimen,Critical load [N],Speed [m/s]\na,400,2\nb,600,1.5\n"
    document = tests(log)
    assert document["toml"].startswith("[[measured]]")
    assert [(one["load"], one["velocity"]) for one in document["tests"]] == [(400, 2), (600, 1.5)]
    (fault,) = tests(log + "b,700,1\n", code=2)["faults"]
    assert 'Specimen "b" has 2 transitions, and a specimen has one' in fault


def test_a_sheet_of_a_workbook_is_read_as_the_same_csv(tmp_path, irg):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Cover"
    book.active.append(["Scuffing tests of May"])
    log = book.create_sheet("Log")
    for row in ([], ["F_N/N", "v/(m/s)", "scuffed"], [400, 1.75, "no"], [500, 1.75, "yes"]):
        log.append(row)
    book.save(tmp_path / "log.xlsx")
    scene = SCENE.replace("log.csv", "log.xlsx")
    (tmp_path / "lab.toml").write_text(scene, encoding="utf-8")
    tested = pipeline.load_scene(tmp_path / "lab.toml").tests
    assert tested[1] == Measurement(400.0, 1.75, outcome="mild", number="row 3")
    document = irg("tests", tmp_path / "log.xlsx", "--sheet", "Log", "--json")
    assert [one["outcome"] for one in document["tests"]] == ["mild", "severe"]
    assert 'no sheet "Lag"; give one of Cover, Log' in irg(
        "tests", tmp_path / "log.xlsx", "--sheet", "Lag", code=2
    )


def test_what_is_understood_of_a_log_is_printed(tmp_path, irg):
    log = "Öl;Last [N];v [m/s];Befund;Prüfer\nA;400;2;ok;M\nA;500;2;Fresser;M\n"
    (tmp_path / "log.csv").write_text(log, encoding="utf-8")
    said = irg("tests", tmp_path / "log.csv").splitlines()
    assert said[0].endswith("log.csv: semicolons between cells, decimal points")
    table = [line.split("  ") for line in said[2:8]]
    assert [[cell.strip() for cell in row if cell] for row in table] == [
        ["column", "read as", "first cell"],
        ["Öl", "oil", "A"],
        ["Last [N]", "load", "400 N"],
        ["v [m/s]", "velocity", "2 m/s"],
        ["Befund", "outcome", "ok, mild"],
        ["Prüfer", "not used", "M"],
    ]
    tail = said[said.index("[[tested]]") :]
    columns = '{ load = "Last [N]", velocity = "v [m/s]", oil = "Öl", outcome = "Befund" }'
    assert tail[:3] == [
        "[[tested]]", f'file = {{ path = "log.csv", columns = {columns} }}',
        'words = { ok = "mild", Fresser = "severe" }',
    ]  # fmt: skip


def test_conditions_that_are_probably_in_another_unit_are_doubted(tests):
    log = "load [N],velocity [m/s],bulk temperature [degC],outcome\n400,1.2,333,mild\n"
    (doubt,) = tests(log)["doubts"]
    assert "the test of 400 N at 1.2 m/s: bulk temperature: 333 °C, where" in doubt


@pytest.mark.parametrize("unit", ["rpm", "1/min", "min^-1", "min⁻¹", "U/min", "rev/min", "Hz"])
def test_speeds_of_rotation_are_read_in_headings_cells_and_given(tests, unit):
    turns = 11.93662 if unit == "Hz" else 716.1972
    for head, row, more in (
        (f"rotation [{unit}],", f"{turns},", []),
        ("rotation,", f"{turns} {unit},", []),
        ("", "", ["--given", f"rotation={turns} {unit}"]),
    ):
        text = f"load [N],{head}outcome\n400,{row}mild\n"
        found = tests(text, "--given", "track_radius=20 mm", *more)
        assert contacts(found) == [(400, pytest.approx(1.5, rel=1e-6), "mild")]


def test_each_unknown_word_has_its_rows_and_no_outcome_is_proposed(tests):
    head = "load [N],velocity [m/s],outcome\n"
    faults = tests(f"{head}400,1,ok\n500,1,odd\n600,1,?\n700,1,odd\n", code=2)["faults"]
    assert [one.split(" is unknown")[0] for one in faults] == [
        'rows 3 and 5, outcome: "odd"', 'row 4, outcome: "?"',
    ]  # fmt: skip
    assert '--word "odd=mild" or --word "odd=severe"' in faults[0]


ALIKE = {
    "two of each": "Normal load [N],Fz [N],Ball speed [m/s],Speed set [m/s],Sliding speed [m/s],"
    "Oil temp [C],Bath temp [C],COF,Friction coefficient,Result,Pass\n"
    "400,401,2,2.1,2.2,60,61,0.1,0.11,ok,yes\n500,501,2,2.1,2.2,60,61,0.1,0.11,scuffed,no\n",
    "one letter each": "t;F;v;n;T;µ;i.O.\n0;400;2;100;60;0,1;ja\n1;500;2;100;60;0,1;nein\n",
    "without units": "Kraft,Last,Drehzahl,Gleitgeschwindigkeit,Öltemperatur,Reibwert,Befund\n"
    "400,401,100,2,60,0.1,gut\n500,501,100,2,60,0.1,Fresser\n",
    "two bodies": "Fn [N],Ball Speed [m/s],Disc Speed [m/s],Friction torque [N m],Track radius [mm]"
    ",Result\n400,0.5,1.5,0.8,20,ok\n500,0.5,1.5,1,20,scuffed\n",
}


def test_the_meaning_of_a_column_does_not_depend_on_the_hash_seed(tmp_path):
    for number, log in enumerate(ALIKE.values()):
        (tmp_path / f"{number}.csv").write_text(log)
    command = (
        "from pipeline.cli import main\n"
        f"for number in range({len(ALIKE)}):\n    main(['tests', f'{{number}}.csv', '--json'])"
    )
    ended = [
        python("-c", command, variables={"PYTHONHASHSEED": str(seed)}, cwd=tmp_path)
        for seed in range(3)
    ]
    assert ended[0].stdout.count('"columns"') == len(ALIKE), ended[0].stderr
    assert len({one.stdout for one in ended}) == 1

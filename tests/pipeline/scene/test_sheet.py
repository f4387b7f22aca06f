"""Tables of duties, rows of pairs and load records: each row and cell is used, named or refused."""

import numpy as np
import pytest

import pipeline
from pipeline.scene.along import OperatingPoints
from pipeline.scene.choices import Choices
from pipeline.sweep.plan import points
from tests.helpers import synthetic
from tests.helpers.scenes import SCENE
from tribo import InputError

DS = synthetic.sweep()
PLACES = [(300.0, 2.0), (400.0, 1.5), (650.0, 3.0)]


def judged(folder, content, name="duty.csv"):
    """Loads and velocities that `pipeline.margin` reads from a table of duties."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    frame = pipeline.margin(DS, path)
    return [*zip(frame["load [N]"], frame["velocity [m/s]"], strict=True)]


HEADS = "load [N],velocity [m/s]\n"
ROWS = "300,2\n400,1.5\n650,3\n"
DUTIES = {
    "plain": HEADS + ROWS,
    "bom": b"\xef\xbb\xbf" + (HEADS + ROWS).encode(),
    "utf-16": (HEADS + ROWS).encode("utf-16"),
    "utf-16 without a mark": (HEADS + ROWS).encode("utf-16-le"),
    "latin-1": ("Prüfling," + HEADS + "ä,300,2\nb,400,1.5\nc,650,3\n").encode("cp1252"),
    "crlf": (HEADS + ROWS).replace("\n", "\r\n"),
    "blank lines": (HEADS + ROWS).replace("\n", "\n\n\n"),
    "semicolons": (HEADS + ROWS).replace(",", ";"),
    "utf-16-be without a mark": (HEADS + ROWS).encode("utf-16-be"),
    "Shift-JIS": ("試験," + HEADS + "ア,300,2\nイ,400,1.5\nウ,650,3\n").encode("cp932"),
    "bars": (HEADS + ROWS).replace(",", " | "),
    "decimal commas": "load [N];velocity [m/s]\n300,0;2,0\n400,0;1,5\n650;3\n",
    "decimal commas in quotes": 'load [N],velocity [m/s]\n"300,0","2,0"\n"400","1,5"\n"650","3"\n',
    "thousands": "load [mN];velocity [mm/s]\n300'000;2'000.0\n400'000;1'500.0\n650'000;3'000.0\n",
    "kN in a slash": "load / kN,velocity / m/s\n0.3,2\n0.4,1.5\n0.65,3\n",
    "parentheses": "load (kN),velocity (mm/s)\n0.3,2000\n0.4,1500\n0.65,3000\n",
    "a unit of each cell": "load,velocity\n300 N,2 m/s\n0.4 kN,1500 mm/s\n650 N,3 m/s\n",
    "units below": "load,velocity\nkN,mm/s\n0.3,2000\n0.4,1500\n0.65,3000\n",
    "paths of a scene": "normal_load [N],sliding_velocity [m/s]\n" + ROWS,
    "a head": "Duty cycle of pump 7\nFrom: 3 May\n\n" + HEADS + ROWS,
    "a long head": "".join(f"line {k}: something, with commas\n" for k in range(30)) + HEADS + ROWS,
    "comments": "# duty, of pump 7\n" + HEADS + "300,2\n# then\n400,1.5\n650,3\n",
    "an index": ",load [N],velocity [m/s]\n0,300,2\n1,400,1.5\n2,650,3\n",
    "headings again": HEADS + "300,2\n" + HEADS + "400,1.5\n650,3\n",
    "powers of ten": HEADS + "3e2,2E0\n4.0e+02,1.5\n650,300e-2\n",
    "blanks": "# load [N] velocity [m/s]\n300 2\n400 1.5\n650 3\n",
    "numbers below a hash": "#;load;velocity\n;N;m/s\n1;300;2\n2;400;1,5\n3;650;3\n",
    "words of a laboratory": "Normalkraft F_N / N;Gleitgeschw. v in m/s\n300;2\n400;1,5\n650;3\n",
    "a track's diameter": "load [N],speed [rpm],diameter of track [mm]\n300,954.93,40\n"
    "400,716.197,40\n650,1432.39,40\n",
}  # fmt: skip


@pytest.mark.parametrize("name", DUTIES)
def test_duties_are_the_same_however_they_are_written(tmp_path, name):
    for one, right in zip(judged(tmp_path, DUTIES[name]), PLACES, strict=True):
        assert one == pytest.approx(right, rel=1e-5)


REST = {
    "at rest": ("0,0\n300,0\n", "5 rows: 3 used, 2 left out: rows 5 and 6 are at rest"),
    "no load": (",2\n", "4 rows: 3 used, 1 left out: row 5 has no load"),
    "no velocity": ("300,-\n", "4 rows: 3 used, 1 left out: row 5 has no velocity"),
    "words": ("mean,of all\n", "4 rows: 3 used, 1 left out: row 5 has no number"),
    "commented out": ("#300\n", "4 rows: 3 used, 1 left out: row 5 is commented out"),
    "the headings": (HEADS, "4 rows: 3 used, 1 left out: row 5 has the headings again"),
    "nan": ("NaN,nan\n", "4 rows: 3 used, 1 left out: row 5 has no number"),
}


@pytest.mark.parametrize("name", REST)
def test_rows_that_are_left_out_are_counted_in_the_first_line(tmp_path, irg, alone, name):
    rows, said = REST[name]
    (tmp_path / "duty.csv").write_text(HEADS + ROWS + rows)
    answer = irg("margin", alone, "--points", tmp_path / "duty.csv")
    assert said in answer.splitlines()[0]
    assert len(irg("margin", alone, "--points", tmp_path / "duty.csv", "--json")) == 3
    assert judged(tmp_path, HEADS + ROWS + rows) == PLACES


def test_a_table_without_such_rows_says_nothing_of_them(tmp_path, irg, alone):
    (tmp_path / "duty.csv").write_text(HEADS + ROWS)
    assert irg("margin", alone, "--points", tmp_path / "duty.csv").startswith("3 operating")


def test_rows_whose_label_begins_with_a_hash_are_rows(tmp_path):
    rows = "name,load [N],velocity [m/s]\n#1,300,2\n#2,400,1.5\npump,650,3\n"
    assert judged(tmp_path, rows) == PLACES


def test_formulas_and_errors_of_a_workbook_count_where_the_column_is_used(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")

    def book(*rows):
        made = openpyxl.Workbook()
        for row in rows:
            made.active.append(row)
        made.save(tmp_path / "duty.xlsx")
        return (tmp_path / "duty.xlsx").read_bytes()

    heads = ["load [N]", "velocity [m/s]", "note"]
    for error in ("#DIV/0!", "#N/A", "#REF!", "#VALUE!", "#NAME?", "#NULL!", "#NUM!"):
        rows = heads, [300, 2, error]
        assert judged(tmp_path, book(*rows), "duty.xlsx") == [(300, 2)]
        with pytest.raises(InputError, match=f"row 2, load: .*{error[:4]}"):
            judged(tmp_path, book(heads, [error, 2, "a"]), "duty.xlsx")
    with pytest.raises(InputError, match=r"row 2, load: .*=A9.* without a stored value"):
        judged(tmp_path, book(heads, ["=A9+1", 2, "a"]), "duty.xlsx")
    assert judged(tmp_path, book(heads, [300, 2, "=A9"]), "duty.xlsx") == [(300, 2)]


def test_a_sheet_of_a_workbook_is_found_and_the_others_are_told(tmp_path, irg, alone):
    openpyxl = pytest.importorskip("openpyxl")
    made = openpyxl.Workbook()
    made.active.append(["Pump 7"])
    for name, loads in (("Duty", [300, 400]), ("Other duty", [500])):
        sheet = made.create_sheet(name)
        sheet.append(["load [N]", "velocity [m/s]"])
        for load in loads:
            sheet.append([load, 2])
    made.save(tmp_path / "duty.xlsx")
    said = irg("margin", alone, "--points", tmp_path / "duty.xlsx")
    assert 'sheet "Duty" (not read: Sheet, Other duty; --sheet names another)' in said
    named = ["--points", tmp_path / "duty.xlsx", "--sheet", "Other duty"]
    assert [row["load [N]"] for row in irg("margin", alone, *named, "--json")] == [500]


def test_columns_of_python_are_rows_with_units_or_in_si():
    frame = pipeline.margin(DS, {"load": [300.0, 400.0], "velocity [m/min]": [120, 90]})
    assert [*zip(frame["load [N]"], frame["velocity [m/s]"], strict=True)] == PLACES[:2]
    rest = pipeline.margin(DS, {"load": [300.0, 0.0, np.nan], "velocity": [2.0, 1.0, 1.0]})
    assert rest["load [N]"].tolist() == [300.0]
    with pytest.raises(InputError, match="columns of unlike lengths: load 2, velocity 1"):
        pipeline.margin(DS, {"load": [300.0, 400.0], "velocity": [2.0]})


# Load records


def record(folder, text, more="reference_load = '250 N'\n"):
    folder.joinpath("rec.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    scene = f'extends = "first_try"\nwithout = ["loading"]\n[loading]\nfile = "rec.csv"\n{more}'
    folder.joinpath("rec.toml").write_text(scene)
    return pipeline.load_scene(folder / "rec.toml")


RECORDS = {
    "plain": "time [s],normal load [N]\n0,0\n0.5,100\n1.5,300\n",
    "other units": "F (kN), t (ms)\n0, 0\n0.1, 500\n0.3, 1500\n",
    "a head": "# rig 3\n\ntime [min],load [N]\n0,0\n\n0.00833333333333333,100\n0.025,300\n",
    "crlf": "\ufefftime [s],load [N]\r\n0,0\r\n0.5,1e2\r\n1.5,3e2\r\n",
    "german": "Zeit [s];Last [kgf]\n0;0\n0,5;10,1971621\n1,5;30,5914864\n",
    "a clock": "time;load [N]\n10:00:00.0;0\n10:00:00.5;100\n10:00:01.5;300\n",
    "another zone": "time;load [N]\n2026-03-04T10:00:00Z;0\n2026-03-04T10:00:00.5Z;100\n"
    "2026-03-04T10:00:01.5Z;300\n",
    "three columns": "time [s],load [N],friction force [N]\n0,0,0\n0.5,100,9\n1.5,300,31\n",
    "slash": "time/s,load/N\n0,0\n0.5,100\n1.5,300\n",
}


@pytest.mark.parametrize("name", RECORDS)
def test_a_load_record_is_read_as_duties_are(tmp_path, name):
    loading = record(tmp_path, RECORDS[name]).scene.loading
    assert loading.times == pytest.approx([0.0, 0.5, 1.5])
    assert loading.loads == pytest.approx([0.0, 100.0, 300.0])
    assert loading.peak == 250.0


def test_a_scene_says_how_a_record_is_read(tmp_path):
    chosen = 'file = { path = "rec.csv", columns = { load = "x [kN]" }, decimal = "," }'
    (tmp_path / "rec.csv").write_text("time [s];x;load\n0;0;9\n0,5;0,100;9\n1,500;0,300;9\n")
    scene = f'extends = "first_try"\nwithout = ["loading"]\n[loading]\n{chosen}\n'
    (tmp_path / "rec.toml").write_text(scene)
    loading = pipeline.load_scene(tmp_path / "rec.toml").scene.loading
    assert loading.loads == pytest.approx([0.0, 100.0, 300.0])
    (tmp_path / "rec.toml").write_text(scene.replace("x [kN]", "y"))
    with pytest.raises(pipeline.SceneFileError, match='no column "y"'):
        pipeline.load_scene(tmp_path / "rec.toml")


def test_rows_of_a_record_without_a_load_are_told(tmp_path):
    notes = record(tmp_path, RECORDS["plain"] + "2,\n").notes
    said = [note.words for note in notes if note.place == "loading.file"]
    assert "4 rows: 3 used, 1 left out: row 5 has no load" in said


# Rows of pairs


def along(folder, rows):
    (folder / "mesh.csv").write_text(rows)
    text = SCENE.replace("[sweep]", '[sweep]\nalong = "mesh.csv"')
    (folder / "scene.toml").write_text(text)
    return pipeline.load_scene(folder / "scene.toml")


def test_rows_of_pairs_that_rest_are_left_out_and_told(tmp_path):
    head = "flank;pin.radius [mm];load [N];velocity [m/s]\n"
    sweep = along(tmp_path, head + "root;3,0;300;1\npitch;3,5;300;0\ntip;4,0;600;2\n")
    assert [(one.load, one.velocity) for one in points(sweep)] == [(300.0, 1.0), (600.0, 2.0)]
    said = [note.words for note in sweep.notes if note.place == "sweep.along"]
    assert said == ["mesh.csv, 3 rows: 2 used, 1 left out: row 3 is at rest"]


NUMBERS = {
    "thousands of points": ("1.200;1.500", ",", (1200.0, 1500.0)),
    "decimals of points": ("1.200;1.500", ".", (1.2, 1.5)),
    "a comma elsewhere": ("1.200;0,5", None, (1200.0, 0.5)),
    "a point elsewhere": ("1,200;0.5", None, (1200.0, 0.5)),
    "thousands twice": ("1.200.000;1.500", None, (1.2e6, 1500.0)),
    "both marks": ("1.200,5;1.500", None, (1200.5, 1500.0)),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_with_two_readings_is_decided_by_another_cell_or_by_the_user(tmp_path, name):
    row, decimal, right = NUMBERS[name]
    path = tmp_path / "duty.csv"
    path.write_text(f"load [N];velocity [m/s]\n{row}\n")
    assert OperatingPoints.read(path, Choices(decimal=decimal)).places == (right,)


@pytest.mark.parametrize("text", ["1.200;1.500", '"1,200","1,500"'])
def test_a_number_with_two_readings_is_asked_for(tmp_path, text):
    path = tmp_path / "duty.csv"
    between = ";" if ";" in text else ","
    path.write_text(f"load [N]{between}velocity [m/s]\n{text}\n")
    with pytest.raises(InputError, match=r'is 1200 or 1.200; say decimal="." or decimal=","'):
        OperatingPoints.read(path)


def test_columns_of_numbers_in_python_have_one_reading():
    read = OperatingPoints.read({"load": [1.125], "velocity": ["1.250 m/s"]})
    assert read.places == ((1.125, 1.25),)
    with pytest.raises(InputError, match=r"1200 N or 1.200 N"):
        OperatingPoints.read({"load": ["1,200 N"], "velocity": ["2 m/s"]})


def test_a_thousand_faults_of_one_kind_are_one_line(tmp_path):
    path = tmp_path / "duty.csv"
    path.write_text("load [N],velocity [m/s]\n" + "300,2,7\n" * 1000)
    with pytest.raises(InputError) as raised:
        OperatingPoints.read(path)
    assert str(raised.value).endswith(
        "rows 2, 3, 4, 5, 6, 7 and 994 more: 3 cells below 2 headings"
    )


def test_columns_rows_and_units_are_chosen(tmp_path):
    text = "Fn;v;use\n1.200;1,5;y\n1.300;1,6;n\n"
    (tmp_path / "duty.csv").write_text(text)
    columns = {"load": "Fn [N]", "velocity": "v [m/s]"}
    read = OperatingPoints.read(tmp_path / "duty.csv", Choices(columns=columns, skip={"use": "n"}))
    assert read.places == ((1200.0, 1.5),)
    assert read.counted == "2 rows: 1 used, 1 left out: row 3 has use n"


KINDS = {
    b"\xd0\xcf\x11\xe0" + bytes(600): "protected with a password, or an old .xls",
    b"\x1f\x8b\x08" + bytes(20): "a .gz archive", b'[{"load": 300}]': "JSON",
    b"MATLAB 5.0 MAT-file": "a .mat file of MATLAB", bytes(range(256)) * 9: "binary",
}  # fmt: skip


@pytest.mark.parametrize("content", KINDS)
def test_what_is_no_table_is_named_by_its_content(tmp_path, content):
    (tmp_path / "duty.csv").write_bytes(content)
    with pytest.raises(InputError, match=f"is {KINDS[content]}; save the table as"):
        OperatingPoints.read(tmp_path / "duty.csv")

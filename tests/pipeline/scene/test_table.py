"""Tables are read completely, or refused with the row and column of the fault."""

import pandas as pd
import pytest
import xarray as xr

from pipeline.condition_kinds import OperatingPoints
from pipeline.faults import Faults
from pipeline.scene import format as scene_format
from pipeline.scene.table_kinds import TableKind
from pipeline.table import read_table
from tests.helpers.kept import assert_as_kept, refusal, relative
from tribo import InputError

TEST = TableKind(scene_format.Test)
HEADS = "load [N],velocity [m/s]"


def faults_in(row):
    TEST.read(row, "", faults := Faults())
    return faults


def points(tmp_path, text, decimal=None, encoding="utf-8", ignore=()):
    (tmp_path / "a.csv").write_text(text, encoding=encoding)
    return OperatingPoints.read(tmp_path / "a.csv", decimal, ignore)


@pytest.mark.parametrize(
    ("text", "decimal"),
    [
        (f"{HEADS}\n300,1.5\n", None),
        (f"name,{HEADS}\n#4,300,1.5\n", "."),
        (f"{HEADS};note\n300;1.500;a\n".replace(",", ";"), "."),
        ("load;velocity\n300 N;1,500 m/s\n", ","),
        (f"# rig 4\n\n{HEADS}\n300,1.5\n,\n", "."),
        (f"{HEADS},\n300,1.5,\n", "."),
        ("Load [kN];Velocity [mm/s]\n0,3;1500,0\n", ","),
        ("load\tvelocity\n300 N\t1.5 m/s\n", "."),
        (f'{HEADS},"name, date"\n300,1.5,"a #3, today"\n', "."),
    ],
)
def test_clean_tables_are_read(tmp_path, text, decimal):
    assert points(tmp_path, text, decimal).columns == {"load": [300.0], "velocity": [1.5]}


def test_a_table_of_western_excel_is_read(tmp_path):
    text = "load [N];velocity [m/s];bulk temperature [°C]\n300;1.5;60\n"
    table = points(tmp_path, text, encoding="cp1252")
    assert table.columns["bulk_temperature"] == [333.15]


REFUSED = [
    f"{HEADS}\n300,1,5\n",
    f"{HEADS},friction\n300,1.5\n",
    f"{HEADS},load [kN]\n300,1.5,2\n",
    f"{HEADS}\n300,1.5\n# later,\n",
    f"{HEADS},mue\n300,1.5,0.2\n",
    f"{HEADS},friction,friction.coefficient\n300,1.5,0.1,0.2\n",
    f"{HEADS},motion.slide_roll_ratio\n300,1.5,0.1\n",
    "load [N];velocity [mm/s]\n1.200;1.500\n",
    f'{HEADS}\n300,"1.5\n',
    f"{HEADS}\n300,1.\0005\n",
    f"Rig 3\n{HEADS}\n300,1.5\n",
    f"{HEADS}\n300,1.5,2\n-1,2\n",
    f"{HEADS},COF\n300,1.5,0.1\n",
    "load [N],speed [m/s]\n300,1.5\n",
    "load [N],velocty [m/s]\n300,1.5\n",
    f"{HEADS},surface speed [m/s]\n300,1.5,3\n",
    "load (rig 3),velocity [m/s]\n300,1.5\n",
    f"{HEADS},Date\n300,1.5,2026-10-01\n",
    f"{HEADS},Day\n300,1.5,1.10.2026\n",
    f'{HEADS}\n"1,200",1.5\n',
    "PK\x03\x04\x00\x00xl/workbook.xml",
    HEADS,
    "\x00\x01\x02\x03" * 99,
    f"{HEADS}{',a' * 999}\n300,1.5{',b' * 999}\n",
    f"{HEADS},{'long ' * 50}\n300,1.5,a\n",
]


LOADS, VELOCITIES = {"load [N]": [300.0, 400.0]}, {"velocity [m/s]": [1.5, 2.5]}
OBJECTS = {
    "an index": pd.DataFrame(LOADS | VELOCITIES, index=pd.Index(["a", "b"], name="case")),
    "a dataset": xr.Dataset(),
    "a single value": LOADS | {"velocity [m/s]": 1.5},
    "columns of unlike lengths": LOADS | {"velocity [m/s]": [1.5]},
    "a column without a heading": LOADS | VELOCITIES | {" ": [1.0, 2.0]},
    "a heading twice": LOADS | VELOCITIES | {"load [kN]": [0.3, 0.4]},
    "no value": LOADS | {"velocity [m/s]": [1.5, None]},
    "an array in a cell": LOADS | {"velocity [m/s]": [[1.5], 2.5]},
    "many faults": {"load [N]": ["1,200"] * 12 + ["-3"], "velocity [m/s]": [1.0] * 13},
}


def test_objects_are_refused_as_tables_in_words_that_are_kept():
    texts = {name: refusal(OperatingPoints.read, table) for name, table in OBJECTS.items()}
    assert_as_kept("refusals_of_objects", texts)


def test_others_are_refused_with_row_and_column_in_words_that_are_kept(tmp_path):
    texts = {
        f"{number}: {text!r:.60}": relative(refusal(points, tmp_path, text), tmp_path)
        for number, text in enumerate(REFUSED)
    }
    commas, other = "load [N];velocity [m/s]\n1.250;1,5\n", f"{HEADS}\n300,1.5\n"
    texts["a point where decimals have commas"] = refusal(points, tmp_path, commas, ",")
    texts["a column that is not there"] = refusal(points, tmp_path, other, ".", "utf-8", ["COF"])
    texts = {name: relative(text, tmp_path) for name, text in texts.items()}
    assert_as_kept("refusals_of_tables", texts)


def test_columns_without_a_meaning_are_named_once(tmp_path):
    text = f"date,{HEADS},Temp [degC]\n2026-05-01,300,1.5,90\n"
    table = points(tmp_path, text, ignore=["Date", "temp"])
    assert table == ({"load": [300.0], "velocity": [1.5]}, {})
    with pytest.raises(InputError, match='no column "dat" to ignore in "date", "load'):
        points(tmp_path, text, ignore=["dat", "temp"])


def test_a_column_that_is_no_entry_of_a_test_has_words_or_is_refused():
    table = {"load [N]": [300.0], "velocity [m/s]": [1.5], "outcome": ["mild"], "remark": [2.5]}
    with pytest.raises(InputError, match=r'"remark" has numbers .*; rename it to one of velocity'):
        read_table(table, 9).rows(TEST.keys, faults_in)
    for number in ("−3", "\xa03", "~ 3", "HRC 62"):
        table["remark"] = [number]
        with pytest.raises(InputError, match='"remark" has numbers'):
            read_table(table, 9).rows(TEST.keys, faults_in)
    table["remark"] = ["a"]
    (row,) = read_table(table, 9).rows(TEST.keys, faults_in)
    assert row == {"load": "300.0 N", "velocity": "1.5 m/s", "outcome": "mild"}

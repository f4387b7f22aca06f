"""Load records from files."""

import pytest

from pipeline.scene.load_record import read_load
from tribo import InputError


@pytest.mark.parametrize(
    "text",
    [
        "time [s],normal load [N]\n0,0\n0.5,100\n1.5,300\n",
        "F (kN), t (ms)\n0, 0\n0.1, 500\n0.3, 1500\n",
        "# rig 3\n\ntime [min],load [N]\n0,0\n\n0.00833333333333333,100\n0.025,300\n",
        "\ufefftime [s],load [N]\r\n0,0\r\n0.5,1e2\r\n1.5,3e2\r\n",
    ],
)
def test_a_record_is_read_with_its_units(tmp_path, text):
    path = tmp_path / "load.csv"
    path.write_text(text, encoding="utf-8")
    record = read_load(path, reference_load=250.0)
    assert record.times == pytest.approx([0.0, 0.5, 1.5])
    assert record.loads == pytest.approx([0.0, 100.0, 300.0])
    assert record.peak == 250.0


def test_a_record_of_more_than_a_million_rows_is_refused(tmp_path):
    path = tmp_path / "long.csv"
    path.write_text("time [s],load [N]\n" + "0,0\n" * (10**6 + 1))
    with pytest.raises(InputError, match="line 1000002: more than 1000000 rows"):
        read_load(path)

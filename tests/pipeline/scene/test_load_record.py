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


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"time [s],load [N]\n0,0\n", "1 rows"),
        (b"0,0\n1,5\n", "line 1: the header is '0,0'"),
        (b"time [s],load [N]\n0,0\n1,5,6\n", "line 3: 3 columns"),
        (b"time [s],load [N]\n0,0\n1,five\n", "line 3: could not convert"),
        (b"time [s],load [N]\n0,0\n\n1,nan\n", "line 4: 1 s, nan N; both must be finite"),
        (b"time [s],load [N]\n0,0\n2,5\n# pause\n1,6\n", "line 5: time 1 s after 2 s"),
        (b"time [s];load [N]\n0;0\n1;5\n", "1 columns.*in place of semicolons"),
        ("time [s], load [N]\n0,0\n".encode("utf-16"), "UTF-8"),
        (b"time [s], load [N]\n0," + b"9" * 200_000, "field larger than"),
        (b"time [s],load [N]\n0,7\n1,5\n", "begins at 7 N"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(tmp_path, content, said):
    path = tmp_path / "load.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=said) as caught:
        read_load(path)
    assert str(path) in str(caught.value)


def test_records_that_cannot_be_read_are_named(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="cannot be read"):
        read_load(tmp_path / "missing.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_load(tmp_path)
    path = tmp_path / "long.csv"
    path.write_text("time [s],load [N]\n" + "".join(f"{n},{n}\n" for n in range(12)))
    monkeypatch.setattr("pipeline.scene.load_record._MOST_ROWS", 10)
    with pytest.raises(InputError, match="line 12: more than 10 rows"):
        read_load(path)

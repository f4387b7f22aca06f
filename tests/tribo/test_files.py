"""Surfaces and load records from files (tribo/files.py)."""

import io

import numpy as np
import pytest

from tribo import InputError, read_heights, read_load


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_measured_heights_are_read_in_their_unit(tmp_path, suffix):
    path = tmp_path / f"disk{suffix}"
    heights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]])
    np.save(path, heights) if suffix == ".npy" else np.savetxt(path, heights, delimiter=",")
    assert read_heights(path, unit=1e-6) == pytest.approx(heights * 1e-6)


def header(shape):
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    return b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little") + text.ljust(117).encode() + b"\n"


def saved(save, **array):
    buffer = io.BytesIO()
    save(buffer, **array)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", b"1,2\n3,x\n", "line 2"),
        ("a.csv", b"1,2\n3\n", "line 2.*1 numbers"),
        ("a.csv", b"1,2\n3,nan\n", "row 1, column 1"),
        ("a.csv", b"1;2;3" * 999, "; put commas between numbers, in place of semicolons$"),
        ("a.csv", b"1,5;2,5\n3,5;4,5\n", "of semicolons, and write decimals with a point"),
        ("a.csv", b"1\t2\n3\t4\n", "in place of tabs"),
        ("a.csv", b"x,y\n1,2\n", "leave a header out"),
        ("a.csv", b"", "two-dimensional"),
        ("a.csv", b"1," + b"9" * 200_000, "field larger than"),
        ("a.csv", b"1,2\n3,\x00\n", "line 2"),
        ("a.csv", "1,2\n3,4\n".encode("utf-16"), "utf-8"),
        ("a.npy", None, "cannot be read"),
        ("a.npy", saved(np.savez, heights=np.ones((2, 2))), "does not begin as NumPy"),
        ("a.npy", saved(np.save, arr=np.array([["a"]])), "real numbers"),
        ("a.npy", header("(10000000, 10000000)"), "more than there is memory"),
        ("a.npy", header("(3, 3)") + b"12345678", "not a plain array"),
        ("a.npy", header("(0, 5)"), r"shape \(0, 5\)"),
        ("a.txt", b"1", r"use \.npy or \.csv"),
    ],
)
def test_what_is_no_surface_is_refused_with_its_place(tmp_path, name, content, said):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=said) as caught:
        read_heights(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 400 + len(str(path))


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
        (b"", "0 rows"),
        (b"time [s],load [N]\n0,0\n", "1 rows"),
        (b"0,0\n1,5\n", "line 1: the header is '0,0'"),
        (b"time [s],load [lbf]\n0,0\n1,5\n", "line 1: the header"),
        (b"time [s],load [N]\n0,0\n1,5,6\n", "line 3: 3 columns"),
        (b"time [s],load [N]\n0,0\n1,five\n", "line 3: could not convert"),
        (b"time [s],load [N]\n0,0\n\n1,nan\n", "line 4: 1 s, nan N; both must be finite"),
        (b"time [s],load [N]\n0,0\n2,5\n# pause\n1,6\n", "line 5: time 1 s after 2 s"),
        (b"time [s];load [N]\n0;0\n1;5\n", "1 columns.*in place of semicolons"),
        (b"time [s],load [N]\n0,0,0,0\n", "4 columns.*write decimals with a point"),
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
    monkeypatch.setattr("tribo.files._MOST_ROWS", 10)
    with pytest.raises(InputError, match="line 12: more than 10 rows"):
        read_load(path)

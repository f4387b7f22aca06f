"""Surfaces from files (pipeline/scene/height_file.py)."""

import io

import numpy as np
import pytest

from pipeline.scene.height_file import read_heights
from tribo import InputError


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_measured_heights_are_read_in_their_unit_with_x_from_column_to_column(tmp_path, suffix):
    path = tmp_path / f"disk{suffix}"
    heights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]])
    if suffix == ".npy":
        np.save(path, heights)
    else:
        path.write_bytes(b"\xef\xbb\xbf1,2,3\n4,5,6.5\n")  # with a byte order mark
    assert read_heights(path, unit=1e-6) == pytest.approx(heights.T * 1e-6)


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

"""Files of heights are read with their units, or refused with a message."""

import io
import zipfile

import numpy as np
import pytest

from pipeline.surface.scan import read_scan
from tests.helpers.instruments import al3d, gwy, sur, x3p
from tribo import InputError

HEIGHTS = np.random.default_rng(5).normal(0.0, 0.3, (48, 40))  # µm
SIDES = 0.8e-6, 0.95e-6
X = 0.5 * np.arange(600)


def read(path, **options):
    return read_scan(path, 1e-6, SIDES, **options)


@pytest.mark.parametrize("ending", ["npy", "csv", "txt", "tsv", "trailing"])
def test_x_goes_from_column_to_column_of_a_matrix(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    holed = HEIGHTS.copy()
    holed[3, 5] = np.nan
    marks = {"csv": ",", "tsv": "\t", "trailing": ";"}
    if ending == "npy":
        np.save(path, holed.T)
    else:
        mark = marks.get(ending, " ")
        hole = "nan" if ending == "txt" else ""
        rows = (mark.join(hole if np.isnan(z) else f"{z:.9g}" for z in row) for row in holed.T)
        path.write_text("".join(f"{row}{mark * (ending == 'trailing')}\n" for row in rows))
    scan = read(path)
    np.testing.assert_allclose(scan.heights, 1e-6 * holed, rtol=1e-8)
    assert (scan.pixel_size, scan.missing) == (SIDES, 1)


def points():
    x, y = np.divmod(np.arange(4800.0), 60)
    return np.stack([x, y, np.sin(x)], axis=1)


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        (np.sin(X), "no map of heights, but maybe a profile"),
        (np.stack([X, np.sin(X)], axis=1), "no map of heights"),
        (points(), "or a list of points"),
        (np.vstack([np.arange(40), HEIGHTS]), "the first row rises evenly"),
        (np.column_stack([np.arange(48), HEIGHTS]), "the first column rises evenly"),
    ],
)
def test_what_is_no_map_is_refused_by_its_name(tmp_path, table, kind):
    np.save(tmp_path / "a.npy", table)
    np.savetxt(tmp_path / "a.csv", np.atleast_2d(table), delimiter=",")
    for name in ("a.npy", "a.csv"):
        with pytest.raises(InputError, match=kind):
            read(tmp_path / name)


def test_marks_of_missing_heights_are_holes_and_told(tmp_path):
    marked = HEIGHTS.copy()
    marked[::7, 3], marked[5, ::9], marked[1, 1] = -9999, 99999, np.inf
    np.save(tmp_path / "a.npy", marked.T)
    scan = read(tmp_path / "a.npy")
    assert scan.missing == 7 + 5 + 1
    assert "7 heights of -9999 are treated as missing" in scan.notes
    zeros = HEIGHTS.copy()
    zeros[:10] = 0.0
    np.save(tmp_path / "b.npy", zeros.T)
    assert "are exactly 0: write nan" in read(tmp_path / "b.npy").notes[-1]


def test_units_and_sizes_are_given_or_asked_for(tmp_path):
    np.save(tmp_path / "a.npy", 10 * HEIGHTS)
    with pytest.raises(InputError) as error:
        read_scan(tmp_path / "a.npy")
    assert str(error.value) == (
        f"{tmp_path / 'a.npy'}: the file does not have the unit of its heights (height_unit) and "
        "the sides of a pixel (pixel_size); add what is missing"
    )
    with pytest.raises(InputError, match=r"heights of .* m; give the right unit"):
        read_scan(tmp_path / "a.npy", 1.0, SIDES)


ROWS = "\n".join(" ".join(f"{z:.4f}" for z in row) for row in HEIGHTS.T)


def zipped(name, content=b""):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(name, content)
    return packed.getvalue()


def test_a_minus_sign_of_print_is_a_minus(tmp_path):
    (tmp_path / "a.txt").write_text(ROWS.replace("-", "−"), encoding="utf-8")
    (tmp_path / "b.txt").write_text(ROWS)
    printed, plain = (read(tmp_path / name).heights for name in ("a.txt", "b.txt"))
    np.testing.assert_array_equal(printed, plain)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (
            f"ncols 48\ncellsize 0.5\n{ROWS}".encode(),
            "its rows have 2, 48 numbers; give one matrix, without headings",
        ),
        (b"1,2,3\n1,2\n", "its rows have 3, 2 numbers"),
        (ROWS.replace(".", ",").replace(" ", ";").encode(), "and decimals with points"),
        (b"-0,1234,0,2345\n" * 20, "is no whole number"),
        (b"no numbers at all\n", "not a matrix of numbers"),
        (b"\x93NUMPY\x01", "not a plain array"),
        (b"\x89PNG" + bytes(9), "SurfaceTopography cannot read it"),
        (zipped("main.xml", b"<p/>"), "SurfaceTopography cannot read it"),
        (b"", "its rows have no numbers"),
    ],
)
def test_other_files_are_refused_with_help(tmp_path, content, why):
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "a.txt").write_bytes(content)
    with pytest.raises(InputError, match=why):
        read(tmp_path / "a.txt")


# Files of instruments, as tests.helpers.instruments writes them.

METRES = 1e-6 * HEIGHTS
HOLED = np.where(np.random.default_rng(6).random(METRES.shape) < 0.1, np.nan, METRES)

FILES = {
    # By file name: its content, and the tolerance of the heights.
    "matrix.x3p": (x3p(HOLED, SIDES), 0),
    "integers.x3p": (x3p(HOLED, SIDES, dtype="L"), 0.5e-9),
    "a.gwy": (gwy([("z", HOLED, "m")], SIDES), 0),
    "second.gwy": (gwy([("phase", METRES * 1e6, "deg"), ("z", HOLED, "m")], SIDES), 0),
    "plain.sur": (sur(HOLED, SIDES), 1e-13),
    "a.al3d": (al3d(HOLED, SIDES), 1e-13),
}


@pytest.mark.parametrize("name", FILES)
def test_an_instrument_s_heights_come_out_with_holes_and_pixels(tmp_path, name):
    pytest.importorskip("SurfaceTopography")
    content, tolerance = FILES[name]
    (tmp_path / name).write_bytes(content)
    surface = read_scan(tmp_path / name)
    np.testing.assert_allclose(surface.heights, HOLED, rtol=1e-12, atol=tolerance)
    assert surface.pixel_size == pytest.approx(SIDES, rel=1e-6)


def test_the_unit_given_counts_for_heights_and_not_for_pixels(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "a.x3p"
    path.write_bytes(x3p(METRES, SIDES))
    surface = read_scan(path, 1e-6)
    np.testing.assert_allclose(surface.heights, 1e-6 * METRES, rtol=1e-12)
    assert surface.pixel_size == pytest.approx(SIDES)
    assert "the given height unit, 1e-06 m, replaces the file's, 1 m" in surface.notes[-1]

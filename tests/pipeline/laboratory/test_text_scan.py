"""Heights in text come out the same, however a program writes them."""

import io

import numpy as np
import pytest

from pipeline.laboratory.surfaces import read_surface

HEIGHTS = (
    np.arange(20.0).reshape(4, 5) + 0.25
)  # [µm], along x and then y, a column of a file each x
ROWS = HEIGHTS.T


def saved(heights, **form):
    text = io.StringIO()
    np.savetxt(text, heights, **form)
    return text.getvalue()


def places(unit=1.0, separator="\t"):
    x, y = np.indices(HEIGHTS.shape)
    rows = zip(x.T.ravel() * unit, y.T.ravel() * unit, HEIGHTS.T.ravel(), strict=True)
    return "".join(separator.join(f"{value:.6g}" for value in row) + "\n" for row in rows)


def quoted(rows):
    return "".join(",".join(f'"{height:.2f}"' for height in row) + "\n" for row in rows)


GWYDDION = "# Channel: Height\n# Width: 4.00 µm\n# Height: 5.00 µm\n# Value units: µm\n"
TEXTS = {
    "savetxt.txt": saved(ROWS, header="heights"),
    "tabs.asc": "Messung 3\n" + saved(ROWS, delimiter="\t").replace("\n", "\t\n"),
    "semicolons.csv": saved(ROWS, delimiter=";"),
    "german.csv": saved(ROWS, delimiter=";").replace(".", ","),
    "comments.csv": "# a scan\n" + saved(ROWS, delimiter=","),
    "indented.csv": " " + saved(ROWS, fmt="%.2f", delimiter=",").replace("\n", "\n ").rstrip(" "),
    "blanks.txt": saved(ROWS, fmt="%.3f").replace(".", ","),
    "gwyddion.txt": GWYDDION + saved(ROWS, delimiter="\t"),
    "gwyddion.xyz": places(),
    "mountains.txt": "X [mm];Y [mm];Z [µm]\n" + places(1e-3, ";").replace(".", ","),
    "mountains_matrix.txt": "Taille X\t4 µm\nTaille Y\t5 µm\nUnité Z\tµm\n"
    + saved(ROWS, delimiter="\t").replace(".", ","),
    "spacings.csv": "# z in µm, dx = 1.0 µm, dy = 1.0 µm\n" + saved(ROWS, delimiter=","),
    "gwyddion_quoted.txt": GWYDDION.replace("# ", "") + saved(ROWS, delimiter=", "),
    "pixel_size.txt": "# pixel size: 1.0 um\n# z in um\n" + saved(ROWS),
    "pixel_size_both.csv": "Pixel size X;1,0 µm\nPixel size Y;1,0 µm\nZ unit;µm\n"
    + saved(ROWS, delimiter=";").replace(".", ","),
    "mountains_km.txt": "X-Axis Length [mm]: 0.004\nY-Axis Length [mm]: 0.005\nZ unit: um\n"
    + saved(ROWS, delimiter="\t"),
    "crlf.csv": ("# a scan\n" + saved(ROWS, delimiter=",")).replace("\n", "\r\n"),
    "trailing.csv": saved(ROWS, delimiter=";").replace("\n", ";\n"),
    "keyence.csv": '"XY calibration","1000.0","nm"\n"Unit","um"\n"Height"\n' + quoted(ROWS),
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_matrix_or_rows_of_places_give_the_same_heights(name, tmp_path):
    (tmp_path / name).write_text(TEXTS[name], encoding="utf-8")
    surface = read_surface(tmp_path / name, 1e-6)
    np.testing.assert_allclose(surface.heights, 1e-6 * HEIGHTS, rtol=1e-6)


SAID = {"gwyddion.txt": "utf-8", "mountains.txt": "utf-16", "mountains_matrix.txt": "latin-1"}


KNOWN = "spacings.csv", "keyence.csv", "pixel_size.txt", "pixel_size_both.csv", "mountains_km.txt"


@pytest.mark.parametrize("name", [*SAID, *KNOWN])
def test_sizes_and_units_are_taken_from_the_text(name, tmp_path):
    (tmp_path / name).write_text(TEXTS[name], encoding=SAID.get(name, "utf-8"))
    surface = read_surface(tmp_path / name)
    assert surface.pixel_size == pytest.approx((1e-6, 1e-6))
    assert surface.heights[0, 0] == pytest.approx(0.25e-6)


@pytest.mark.parametrize(
    ("corner", "shape"),
    [("y\\\\x [um]", (6, 5)), ("y\\\\x [um]", (5, 4)), ("0", (6, 5)), ("0", (4, 4))],
)
def test_places_beside_and_above_a_matrix_are_no_heights(shape, corner, tmp_path):
    rough = np.random.default_rng(0).normal(size=shape)
    lines = [",".join([corner, *(f"{1.2 * k:.2f}" for k in range(shape[1]))])]
    lines += [",".join(map(str, [float(k), *row])) for k, row in enumerate(rough)]
    (tmp_path / "scan.csv").write_text("\n".join(lines))
    surface = read_surface(tmp_path / "scan.csv", 1e-6)
    np.testing.assert_allclose(surface.heights, 1e-6 * rough.T)
    assert surface.pixel_size == (pytest.approx((1.2e-6, 1e-6)) if corner != "0" else None)


@pytest.mark.parametrize("word", ["-9999", "-3.4028235e+38"])
def test_the_word_of_a_file_for_a_hole_is_taken(word, tmp_path):
    text = f"ncols 3\nNODATA_value {word}\n1 2 3\n4 {word} 6\n7 8 9\n"
    (tmp_path / "scan.asc").write_text(text)
    heights = read_surface(tmp_path / "scan.asc", 1.0).heights
    assert np.argwhere(np.isnan(heights)).tolist() == [[1, 1]]


@pytest.mark.parametrize(
    "text",
    [
        "1;2;3\n4;;6\n7;8;\n", "1,2,3\n4,NaN,6\n7,8,nan\n", "1 2 3\n4 *** 6\n7 8 BAD\n",
        "1 2 3\n4 No Data 6\n7 8 No Data\n", "1\t2\t3\n4\tNo_Data\t6\n7\t8\tNoData\n",
        "1,2,3\n4,n/a,6\n7,8,--\n", "1;2;3\n4;missing;6\n7;8;null\n",
    ],
)  # fmt: skip
def test_holes_stay_holes(text, tmp_path):
    (tmp_path / "scan.txt").write_text(text, encoding="utf-8")
    heights = read_surface(tmp_path / "scan.txt", 1.0).heights
    np.testing.assert_array_equal(np.isnan(heights), [[0, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize("hole", ["-9999", "1e24", "-32768", "9.9e37"])
def test_a_lone_value_that_is_no_height_is_a_hole_and_told(hole, tmp_path):
    rough = np.random.default_rng(2).normal(size=(30, 30))
    text = saved(rough, fmt="%.4f").replace(f"{rough[3, 4]:.4f}", hole, 1)
    (tmp_path / "scan.txt").write_text(text)
    surface = read_surface(tmp_path / "scan.txt", 1e-6)
    assert np.argwhere(np.isnan(surface.heights)).tolist() == [[4, 3]]
    (note,) = surface.notes
    assert f"1 heights of {float(hole):g} are taken for holes" in note

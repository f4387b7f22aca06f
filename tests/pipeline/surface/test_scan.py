"""Files of heights are read with their units, or refused with a message."""

import numpy as np
import pytest

from pipeline.surface.scan import read_scan
from tests.helpers.kept import assert_as_kept, refusal, relative

HEIGHTS = np.random.default_rng(5).normal(0.0, 0.3, (48, 40))  # µm
X = 0.5 * np.arange(600)


def read(path):
    return read_scan(path, 1e-6)


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
    heights, _ = read(path)
    np.testing.assert_allclose(heights, 1e-6 * holed, rtol=1e-8)


def points():
    x, y = np.divmod(np.arange(4800.0), 60)
    return np.stack([x, y, np.sin(x)], axis=1)


NO_MAPS = [
    np.sin(X),
    np.stack([X, np.sin(X)], axis=1),
    points(),
    np.vstack([np.arange(40), HEIGHTS]),
    np.column_stack([np.arange(48), HEIGHTS]),
]


def test_what_is_no_map_is_refused_by_its_name_in_words_that_are_kept(tmp_path):
    texts = {}
    for number, table in enumerate(NO_MAPS):
        np.save(tmp_path / "a.npy", table)
        np.savetxt(tmp_path / "a.csv", np.atleast_2d(table), delimiter=",")
        for name in ("a.npy", "a.csv"):
            texts[f"{number} {name}"] = relative(refusal(read, tmp_path / name), tmp_path)
    assert_as_kept("refusals_of_no_maps", texts)


def test_marks_of_missing_heights_are_holes_and_told(tmp_path):
    marked = HEIGHTS.copy()
    marked[::7, 3], marked[5, ::9], marked[1, 1] = -9999, 99999, np.inf
    np.save(tmp_path / "a.npy", marked.T)
    assert np.isnan(read(tmp_path / "a.npy")[0]).sum() == 7 + 5 + 1
    zeros = HEIGHTS.copy()
    zeros[:10] = 0.0
    np.save(tmp_path / "b.npy", zeros.T)
    assert read(tmp_path / "b.npy")[1][-1] == (
        "400 heights are exactly 0: write nan if these are missing"
    )


ARRAYS = {
    "metres": (3.0 * HEIGHTS, 1.0),
    "a cube": (np.zeros((3, 4, 5)), 1e-6),
    "words": (np.array([["a", "b"]]), 1e-6),
    "nothing": (np.zeros((0, 4)), 1e-6),
    "many": (np.zeros((2**12, 2**12 + 1), np.int8), 1e-6),
}


def test_arrays_that_are_no_heights_are_refused_in_words_that_are_kept(tmp_path):
    texts = {}
    for name, (array, unit) in ARRAYS.items():
        np.save(tmp_path / "a.npy", array)
        texts[name] = relative(refusal(read_scan, tmp_path / "a.npy", unit), tmp_path)
    assert_as_kept("refusals_of_arrays", texts)


ROWS = "\n".join(" ".join(f"{z:.4f}" for z in row) for row in HEIGHTS.T)


OTHER_FILES = [
    f"ncols 48\ncellsize 0.5\n{ROWS}".encode(),
    b"1,2,3\n1,2\n",
    b"# head\n1 2\n3 4\nend\n",
    b"# head\n1 2\n3 bad\n",
    ROWS.replace(".", ",").replace(" ", ";").encode(),
    b"-0,1234,0,2345\n" * 20,
    b"no numbers at all\n",
    b"\x93NUMPY\x01",
    b"\x89PNG" + bytes(9),
    b"",
    b'"-0,1234" "0,2345"\n' * 20,
    b"1.234;5.678\n" * 20,
    b"1,,2\n3,,4\n",
]


def test_other_files_are_refused_with_help_in_words_that_are_kept(tmp_path):
    texts = {}
    for number, content in enumerate(OTHER_FILES):
        (tmp_path / "a.txt").write_bytes(content)
        texts[str(number)] = relative(refusal(read, tmp_path / "a.txt"), tmp_path)
    assert_as_kept("refusals_of_scans", texts)

"""Scans in some sixty layouts, as programs of laboratories write them: the map, or a refusal."""

import itertools

import numpy as np
import pytest

from pipeline.surface.scan import read_scan
from tribo import InputError

SHAPE = 24, 20  # heights along x and y
PHASES = np.random.default_rng(3).uniform(0, 6.3, 4)
X, Y = np.meshgrid(*map(np.arange, SHAPE), indexing="ij")
HEIGHTS = sum(0.3 * np.sin(0.4 * k * X + 0.7 * Y + PHASES[k]) for k in range(1, 4)).round(4)  # µm
MISSING = (3, 5), (3, 6), (11, 2)
DELIMITERS = {"tab": "\t", "semicolon": ";", "comma": ",", "blank": " "}


def rows_of(heights, form="{:.4f}", mark="nan"):
    return [[mark if np.isnan(z) else form.format(z) for z in row] for row in heights.T]


def holed():
    heights = HEIGHTS.copy()
    heights[tuple(zip(*MISSING, strict=True))] = np.nan
    return heights


def text_of(rows, delimiter):
    return "\n".join(delimiter.join(row) for row in rows) + "\n"


def two_marks(delimiter):
    rows = rows_of(HEIGHTS)
    for k, (x, y) in enumerate(MISSING):
        rows[y][x] = ("-9999", "-9998")[k % 2]
    return text_of(rows, delimiter).encode()


READ = {
    "plain": lambda d: text_of(rows_of(HEIGHTS), d).encode(),
    "quoted": lambda d: text_of(rows_of(HEIGHTS, '"{:.4f}"'), d).encode(),
    "powers": lambda d: text_of(rows_of(HEIGHTS, "{:.6e}"), d).encode(),
    "comments": lambda d: f"# x\n# y\n\n{text_of(rows_of(HEIGHTS), d)}".encode(),
    "windows": lambda d: text_of(rows_of(HEIGHTS), d).replace("\n", "\r\n").encode(),
    "with a mark": lambda d: text_of(rows_of(HEIGHTS), d).encode("utf-8-sig"),
    "utf-16": lambda d: text_of(rows_of(HEIGHTS), d).encode("utf-16"),
    "printed minus": lambda d: text_of(rows_of(HEIGHTS), d).replace("-", "−").encode(),
    "missing": lambda d: text_of(rows_of(holed()), d).encode(),
    "a low mark": lambda d: text_of(rows_of(holed(), mark="-9999"), d).encode(),
    "two low marks": two_marks,
    "a high mark": lambda d: text_of(rows_of(holed(), mark="1e10"), d).encode(),
}


@pytest.mark.parametrize(("layout", "delimiter"), [*itertools.product(READ, DELIMITERS)])
def test_a_map_is_read_as_it_was_written(layout, delimiter, tmp_path):
    (tmp_path / "a.txt").write_bytes(READ[layout](DELIMITERS[delimiter]))
    heights, _ = read_scan(tmp_path / "a.txt", 1e-6)
    is_holed = "missing" in layout or ("mark" in layout and layout != "with a mark")
    np.testing.assert_allclose(heights, 1e-6 * (holed() if is_holed else HEIGHTS), atol=1e-16)


AXES = {
    "thirds": np.round(np.arange(30) / 3, 2),
    "measured": np.round(0.1387 * np.arange(30), 2),
    "scattered": 0.5 * np.arange(30) + 0.02 * np.sin(np.arange(30) ** 2),
    "falling": -0.5 * np.arange(30),
    "numbers": 1.0 + np.arange(30),
}
EDGES = {
    "first row": lambda z, axis: np.c_[axis[: SHAPE[0]], z],
    "last row": lambda z, axis: np.c_[z, axis[: SHAPE[0]]],
    "first column": lambda z, axis: np.r_[axis[None, : SHAPE[1]], z],
    "last column": lambda z, axis: np.r_[z, axis[None, : SHAPE[1]]],
}


@pytest.mark.parametrize(("axis", "edge"), [*itertools.product(AXES, EDGES)])
def test_an_axis_at_any_edge_is_named(axis, edge, tmp_path):
    heights = EDGES[edge](HEIGHTS, AXES[axis])
    (tmp_path / "a.txt").write_text(text_of(rows_of(heights), "\t"))
    with pytest.raises(InputError, match=f"the {edge} (rises|falls) evenly, .* leave it out"):
        read_scan(tmp_path / "a.txt", 1e-6)


def test_heights_that_rise_as_evenly_as_an_axis_but_for_0_6_of_a_digit_are_heights(tmp_path):
    slope = np.round(3.36 * np.arange(SHAPE[0]))
    slope[12] += 1  # from 40, 0.3 below the line, to 0.6 above it
    heights = np.c_[1e-3 * slope, HEIGHTS]
    (tmp_path / "a.txt").write_text(text_of(rows_of(heights), "\t"))
    read, _ = read_scan(tmp_path / "a.txt", 1e-6)
    assert read.shape == heights.shape

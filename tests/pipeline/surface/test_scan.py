"""Files of heights: read with their units, or refused by the name of what they are."""

import numpy as np
import pytest

from pipeline import surface_statistics
from pipeline.surface.scan import read_scan
from tribo import Grid, InputError
from tribo.surface import self_affine

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
        rows = (mark.join("1.#QNAN" if np.isnan(z) else f"{z:.9g}" for z in row) for row in holed.T)
        path.write_text("".join(f"{row}{mark * (ending == 'trailing')}\n" for row in rows))
    scan = read(path)
    np.testing.assert_allclose(scan.heights, 1e-6 * holed, rtol=1e-8)
    assert (scan.pixel_size, scan.missing) == (SIDES, 1)


def test_a_text_with_sizes_in_its_head_needs_no_options(tmp_path):
    pytest.importorskip("SurfaceTopography")
    sides = 48 * SIDES[0] * 1e6, 40 * SIDES[1] * 1e6
    head = f"Width: {sides[0]} µm\nHeight: {sides[1]} µm\nValue units: m"
    np.savetxt(tmp_path / "a.txt", 1e-6 * HEIGHTS.T, header=head, encoding="utf-8")
    scan = read_scan(tmp_path / "a.txt")
    np.testing.assert_allclose(scan.heights, 1e-6 * HEIGHTS, rtol=1e-8)
    assert scan.pixel_size == pytest.approx(SIDES)


def points():
    x, y = np.divmod(np.arange(4800.0), 60)
    return np.stack([x, y, np.sin(x)], axis=1)


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        (np.sin(X), "a profile"),
        (np.stack([X, np.sin(X)], axis=1), "a profile"),
        (np.stack([X, np.sin(X)]), "a profile"),
        (np.stack([np.arange(600), X, np.sin(X)], axis=1), "a table of 3 columns"),
        (np.random.default_rng(1).normal(size=(600, 8)), "a table of 8 columns"),
        (points(), "a list of points x, y, z"),
        (np.vstack([np.arange(40), HEIGHTS]), "the first row rises evenly"),
        (np.column_stack([np.arange(48), HEIGHTS]), "the first column rises evenly"),
    ],
)
def test_what_is_no_map_is_refused_by_its_name(tmp_path, table, kind):
    np.save(tmp_path / "a.npy", table)
    np.savetxt(tmp_path / "a.csv", np.atleast_2d(table), delimiter=",")
    np.savetxt(tmp_path / "h.csv", np.atleast_2d(table), delimiter=",", header="A, B", comments="")
    for name in ("a.npy", "a.csv") if min(table.shape) > 8 else ("a.npy", "a.csv", "h.csv"):
        with pytest.raises(InputError, match=kind):
            read(tmp_path / name)


def test_marks_of_missing_heights_are_holes_and_told(tmp_path):
    marked = HEIGHTS.copy()
    marked[::7, 3], marked[5, ::9], marked[1, 1] = -9999, 99999, np.inf
    np.save(tmp_path / "a.npy", marked.T)
    scan = read(tmp_path / "a.npy")
    assert scan.missing == 7 + 5 + 1
    assert "7 heights of -9999 are taken for missing" in scan.notes
    zeros = HEIGHTS.copy()
    zeros[:10] = 0.0
    np.save(tmp_path / "b.npy", zeros.T)
    assert "are exactly 0: write nan" in read(tmp_path / "b.npy").notes[-1]


def test_units_and_sizes_are_given_or_asked_for(tmp_path):
    np.save(tmp_path / "a.npy", 10 * HEIGHTS)
    with pytest.raises(InputError, match=r"height_unit.* and the sides of a pixel .*; give that"):
        read_scan(tmp_path / "a.npy")
    assert read_scan(tmp_path / "a.npy", 1e-6, usual_sides=SIDES).pixel_size == SIDES
    with pytest.raises(InputError, match=r"heights of .* m; give the right unit"):
        read_scan(tmp_path / "a.npy", 1.0, SIDES)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"Height\nunit um\n1,2\n", "does not begin with numbers"),
        (b"1,2,3\n1,2\n", "as many in each row"),
        (b"0,12;0,13\n0,14;0,15\n", "does not begin with numbers|decimals with a point"),
        (b"\x93NUMPY\x01", "not a plain array"),
        (b"\x89PNG\r\n", "an image"),
    ],
)
def test_other_files_are_refused_with_help(tmp_path, content, why):
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "a.txt").write_bytes(content)
    with pytest.raises(InputError, match=why):
        read(tmp_path / "a.txt")


def test_a_random_surface_is_fitted_by_its_own_numbers(tmp_path):
    grid = Grid((256, 256), (0.5e-6, 0.5e-6))
    np.save(tmp_path / "a.npy", self_affine(grid, 3e-7, 0.8, (3e-6, 12e-6), seed=3).T)
    found = surface_statistics(tmp_path / "a.npy", 1.0, ("0.5 um", "0.5 um"))
    assert found.faults_of_fit == ()
    assert found.fit.correlation_length == pytest.approx((3e-6, 12e-6), rel=0.3)
    assert abs(found.roughness.lay) == pytest.approx(90, abs=15)
    cut = np.minimum(np.load(tmp_path / "a.npy"), 1e-7)
    np.save(tmp_path / "b.npy", cut)
    poor = surface_statistics(tmp_path / "b.npy", 1.0, ("0.5 um", "0.5 um"))
    assert "fits poorly: Ssk is" in str(poor)

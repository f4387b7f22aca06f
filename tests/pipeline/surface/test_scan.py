"""Files of heights are read with their units, or refused with a message."""

import io
import re
import zipfile

import numpy as np
import pytest

from pipeline import load_scene, plot, surface_statistics
from pipeline.surface.scan import read_scan
from tests.helpers.instruments import al3d, gwy, sur, x3p
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


def points():
    x, y = np.divmod(np.arange(4800.0), 60)
    return np.stack([x, y, np.sin(x)], axis=1)


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        (np.sin(X), "a profile"),
        (np.stack([X, np.sin(X)], axis=1), "a profile"),
        (np.stack([np.arange(600), X, np.sin(X)], axis=1), "a table of 3 columns"),
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
            r'not heights \("ncols 48"\); delete what is above the numbers, and',
        ),
        (b"1,2,3\n1,2\n", "with equally long rows"),
        (ROWS.replace(".", ",").replace(" ", ";").encode(), "decimals have commas"),
        (b"-0,1234,0,2345\n" * 20, "is no whole number"),
        (b"no numbers at all\n", "a text without a matrix of numbers; export"),
        (b"\x93NUMPY\x01", "not a plain array"),
        (b"\x89PNG" + bytes(9), "binary"),
        (zipped("heights.npy"), "an archive of arrays; save one"),
        (zipped("xl/workbook.xml"), "a workbook; save its sheet"),
        (zipped("main.xml", b"<p/>"), "SurfaceTopography"),
        (b"", "a text without a matrix"),
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
    statistics = surface_statistics(tmp_path / "a.npy", 1.0, ("0.5 um", "0.5 um"))
    assert statistics.faults_of_fit == ()
    assert statistics.fit.correlation_length == pytest.approx((3e-6, 12e-6), rel=0.3)
    assert abs(statistics.roughness.lay) == pytest.approx(90, abs=15)
    texts = {name: text for name, text, _ in statistics.rows()}
    assert float(texts["Str"]) == pytest.approx(statistics.roughness.aspect, rel=0.05)
    assert texts["lay"] == f"{statistics.roughness.lay:.0f}° from x"


@pytest.mark.parametrize(
    ("heights", "direction"),
    [
        (self_affine(Grid((256, 256), (0.5e-6, 0.5e-6)), 3e-7, 0.8, (12e-6, 3e-6), seed=3),
            r"lie along sliding, at -?\d°.* 1\d.* µm along sliding \(x\), [23].* µm across"),
        (self_affine(Grid((256, 256), (0.5e-6, 0.5e-6)), 3e-7, 0.8, (3e-6, 12e-6), seed=3),
            r"lie across sliding, at -?8\d°.* [23].* µm along sliding \(x\), 1\d.* µm across"),
        (3e-7 * np.sin(0.4 * np.indices((256, 256)).sum(axis=0)), r"oblique to sliding, at -4\d°"),
        (self_affine(Grid((256, 256), (0.5e-6, 0.5e-6)), 3e-7, 0.8, (3e-6, 3e-6), seed=3),
            "The scan has no lay"),
    ],
)  # fmt: skip
def test_the_direction_of_the_lay_is_stated_relative_to_sliding(tmp_path, irg, heights, direction):
    np.save(tmp_path / "a.npy", heights.T)
    options = "--height-unit", "m", "--pixel-size", "0.5 um"
    output = " ".join(irg("surface", tmp_path / "a.npy", *options).split())
    assert re.search(direction, output), output[-900:]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda z: np.minimum(z, 1e-7), "Ssk is"),
        (lambda z: np.sign(z) * np.abs(z) ** 1.8 / 3e-7**0.8, "Sku is"),
        (lambda z: z + 6e-7 * np.sin(0.4 * np.indices(z.shape).sum(axis=0)), "its lay is at"),
    ],
)
def test_what_a_random_surface_lacks_is_said(tmp_path, change, why):
    grid = Grid((256, 256), (0.5e-6, 0.5e-6))
    heights = change(self_affine(grid, 3e-7, 0.8, (3e-6, 12e-6), seed=3))
    np.save(tmp_path / "b.npy", heights.T)
    poor = surface_statistics(tmp_path / "b.npy", 1.0, ("0.5 um", "0.5 um"))
    assert any(why in fault for fault in poor.faults_of_fit)
    assert poor.tables.index("the scan itself") < poor.tables.index("a random surface")


def test_few_heights_are_not_compared_by_their_spectrum(tmp_path):
    grid = Grid((16, 16), (0.5e-6, 0.5e-6))
    np.save(tmp_path / "a.npy", self_affine(grid, 3e-7, 0.8, (1e-6, 1e-6), seed=3).T)
    statistics = surface_statistics(tmp_path / "a.npy", 1.0, ("0.5 um", "0.5 um"))
    assert statistics.faults_of_fit[0] == "the scan has too few heights to compare spectra"


@pytest.mark.parametrize(
    ("factor", "side", "word"),
    [
        (1e3, "0.5 um", "check the unit of the heights"),
        (1.0, "0.5 mm", "check their size"),
        (1.0, "0.5 nm", "check the unit of heights and the pixels' size"),
    ],
)
def test_units_that_are_off_by_a_thousand_are_told(tmp_path, factor, side, word):
    grid = Grid((64, 64), (0.5e-6, 0.5e-6))
    np.save(tmp_path / "a.npy", factor * self_affine(grid, 2e-7, 0.8, (3e-6, 3e-6), seed=3).T)
    statistics = surface_statistics(tmp_path / "a.npy", 1.0, (side, side))
    assert any(word in note for note in statistics.notes)


def test_the_tables_that_are_printed_make_scenes_like_the_scan(tmp_path):
    """The tables contain the given unit (here 2 nm), pixel size and missing share."""
    grid = Grid((96, 64), (0.5e-6, 0.5e-6))
    heights = 5e8 * self_affine(grid, 3e-7, 0.8, (3e-6, 12e-6), seed=3)
    heights[3:20, 4:44] = np.nan
    np.save(tmp_path / "a.npy", heights.T)
    statistics = surface_statistics(tmp_path / "a.npy", "2 nm", ("0.5 um", "0.5 um"), missing=0.2)

    def roughness(toml):
        head = 'extends = "first_try"\nwithout = ["disk.roughness"]\n'
        (tmp_path / "a.toml").write_text(head + toml)
        return load_scene(tmp_path / "a.toml").scene.roughness

    random = roughness(statistics.random_tables)
    assert random.ra == pytest.approx(statistics.roughness.sa, rel=1e-3)
    assert random.correlation_length == pytest.approx(statistics.fit.correlation_length, rel=0.01)
    scan = roughness(
        statistics.scan_tables.replace("window = { ", "window = { pixels = [96, 64], ")
    ).array
    assert scan.std() == pytest.approx(statistics.heights.std(), rel=0.01)


def test_a_figure_has_scan_and_random_surface_and_their_spectra(tmp_path):
    """The spectral density of white noise is Sq² times the side of a pixel, along both axes."""
    np.save(tmp_path / "a.npy", 1e-6 * HEIGHTS.T)
    statistics = surface_statistics(tmp_path / "a.npy", 1.0, ("0.5 um", "0.5 um"))
    maps, spectra = {}, None
    for axes in plot(statistics).axes:
        for image in axes.images:
            maps[len(maps)] = 1e-6 * image.get_array()
        spectra = axes if axes.lines else spectra
    np.testing.assert_allclose(maps[0], statistics.heights.T)
    np.testing.assert_allclose(maps[1], statistics.fitted_heights.T)
    for line, label in zip(spectra.lines[:2], ("scan along x", "scan along y"), strict=True):
        assert line.get_label() == label
        density = line.get_ydata()
        assert density.mean() == pytest.approx(0.5e12 * statistics.roughness.sq**2, rel=0.1)


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

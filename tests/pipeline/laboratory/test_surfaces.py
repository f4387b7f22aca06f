"""Measured surfaces: read, cropped, levelled, and their holes filled."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from pipeline.laboratory.surfaces import MeasuredSurface, filled, oriented, read_surface
from pipeline.sweep.areal import remove_form
from tests.pipeline.scene.conftest import ROUGHNESS
from tribo import InputError

HEIGHTS = np.random.default_rng(5).normal(0.0, 3e-7, (48, 40))
SIDES = 0.816e-6, 0.95e-6
FINEST = {"pixels_per_element": 1}


class FakeTopography:
    """Parts of SurfaceTopography's topographies that are used, for machines without it."""

    def __init__(self, heights, unit="m", dim=2):
        self.array, self.unit, self.dim, self.is_uniform = heights, unit, dim, True
        self.pixel_size = np.array(SIDES) * (1e6 if unit == "µm" else 1.0)

    def heights(self):
        return self.array

    def to_unit(self, unit):
        assert unit == "m"
        factor = {"m": 1.0, "µm": 1e-6}[self.unit]
        return FakeTopography(self.array * factor)


@pytest.fixture
def library(monkeypatch, tmp_path):
    """A library that finds one topography in any file; return where to put it."""
    stand_in = SimpleNamespace(topography=None)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.opd").touch()

    def open_topography(path):
        def read():
            if isinstance(stand_in.topography, Exception):
                raise stand_in.topography
            return stand_in.topography

        channel = SimpleNamespace(physical_sizes=SIDES)
        return SimpleNamespace(topography=read, default_channel=channel)

    module = ModuleType("SurfaceTopography.IO")
    module.open_topography = open_topography
    monkeypatch.setitem(sys.modules, "SurfaceTopography", ModuleType("SurfaceTopography"))
    monkeypatch.setitem(sys.modules, "SurfaceTopography.IO", module)
    return stand_in


def holed(*places):
    mask = np.zeros(HEIGHTS.shape, bool)
    for place in places:
        mask[place] = True
    return np.ma.masked_array(HEIGHTS, mask)


def with_table(table, pixels=HEIGHTS.shape):
    """Changes of the first scene to a measured surface."""
    return (ROUGHNESS, table + "\n"), ("[480, 480]", str(list(pixels)))


def test_heights_and_pixels_come_in_metres(library):
    library.topography = FakeTopography(HEIGHTS * 1e6, unit="µm")
    surface = read_surface("a.opd")
    np.testing.assert_allclose(surface.heights, HEIGHTS, rtol=1e-12)
    assert surface.pixel_size == pytest.approx(SIDES)


def test_a_file_without_unit_needs_one(library):
    library.topography = FakeTopography(HEIGHTS, unit=None)
    with pytest.raises(InputError, match="no unit of its heights"):
        read_surface("a.opd")
    np.testing.assert_allclose(read_surface("a.opd", 1e-6).heights, 1e-6 * HEIGHTS)
    assert read_surface("a.opd", 1e-6).pixel_size is None


def test_a_profile_and_a_broken_file_are_refused(library):
    library.topography = FakeTopography(HEIGHTS, dim=1)
    with pytest.raises(InputError, match="a profile"):
        read_surface("a.opd")
    library.topography = RuntimeError("bad header\nmore")
    with pytest.raises(InputError, match=r"cannot be read as .opd: bad header; save the heights"):
        read_surface("a.opd")


def test_without_the_extra_the_message_says_how_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    monkeypatch.setitem(sys.modules, "SurfaceTopography.IO", None)
    (tmp_path / "a.opd").touch()
    with pytest.raises(InputError, match="pip install SurfaceTopography"):
        read_surface(tmp_path / "a.opd")


def test_heights_may_be_missing_and_infinite_ones_are_holes_and_told(tmp_path):
    (tmp_path / "a.csv").write_text("1,nan\n,4\n")
    np.testing.assert_array_equal(
        read_surface(tmp_path / "a.csv", 1.0).heights, [[1.0, np.nan], [np.nan, 4.0]]
    )
    (tmp_path / "a.csv").write_text("1,inf\n3,4\n")
    surface = read_surface(tmp_path / "a.csv", 1.0)
    np.testing.assert_array_equal(surface.heights, [[1.0, 3.0], [np.nan, 4.0]])
    assert surface.notes == ("1 infinite heights are holes",)


@pytest.mark.parametrize("name", ["a.x3p", "a.gwy", "a.npy", "a.csv", "a.txt"])
def test_x_goes_from_column_to_column_of_each_file(tmp_path, name):
    topographies = pytest.importorskip("SurfaceTopography")
    size = tuple(n * side for n, side in zip(HEIGHTS.shape, SIDES, strict=True))
    measured = topographies.Topography(HEIGHTS, size, unit="m")
    head = f"Width: {1e6 * size[0]} µm\nHeight: {1e6 * size[1]} µm\nValue units: m"
    path = tmp_path / name
    {
        "a.x3p": lambda: measured.to_x3p(str(path)),
        "a.gwy": lambda: measured.to_gwy(str(path)),
        "a.npy": lambda: np.save(path, HEIGHTS.T),
        "a.csv": lambda: np.savetxt(path, HEIGHTS.T, delimiter=","),
        "a.txt": lambda: np.savetxt(path, HEIGHTS.T, header=head, encoding="utf-8"),
    }[name]()
    surface = read_surface(path, 1.0)
    np.testing.assert_allclose(surface.heights, HEIGHTS, rtol=1e-6)
    if name not in ("a.npy", "a.csv"):
        assert surface.pixel_size == pytest.approx(SIDES)


def test_a_note_says_that_the_unit_and_the_pixels_given_count(library):
    library.topography = FakeTopography(HEIGHTS * 1e6, unit="µm")
    surface = read_surface("a.opd", 1e-9)
    np.testing.assert_allclose(surface.heights, 1e-3 * HEIGHTS)
    (note,) = surface.notes
    assert "the given height unit counts, 1e-09 m, not the file's, 1e-06 m" in note
    assert read_surface("a.opd", 1e-6).replace_pixels(SIDES).notes == ()
    double = SIDES[0] * 2, SIDES[1] * 2
    (note,) = read_surface("a.opd").replace_pixels(double).notes
    assert note == "the given pixels count, not the file's, 0.816 × 0.95 µm"
    with pytest.raises(InputError, match=r"those of the file are 0\.816 × 0\.95 µm; give that"):
        read_surface("a.opd").replace_pixels((1e-6, 1e-6))


def test_an_image_is_refused_in_words(tmp_path):
    (tmp_path / "a.tif").touch()
    with pytest.raises(InputError, match="an image, whose grey values are no heights"):
        read_surface(tmp_path / "a.tif")


def test_filled_holes_stay_between_their_borders():
    heights = HEIGHTS.copy()
    heights[0, 0] = heights[20:26, 10:18] = heights[30, 39] = np.nan
    whole = filled(heights)
    measured = np.isfinite(heights)
    np.testing.assert_array_equal(whole[measured], heights[measured])
    border = heights[19:27, 9:19]
    assert np.nanmin(border) < whole[20:26, 10:18].min()
    assert whole[20:26, 10:18].max() < np.nanmax(border)
    # Each is the mean of its neighbours; a corner has two.
    assert whole[22, 13] == pytest.approx(
        (whole[21, 13] + whole[23, 13] + whole[22, 12] + whole[22, 14]) / 4
    )
    assert whole[0, 0] == pytest.approx((heights[0, 1] + heights[1, 0]) / 2)
    with pytest.raises(InputError, match="all heights are missing"):
        filled(np.full((3, 3), np.nan))


def test_a_scene_takes_a_patch_levelled_and_filled(read, library):
    library.topography = FakeTopography(holed((10, 12), (20, 20)))
    table = 'file = "a.opd"\ncrop = [4, 6]\nlevel = true\nmissing = "fill"\n'
    sweep = read(*with_table(table, (40, 32)), overrides=FINEST)
    patch = holed((10, 12), (20, 20)).filled(np.nan)[4:44, 6:38]
    expected = filled(remove_form(patch, SIDES)[0])
    np.testing.assert_array_equal(sweep.scene.roughness.array, expected)
    note, _ = sweep.about.notes
    assert "2 of 1280 heights (0.16 %) are missing and were filled" in note.words


def test_a_scan_that_is_too_small_is_repeated_on_request(read, library):
    library.topography = FakeTopography(HEIGHTS)
    rows, columns = HEIGHTS.shape
    table = 'file = "a.opd"\nrepeat = "mirror"\ncrop = [2, 0]\n'
    sweep = read(*with_table(table, (2 * rows, columns)), overrides=FINEST)
    kept, second = np.split(sweep.scene.roughness.array, [rows - 2])
    np.testing.assert_array_equal(kept, HEIGHTS[2:])
    np.testing.assert_array_equal(second[: rows - 2], HEIGHTS[2:][::-1])
    note, _ = sweep.about.notes
    assert f"{rows - 2} × {columns} heights were mirrored" in note.words


@pytest.mark.parametrize(
    ("table", "key", "said"),
    [
        ('file = "a.opd"\nrepeat = "yes"\n', "disk.roughness.repeat", "mirror"),
        ('file = "a.opd"\n', "disk.roughness.missing", "x 20, y 20"),
        (
            'file = "a.opd"\ncrop = [40, 0]\n',
            "disk.roughness.crop",
            "surface of 48 × 40",
        ),
        ('file = "a.npy"\n', "disk.roughness.file", "give height_unit"),
        ('file = "b.npy"\nheight_unit = "um"\n', "disk.roughness.file", "No such file"),
    ],
)
def test_a_fault_of_a_measured_surface_has_its_key(faults, library, table, key, said):
    np.save("a.npy", HEIGHTS)
    library.topography = FakeTopography(holed((20, 20)))
    (fault,) = faults(*with_table(table), overrides=FINEST)
    assert fault.startswith(f"{key}: ")
    assert said in fault


def test_the_pixels_of_the_file_are_those_of_the_window(faults, library):
    library.topography = FakeTopography(HEIGHTS)
    library.topography.to_unit = lambda unit: SimpleNamespace(
        heights=lambda: HEIGHTS, pixel_size=(2e-6, 2e-6)
    )
    (fault,) = faults(*with_table('file = "a.opd"\n'), overrides=FINEST)
    assert fault.startswith("window.pixel_size: ")
    assert "2 µm × 2 µm" in fault


def test_a_surface_is_turned_with_its_pixels_and_its_heights_reversed():
    surface = MeasuredSurface(np.arange(6.0).reshape(2, 3), (1e-6, 2e-6))
    turned = oriented(surface, transpose=True)
    assert turned.pixel_size == (2e-6, 1e-6)
    assert np.array_equal(turned.heights, surface.heights.T)
    assert np.array_equal(oriented(surface, flip=True).heights, -surface.heights)

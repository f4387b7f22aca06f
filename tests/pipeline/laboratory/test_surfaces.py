"""Measured surfaces: read, cropped, levelled, and their holes filled."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from pipeline.laboratory.surfaces import MeasuredSurface, filled, oriented, read_surface
from tests.pipeline.scene.conftest import ROUGHNESS
from tribo.surface.areal import remove_form

HEIGHTS = np.random.default_rng(5).normal(0.0, 3e-7, (48, 40))
SIDES = 0.816e-6, 0.95e-6
FINEST = {"pixels_per_element": 1}


class FakeTopography:
    """The used parts of a topography of SurfaceTopography, for machines without that library."""

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
    """Fake library that finds in any file the topography that is set here."""
    stand_in = SimpleNamespace(topography=None)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.opd").touch()

    def open_topography(path, format=None):
        def read():
            if isinstance(stand_in.topography, Exception):
                raise stand_in.topography
            return stand_in.topography

        channel = SimpleNamespace(physical_sizes=SIDES)
        return SimpleNamespace(topography=read, default_channel=channel, channels=[channel])

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
    """Replacements in the text of a scene that give it a measured surface."""
    return (ROUGHNESS, table + "\n"), ("[480, 480]", str(list(pixels)))


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


def test_a_scene_takes_a_patch_levelled_and_filled(read, library):
    library.topography = FakeTopography(holed((10, 12), (20, 20)))
    table = 'file = "a.opd"\ncrop = [4, 6]\nlevel = true\nmissing = "fill"\n'
    sweep = read(*with_table(table, (40, 32)), overrides=FINEST)
    patch = holed((10, 12), (20, 20)).filled(np.nan)[4:44, 6:38]
    expected = filled(remove_form(patch, SIDES)[0])
    np.testing.assert_array_equal(sweep.scene.roughness.array, expected)
    note, _ = sweep.notes
    assert "2 of 1280 heights (0.16 %) are missing and were filled" in note.words


def test_a_scan_that_is_too_small_is_repeated_on_request(read, library):
    library.topography = FakeTopography(HEIGHTS)
    rows, columns = HEIGHTS.shape
    table = 'file = "a.opd"\nrepeat = "mirror"\ncrop = [2, 0]\n'
    sweep = read(*with_table(table, (2 * rows, columns)), overrides=FINEST)
    kept, second = np.split(sweep.scene.roughness.array, [rows - 2])
    np.testing.assert_array_equal(kept, HEIGHTS[2:])
    np.testing.assert_array_equal(second[: rows - 2], HEIGHTS[2:][::-1])
    note, _ = sweep.notes
    assert f"{rows - 2} × {columns} heights were mirrored" in note.words


def test_a_surface_is_turned_with_its_pixels_and_its_heights_reversed():
    surface = MeasuredSurface(np.arange(6.0).reshape(2, 3), (1e-6, 2e-6))
    turned = oriented(surface, transpose=True)
    assert turned.pixel_size == (2e-6, 1e-6)
    assert np.array_equal(turned.heights, surface.heights.T)
    assert np.array_equal(oriented(surface, flip=True).heights, -surface.heights)

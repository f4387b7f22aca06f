"""Files of instruments, written by own writers: heights, holes, pixels and units come out."""

import numpy as np
import pytest

from pipeline.surface.scan import read_scan
from tests.helpers.instruments import al3d, gwy, sur, x3p

HEIGHTS = np.random.default_rng(5).normal(0.0, 3e-7, (21, 16))
HOLED = np.where(np.random.default_rng(6).random(HEIGHTS.shape) < 0.1, np.nan, HEIGHTS)
PIXEL = 0.5e-6, 2e-6

FILES = {
    # By file name: its content, and the tolerance of the heights.
    "matrix.x3p": (x3p(HOLED, PIXEL), 0),
    "floats.x3p": (x3p(HOLED, PIXEL, dtype="F"), 1e-13),
    "integers.x3p": (x3p(HOLED, PIXEL, dtype="L"), 0.5e-9),
    "short.x3p": (x3p(HOLED, PIXEL, dtype="I"), 0.5e-9),
    "a.gwy": (gwy([("z", HOLED, "m")], PIXEL), 0),
    "second.gwy": (gwy([("phase", HEIGHTS * 1e6, "deg"), ("z", HOLED, "m")], PIXEL), 0),
    "plain.sur": (sur(HOLED, PIXEL), 1e-13),
    "a.al3d": (al3d(HOLED, PIXEL), 1e-13),
}


@pytest.mark.parametrize("name", FILES)
def test_an_instrument_s_heights_come_out_with_holes_and_pixels(tmp_path, name):
    pytest.importorskip("SurfaceTopography")
    content, near = FILES[name]
    (tmp_path / name).write_bytes(content)
    surface = read_scan(tmp_path / name)
    np.testing.assert_allclose(surface.heights, HOLED, rtol=1e-12, atol=near)
    assert surface.pixel_size == pytest.approx(PIXEL, rel=1e-6)


def test_the_unit_given_counts_for_heights_and_not_for_pixels(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "a.x3p"
    path.write_bytes(x3p(HEIGHTS, PIXEL))
    surface = read_scan(path, 1e-6)
    np.testing.assert_allclose(surface.heights, 1e-6 * HEIGHTS, rtol=1e-12)
    assert surface.pixel_size == pytest.approx(PIXEL)
    assert "the given height unit, 1e-06 m, replaces the file's, 1 m" in surface.notes[-1]

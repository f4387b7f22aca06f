"""Lengths of the autocorrelation, against surfaces that have it in closed form."""

import math

import numpy as np
import pytest
from scipy import ndimage

from pipeline.sweep.autocorrelation import autocorrelation_lengths
from tribo import InputError

PIXEL = 0.8e-6


def gaussian(length_x, length_y, shape=(480, 400)):
    """Heights whose autocorrelation is exp(−(x/length_x)² − (y/length_y)²)."""
    noise = np.random.default_rng(1).standard_normal(shape)
    widths = length_x / PIXEL / 2, length_y / PIXEL / 2
    return ndimage.gaussian_filter(noise, widths, mode="wrap")


def test_a_gaussian_surface_has_its_lengths():
    found = autocorrelation_lengths(gaussian(16e-6, 4e-6), (PIXEL, PIXEL))
    assert found.along_x == pytest.approx(16e-6, rel=0.1)
    assert found.along_y == found.shortest == pytest.approx(4e-6, rel=0.1)
    assert found.texture_aspect == pytest.approx(0.25, rel=0.15)
    assert abs(found.direction) < 5


def test_a_turned_surface_keeps_its_shortest_and_longest():
    turned = ndimage.rotate(gaussian(16e-6, 4e-6, (700, 700)), 30.0, reshape=False)[
        150:550, 150:550
    ]
    found = autocorrelation_lengths(turned, (PIXEL, PIXEL))
    assert found.shortest == pytest.approx(4e-6, rel=0.12)
    assert found.direction == pytest.approx(30.0, abs=5)
    assert found.shortest < found.along_y < found.along_x < found.longest


def test_a_patch_is_known_to_the_same_share_of_its_length_along_both_axes():
    """Waves of 100 pixels fall to the threshold after 19 of them, in 400 pixels but not in 20."""
    waves = np.cos(2 * np.pi * np.arange(400) / 100)
    for shape in ((400, 20), (20, 400)):
        along_x = shape[0] > shape[1]
        heights = np.broadcast_to(waves[:, None] if along_x else waves, shape)
        found = autocorrelation_lengths(heights, (PIXEL, PIXEL))
        lengths = (found.along_x, found.along_y)[:: 1 if along_x else -1]
        assert lengths == (pytest.approx(19 * PIXEL, rel=0.1), np.inf)


def test_the_threshold_and_unequal_pixels_count():
    heights = gaussian(12e-6, 12e-6)
    found = autocorrelation_lengths(heights, (PIXEL, PIXEL), threshold=0.2)
    assert found.along_x == pytest.approx(12e-6 * math.sqrt(math.log(5)), rel=0.1)
    wide = autocorrelation_lengths(heights, (PIXEL, 2 * PIXEL), threshold=0.2)
    assert wide.along_y == pytest.approx(2 * found.along_y, rel=0.01)


def test_lines_have_no_length_along_themselves():
    lines = np.broadcast_to(gaussian(8e-6, 8e-6)[:, :1], (480, 400))
    found = autocorrelation_lengths(lines, (PIXEL, PIXEL))
    assert found.along_y == found.longest == math.inf
    assert abs(found.direction) == pytest.approx(90.0)
    assert found.texture_aspect == 0.0


def test_a_flat_surface_is_refused():
    with pytest.raises(InputError, match="rms_height"):
        autocorrelation_lengths(np.zeros((40, 40)), (PIXEL, PIXEL))

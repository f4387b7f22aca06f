"""Lengths of the autocorrelation, against surfaces that have it in closed form."""

import math

import numpy as np
import pytest
from scipy import ndimage

from tribo import InputError
from tribo.surface.areal import autocorrelation_lengths

PIXEL = 0.8e-6


def gaussian(length_x, length_y, shape=(480, 400)):
    """Heights whose autocorrelation exp(−ln 5 ((x/length_x)² + (y/length_y)²)) falls to 0.2."""
    noise = np.random.default_rng(1).standard_normal(shape)
    widths = np.divide((length_x, length_y), 2 * PIXEL * math.sqrt(math.log(5)))
    return ndimage.gaussian_filter(noise, widths, mode="wrap")


def test_a_gaussian_surface_has_its_lengths():
    shortest, longest, direction = autocorrelation_lengths(gaussian(16e-6, 4e-6), (PIXEL, PIXEL))
    assert shortest == pytest.approx(4e-6, rel=0.1)
    assert longest == pytest.approx(16e-6, rel=0.12)
    assert abs(direction) < 5


def test_a_turned_surface_keeps_its_shortest_and_longest():
    turned = ndimage.rotate(gaussian(16e-6, 4e-6, (700, 700)), 30.0, reshape=False)[
        150:550, 150:550
    ]
    shortest, _, direction = autocorrelation_lengths(turned, (PIXEL, PIXEL))
    assert shortest == pytest.approx(4e-6, rel=0.12)
    assert direction == pytest.approx(30.0, abs=5)


def test_a_patch_is_known_to_the_same_share_of_its_length_along_both_axes():
    """Waves of 100 pixels fall to 0.2 after 22, found in 400 pixels but not in 20."""
    waves = np.cos(2 * np.pi * np.arange(400) / 100)
    for shape in ((400, 20), (20, 400)):
        heights = np.broadcast_to(waves[:, None] if shape[0] > shape[1] else waves, shape)
        shortest, longest, _ = autocorrelation_lengths(heights, (PIXEL, PIXEL))
        assert (shortest, longest) == (pytest.approx(21.8 * PIXEL, rel=0.1), math.inf)


def test_a_flat_surface_is_refused():
    with pytest.raises(InputError, match="rms_height"):
        autocorrelation_lengths(np.zeros((40, 40)), (PIXEL, PIXEL))

"""Roughness of measured heights only and after removal of the form."""

import math

import numpy as np
import pytest
from scipy import ndimage

from tribo.surface.areal import areal_roughness, autocorrelation_lengths, remove_form

SPACING = 2e-6, 3e-6
SHAPE = 160, 120
ROUGH = 1e-7 * np.random.default_rng(4).standard_normal(SHAPE)
X, Y = ((np.arange(n) - (n - 1) / 2)[s] * d for n, d, s in zip(
    SHAPE, SPACING, (np.s_[:, None], np.s_[None, :]), strict=True))  # fmt: skip


def holed(heights, share=0.3, seed=1):
    return np.where(np.random.default_rng(seed).random(heights.shape) < share, np.nan, heights)


def test_amplitudes_are_those_of_the_measured_heights():
    """Normal heights have Sa = Sq √(2/π); the plane takes 3 of 13 440 degrees of freedom."""
    patchy = holed(ROUGH)
    roughness = areal_roughness(patchy, SPACING)
    values = patchy[np.isfinite(patchy)]
    assert roughness.sq == pytest.approx(values.std(), rel=1e-3)
    assert roughness.sa == pytest.approx(np.abs(values - values.mean()).mean(), rel=1e-3)
    assert roughness.sa / roughness.sq == pytest.approx(math.sqrt(2 / math.pi), rel=0.01)
    assert roughness.mean == pytest.approx(values.mean(), rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_plane_and_both_curvatures_are_taken_off(share):
    form = 0.02 * X - 0.01 * Y - X**2 / (2 * 0.03) + Y**2 / (2 * 0.05) + 4.0 * X * Y
    level, slopes, radii = remove_form(holed(ROUGH + form, share), SPACING)
    assert slopes == pytest.approx((0.02, -0.01), rel=0.01)
    assert radii == pytest.approx((0.03, -0.05), rel=0.03)
    is_measured = np.isfinite(level)
    assert level[is_measured].std() == pytest.approx(ROUGH[is_measured].std(), rel=0.01)


def test_a_curvature_within_the_roughness_is_left():
    """The curvature's sag at the edge is half a root mean square height."""
    radius = (X**2).max() / (2 * 0.5e-7)
    level, _, radii = remove_form(ROUGH - X**2 / (2 * radius), SPACING)
    assert radii == (math.inf, math.inf)
    assert level.mean(axis=1)[[0, -1]].mean() < level.mean(axis=1)[70:90].mean()


def test_grooves_longer_than_the_area_have_an_aspect_of_0_and_a_lay():
    grooves = np.sin(2 * np.pi * X / 40e-6) + 1e-6 * ROUGH / 1e-7
    roughness = areal_roughness(1e-7 * grooves, SPACING)
    assert roughness.aspect == 0
    assert abs(roughness.lay) == pytest.approx(90, abs=2)


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_holes_do_not_move_the_autocorrelation(share):
    """A wave of 40 µm falls to 0.2 at 40 µm · arccos(0.2)/2π = 8.7 µm."""
    wave = np.cos(2 * np.pi * np.arange(200) / 40)[:, None] * np.ones(60)
    complete, *_ = autocorrelation_lengths(wave, (1e-6, 1e-6))
    assert complete == pytest.approx(
        40e-6 * math.acos(0.2) / (2 * math.pi), rel=0.03
    )  # ends of the wave
    patchy, longest, _ = autocorrelation_lengths(holed(wave, share), (1e-6, 1e-6))
    assert patchy == pytest.approx(complete, rel=0.01)
    assert longest == math.inf


# Lengths of the autocorrelation, against surfaces that have it in closed form.

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


def test_a_patch_is_known_to_the_same_share_of_its_length_along_both_axes():
    """Waves of 100 pixels fall to 0.2 after 22, found in 400 pixels but not in 20."""
    waves = np.cos(2 * np.pi * np.arange(400) / 100)
    for shape in ((400, 20), (20, 400)):
        heights = np.broadcast_to(waves[:, None] if shape[0] > shape[1] else waves, shape)
        shortest, longest, _ = autocorrelation_lengths(heights, (PIXEL, PIXEL))
        assert (shortest, longest) == (pytest.approx(21.8 * PIXEL, rel=0.1), math.inf)

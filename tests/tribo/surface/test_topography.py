import numpy as np
import pytest

from tribo import Grid
from tribo.surface import average_roughness, rms_slope
from tribo.surface import self_affine as make

PIXELS = Grid((256, 192), (0.8e-6, 0.95e-6))


def self_affine(grid=PIXELS, ra=0.27e-6, hurst_exponent=0.8, correlation_length=4e-6, seed=0):
    return make(grid, ra, hurst_exponent, correlation_length, seed)


def test_roughness_is_as_asked_and_heights_have_no_mean():
    heights = self_affine()
    assert average_roughness(heights) == pytest.approx(0.27e-6, rel=1e-12)
    assert abs(heights.mean()) < 1e-12 * 0.27e-6


def test_spectrum_falls_as_the_hurst_exponent_says():
    grid = Grid((512, 512), (1.0, 1.0))
    q = np.hypot(np.fft.fftfreq(512)[:, None], np.fft.rfftfreq(512)[None, :]) * 2 * np.pi
    ring = (q > 0.05) & (q < 1.0)
    power = np.mean(
        [
            np.abs(np.fft.rfft2(self_affine(grid, correlation_length=1e3, seed=s))) ** 2
            for s in range(4)
        ],
        axis=0,
    )
    slope = np.polyfit(np.log(q[ring]), np.log(power[ring]), 1)[0]
    assert slope == pytest.approx(-2 * (1 + 0.8), abs=0.03)  # scatter of the fit over 2e5 modes


def test_a_lay_correlates_further_along_y():
    heights = self_affine(correlation_length=(2e-6, 20e-6))
    slope_x = np.diff(heights, axis=0).std() / PIXELS.spacing[0]
    slope_y = np.diff(heights, axis=1).std() / PIXELS.spacing[1]
    assert slope_x > 3 * slope_y


def test_the_rms_slope_of_a_wave_along_y_is_that_of_its_derivative():
    y = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    heights = np.broadcast_to(0.5 * np.sin(2 * y), (3, 2000))
    # Central differences err by (q·dy)²/6.
    assert rms_slope(heights, (1.0, y[1])) == pytest.approx(0.5 * 2 / np.sqrt(2), rel=1e-5)

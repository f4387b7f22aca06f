"""Parameters of random surfaces, found again from their heights."""

import numpy as np
import pytest
from scipy import ndimage

from pipeline.laboratory.spectrum import fit_self_affine
from tribo import Grid, InputError
from tribo.surface import self_affine


@pytest.mark.parametrize(
    ("hurst", "lengths", "spacing"),
    [(0.8, (4e-6, 4e-6), (1e-6, 1e-6)), (0.5, (4e-6, 15e-6), (1e-6, 1.5e-6))],
)
def test_known_parameters_are_found_within_their_errors(hurst, lengths, spacing):
    deviations = []
    for seed in range(3):
        whole = self_affine(Grid((300, 300), spacing), 0.3e-6, hurst, lengths, seed)
        patch = whole[:200, :160]  # which does not repeat
        fit = fit_self_affine(patch - patch.mean(), spacing)
        errors = [fit.hurst_error, *fit.length_error]
        values = [fit.hurst_exponent, *fit.correlation_length]
        deviations.append((np.array(values) - [hurst, *lengths]) / errors)
        assert fit.misfit < 1.6
    rms = np.sqrt(np.mean(np.square(deviations), axis=0))
    assert ((rms > 0.2) & (rms < 2.2)).all()  # 9 values of a normal distribution
    assert abs(np.mean(deviations)) < 1.0


def test_patches_of_one_surface_differ_in_their_height_by_the_error_that_is_said():
    whole = self_affine(Grid((640, 640), (1e-6, 1e-6)), 0.3e-6, 0.8, (4e-6, 4e-6), seed=0)
    patches = whole.reshape(10, 64, 10, 64).swapaxes(1, 2).reshape(100, 64, 64)
    heights = patches.std(axis=(1, 2))
    said = fit_self_affine(patches[0] - patches[0].mean(), (1e-6, 1e-6)).rms_error
    assert heights.std() / heights.mean() == pytest.approx(said, rel=0.3)


def test_a_turned_surface_has_its_lay_at_that_angle():
    whole = self_affine(Grid((384, 384), (1e-6, 1e-6)), 0.3e-6, 0.8, (20e-6, 5e-6), seed=4)
    turned = ndimage.rotate(whole, 30.0, reshape=False, order=3)[96:288, 96:288]
    fit = fit_self_affine(turned - turned.mean(), (1e-6, 1e-6))
    # From x, which points down the rows, towards y.
    assert fit.lay == pytest.approx(30.0, abs=4 * fit.lay_error)
    assert fit.lay_error < 3


def test_a_surface_that_is_not_self_affine_shows_in_its_spectrum():
    heights = self_affine(Grid((256, 256), (1e-6, 1e-6)), 0.3e-6, 0.8, (10e-6, 10e-6), seed=4)
    smoothed = ndimage.gaussian_filter(heights, 4)
    assert fit_self_affine(smoothed, (1e-6, 1e-6)).misfit > 3


def test_heights_without_a_spectrum_are_refused():
    with pytest.raises(InputError, match="8 × 40 heights are too few"):
        fit_self_affine(np.zeros((8, 40)), (1e-6, 1e-6))
    with pytest.raises(InputError, match="rms_height"):
        fit_self_affine(np.zeros((32, 40)), (1e-6, 1e-6))

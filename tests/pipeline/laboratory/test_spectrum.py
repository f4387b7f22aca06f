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
def test_known_parameters_are_found_within_the_scatter_of_surfaces(hurst, lengths, spacing):
    found = []
    for seed in range(8):
        whole = self_affine(Grid((300, 300), spacing), 0.3e-6, hurst, lengths, seed)
        patch = whole[:200, :160]  # which does not repeat
        fit = fit_self_affine(patch - patch.mean(), spacing)
        found.append([fit.hurst_exponent, *fit.correlation_length])
        assert fit.misfit < 1.6
    error = np.std(found, axis=0, ddof=1) / np.sqrt(len(found))
    off = np.mean(found, axis=0) - [hurst, *lengths]
    assert (np.abs(off) < 3 * error).all()
    # Single surfaces differ by 19 % at most, and the mean of eight by 19 %/√8.
    assert (error < 0.08 * np.array([hurst, *lengths])).all()


def test_a_surface_that_is_not_self_affine_shows_in_its_spectrum():
    heights = self_affine(Grid((256, 256), (1e-6, 1e-6)), 0.3e-6, 0.8, (10e-6, 10e-6), seed=4)
    smoothed = ndimage.gaussian_filter(heights, 4)
    assert fit_self_affine(smoothed, (1e-6, 1e-6)).misfit > 3


def test_heights_without_a_spectrum_are_refused():
    with pytest.raises(InputError, match="8 × 40 heights are too few"):
        fit_self_affine(np.zeros((8, 40)), (1e-6, 1e-6))

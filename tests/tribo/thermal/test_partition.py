"""Partition of heat between two bodies (tribo/thermal/partition.py)."""

import functools
import math
import pickle
import re

import numpy as np
import pytest

from tribo.errors import ConvergenceError
from tribo.material import Material
from tribo.numerics import Grid, padded_shape
from tribo.thermal import ConductingHalfSpace, partition_heat

STEEL = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
CERAMIC = Material(300e9, 0.25, 3.0, 5700.0, 450.0)
LINE, POINT, FLAT, TRACK = (False, True), (False, False), (True, True), (True, False)


def rough_contact(grid, share=0.15, seed=0):
    """Heat flux on islands that cover `share` of the grid."""
    rng = np.random.default_rng(seed)
    qx, qy = (np.fft.fftfreq(n) for n in grid.shape)
    smooth = np.exp(-60 * (qx[:, None] ** 2 + qy**2))
    height = np.fft.ifft2(np.fft.fft2(rng.standard_normal(grid.shape)) * smooth).real
    height -= np.quantile(height, 1 - share)
    return np.where(height > 0, np.sqrt(np.abs(height)) * 1e9, 0.0)


def bodies(grid, velocity=1.25, time=5.0, pin=STEEL, disk=STEEL):
    return (
        ConductingHalfSpace(grid, pin, 0.0, time),
        ConductingHalfSpace(grid, disk, velocity, time),
    )


def grid_of(periodic=LINE, n=48):
    return Grid((n, n), (1.632e-6, 1.9e-6), periodic)


def test_at_rest_the_shares_are_as_the_conductivities():
    # Equal diffusivities: both kernels have one shape, and heat divides as K.
    quick = Material(1e11, 0.3, 4 * 45.0, 4 * 7800.0, 470.0)
    grid = grid_of(n=24)
    flux = rough_contact(grid)
    split = partition_heat(*bodies(grid, 0.0, disk=quick), flux, flux > 0)
    assert split.pin_share == pytest.approx(0.2, rel=1e-7)


def eliminated(both, contact, target):
    """Heat flux by direct elimination with the dense kernel, as in the paper."""
    kernel = np.fft.irfft2(both.spectrum, s=padded_shape(both.grid))
    i, j = np.nonzero(contact)
    return np.linalg.solve(kernel[i[:, None] - i, j[:, None] - j], target)


@pytest.mark.parametrize("periodic", [LINE, POINT, FLAT, TRACK])
def test_the_iteration_finds_what_elimination_does(periodic):
    grid = grid_of(periodic, n=80)
    flux = rough_contact(grid)
    contact = flux > 0
    assert np.count_nonzero(contact) == 960
    pin, disk = bodies(grid)
    local = partition_heat(pin, disk, flux, contact, 1e-12, bulk_difference=-20.0)
    exact = np.zeros(grid.shape)
    exact[contact] = eliminated(pin + disk, contact, disk(flux)[contact] - 20.0)
    # 1e-12 in temperature; the flux is less certain by the kernel's condition number, below 1e3.
    rise = pin(exact)
    np.testing.assert_allclose(local.rise, rise, rtol=0, atol=1e-10 * rise.max())
    np.testing.assert_allclose(local.pin_flux, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert local.pin_share == pytest.approx(exact.sum() / flux.sum(), rel=1e-10)


@pytest.mark.parametrize("difference", [0.0, -30.0])
def test_the_contact_has_one_temperature(difference):
    grid = grid_of()
    flux = rough_contact(grid)
    pin, disk = bodies(grid, pin=CERAMIC)
    split = partition_heat(pin, disk, flux, flux > 0, bulk_difference=difference)
    pin_bulk, disk_bulk = 25.0, 25.0 + difference
    gap = (pin_bulk + split.rise - disk_bulk - disk(flux - split.pin_flux))[flux > 0]
    scale = (disk(flux) + difference)[flux > 0]
    mismatch = math.sqrt(np.mean(gap**2) / np.mean(scale**2))
    assert mismatch <= 1e-8  # the default tolerance
    assert mismatch == pytest.approx(split.residual, rel=1e-3, abs=1e-14)
    np.testing.assert_allclose(split.rise, pin(split.pin_flux), rtol=1e-12)


def test_friction_and_bulk_difference_superpose():
    # Due to this a single sweep answers for any friction and bulk temperature.
    grid = grid_of(n=32)
    flux = rough_contact(grid)
    friction, exchange, both = (
        partition_heat(*bodies(grid), q, flux > 0, tolerance=1e-12, bulk_difference=difference)
        for q, difference in [(flux, 0.0), (0 * flux, 40.0), (flux, 40.0)]
    )
    np.testing.assert_allclose(
        friction.rise + exchange.rise, both.rise, rtol=0, atol=1e-10 * both.rise.max()
    )
    assert exchange.rise.min() > 0  # the hotter disk warms the pin
    assert math.isnan(exchange.pin_share)


def test_a_failure_carries_the_partial_solution_and_advice():
    grid = grid_of()
    flux = rough_contact(grid)
    words = (
        r"heat partition stopped at a residual of \S+ after 4 iterations; the tolerance is "
        r"1\.0e-08\. Raise max_iterations or tolerance$"
    )
    with pytest.raises(ConvergenceError, match=words) as caught:
        partition_heat(*bodies(grid), flux, flux > 0, max_iterations=4)
    partial = pickle.loads(pickle.dumps(caught.value)).solution
    exact = partition_heat(*bodies(grid), flux, flux > 0)
    assert partial.iterations == 4
    assert 1e-8 < partial.residual < 0.1
    error = np.abs(partial.rise - exact.rise).max() / exact.rise.max()
    assert 1e-6 < error < 10 * partial.residual


def test_a_tolerance_below_rounding_is_refused_with_one_that_is_reached():
    grid = grid_of()
    flux = rough_contact(grid)
    pin, disk = bodies(grid)
    difference = -disk(flux) * (1 - 1e-6)  # of the heat a millionth has an effect
    partition = functools.partial(
        partition_heat, pin, disk, flux, flux > 0, bulk_difference=difference
    )
    words = r"Rounding allows no less; set it to at least (\S+)$"
    with pytest.raises(ConvergenceError, match=words) as caught:
        partition(tolerance=1e-14)
    advised = float(re.search(words, str(caught.value))[1])
    assert partition(tolerance=advised).residual <= advised

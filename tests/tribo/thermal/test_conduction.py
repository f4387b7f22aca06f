"""Thermal influence coefficients (tribo/thermal/conduction.py)."""

import itertools
import math

import numpy as np
import pytest
from scipy import integrate
from scipy.special import erf, erfc

from tests.helpers.closed_forms import MOVING_SQUARE_PEAK, moving_band_rise, uniform_flux_rise
from tribo.material import Material
from tribo.numerics import Grid, padded_shape
from tribo.thermal import ConductingHalfSpace, settling_time

STEEL = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
ELEMENT = (1.632e-6, 1.9e-6)
AXES = list(itertools.product((False, True), repeat=2))
# The documented errors of the quadrature, relative to the self term.
TEN_NODES, SIXTEEN_NODES = 7e-7, 6e-12

FREE, LINE, TRACK, FLAT = (False, False), (False, True), (True, False), (True, True)
NEAR_AND_FAR = [(0, 0), (1, 0), (-1, 0), (0, 1), (3, -2), (11, 0), (-11, 5)]
CASES = [  # shape, sides, periodic axes, velocity [m/s], time [s], offsets in elements
    # early, middle and late; at rest and moving
    *(
        ((12, 7), ELEMENT, axes, velocity, time, NEAR_AND_FAR)
        for axes in (FREE, LINE, TRACK, FLAT)
        for velocity, time in [
            (0.0, 3e-9), (0.0, 1e-6), (0.0, 1e-4), (1.25, 1e-6), (1.25, 1e-4), (-40.0, 2e-6),
        ]
    ),
    ((12, 7), ELEMENT, LINE, 1.25, 1e-2, [(0, 0), (11, 0), (-11, 5)]),
    ((12, 7), ELEMENT, FREE, 1.25, 5.0, [(11, 0)]),
    # many elements passed; many periods passed
    ((12, 7), ELEMENT, LINE, 2000.0, 1e-6, [(11, 0)]),
    ((12, 7), ELEMENT, FLAT, 2000.0, 3e-8, [(0, 0), (1, 0), (11, 0), (6, 1)]),
    ((5, 3), ELEMENT, TRACK, 300.0, 1e-6, [(0, 0), (2, 0), (-2, 1)]),
    # slender elements
    ((6, 5), (1e-6, 1e-3), LINE, 1.25, 1e-3, [(0, 0), (1, 0), (5, 0), (-5, 0), (0, 1)]),
    ((6, 5), (1e-3, 1e-6), LINE, 1.25, 1e-3, [(0, 0), (1, 0), (0, 1), (0, 2)]),
]  # fmt: skip


def thermal_influence(grid, material, velocity, time, nodes=10, length=math.inf):
    """Rise per unit heat flux on one element [K m²/W], in the order of the transform."""
    body = ConductingHalfSpace(grid, material, velocity, time, nodes, length)
    return np.fft.irfft2(body.spectrum, s=padded_shape(grid))


def source(position, side, period, spread):
    """∫ exp(−(place − x')²/spread²) dx' over an element and its images, over √π/2 · spread."""
    count = int(9 * spread / period) + 1 if period else 0
    nearest = round(-position / period) if period else 0
    middle = np.abs(position + period * np.arange(nearest - count, nearest + count + 1))
    low, high = (middle - side / 2) / spread, (middle + side / 2) / spread
    # Beyond 1 the complement keeps the digits of nearly equal values.
    return np.where(low > 1, erfc(low) - erfc(high), erf(high) - erf(low)).sum()


def entry(grid, velocity, time, offset):
    """Entry of the heat kernel [K m²/W], by integration over the time since heat was released.

    ∫₀^t dτ/(4ρc(πκτ)^{3/2}) ∫∫ exp(−[(x − Vτ − x')² + (y − y')²]/(4κτ)) dx' dy', of an insulated
    surface (Carslaw & Jaeger, §10.2), with τ = s².
    """
    kappa, capacity = STEEL.thermal_diffusivity, STEEL.density * STEEL.specific_heat
    (x, y), (dx, dy) = np.multiply(offset, grid.spacing), grid.spacing
    periods = np.where(grid.periodic, grid.size, 0.0)

    def heat(s):
        spread = 2 * math.sqrt(kappa) * s
        along = source(x - velocity * s**2, dx, periods[0], spread)
        return along * source(y, dy, periods[1], spread)

    end, V = math.sqrt(time), abs(velocity)
    start = min(end, min(dx, dy) / (40 * math.sqrt(kappa)), math.sqrt(dx / (40 * V + 1e-9)))
    breaks, total = [0.0, start], 0.0
    # Steps that neither double the spread nor move the source by more than one spread.
    while breaks[-1] < end:
        step = min(breaks[-1], math.sqrt(kappa) / V) if V else breaks[-1]
        breaks.append(min(breaks[-1] + step, end))
    for low, high in itertools.pairwise(breaks):
        total += integrate.fixed_quad(np.vectorize(heat), low, high, n=20)[0]
    return total / (2 * capacity * math.sqrt(math.pi * kappa))


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case[2:5])))
def test_entries_equal_the_heat_source_integral(case):
    *grid, velocity, time, offsets = case
    grid = Grid(*grid)
    expected = [entry(grid, velocity, time, offset) for offset in offsets]
    for nodes, error in ((10, TEN_NODES), (16, SIXTEEN_NODES)):
        kernel = thermal_influence(grid, STEEL, velocity, time, nodes)
        entries = [kernel[offset] for offset in offsets]
        np.testing.assert_allclose(entries, expected, rtol=0, atol=error * kernel[0, 0])


@pytest.mark.parametrize("peclet", [0.05, 1.0, 400.0])
def test_a_band_heats_a_moving_half_space_as_jaeger_found(peclet):
    half_width, n = 1e-4, 40
    velocity = peclet * 2 * STEEL.thermal_diffusivity / half_width
    grid = Grid((4 * n, 1), (2 * half_width / n, 1.0), periodic=(False, True))
    x = grid.coordinates(0)
    band = np.where(np.abs(x) < half_width, 1e8, 0.0)[:, None]
    rise = ConductingHalfSpace(grid, STEEL, velocity, time=1e7, quadrature_nodes=16)(band)
    exact = moving_band_rise(
        x, 1e8, half_width, velocity, STEEL.thermal_conductivity, STEEL.thermal_diffusivity
    )
    np.testing.assert_allclose(rise[:, 0], exact, rtol=0, atol=1e-9 * exact.max())


@pytest.mark.parametrize("peclet", MOVING_SQUARE_PEAK)
def test_a_moving_square_is_hottest_as_tabulated(peclet):
    half_side, n = 1e-5, 1501
    velocity = peclet * 2 * STEEL.thermal_diffusivity / half_side
    grid = Grid((n, 1), (2 * half_side / n, 2 * half_side), periodic=(False, False))
    rise = ConductingHalfSpace(grid, STEEL, velocity, time=1e6)(np.ones((n, 1)))[:, 0]
    peak = int(rise.argmax())
    left, middle, right = rise[peak - 1 : peak + 2]
    # Between elements, the peak of the parabola through the three hottest ones.
    height = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))
    scaled = height * STEEL.thermal_conductivity / half_side
    assert scaled == pytest.approx(MOVING_SQUARE_PEAK[peclet], rel=1e-5)  # six decimals tabulated


def summed(ny, images_per_side, velocity, time):
    """Kernel of 24 × ny elements as a sum over `images_per_side` periodic images on each side."""
    every = Grid((24, ny * (2 * images_per_side + 1)), ELEMENT, (False, False))
    free = thermal_influence(every, STEEL, velocity, time, 16)
    offsets = np.fft.fftfreq(ny, 1 / ny)
    return sum(
        free[:, (offsets + image * ny).round().astype(int)]
        for image in range(-images_per_side, images_per_side + 1)
    )


@pytest.mark.parametrize("ny", [8, 9])
@pytest.mark.parametrize("images_per_side", [0, 3])
@pytest.mark.parametrize(("velocity", "time"), [(0.0, 1e-6), (0.0, 1.0), (0.3, 1e-4), (-5.0, 1.0)])
def test_the_mean_along_a_pin_is_that_of_the_images_within_its_length(
    ny, images_per_side, velocity, time
):
    grid = Grid((24, ny), ELEMENT, (False, True))
    length = (2 * images_per_side + 1) * grid.size[1]
    kernel = thermal_influence(grid, STEEL, velocity, time, 16, length=length)
    images = summed(ny, images_per_side, velocity, time)
    scale = images.mean(axis=1).max()
    # With an even number of elements the images end half an element away from the pin's ends.
    half_image_error = (ELEMENT[1] / length) ** 2 if ny % 2 == 0 else 0.0
    np.testing.assert_allclose(
        kernel.mean(axis=1), images.mean(axis=1), rtol=0, atol=(half_image_error + 1e-10) * scale
    )
    # Variations along y hardly depend on the ends: seven periods are nearly infinitely many.
    if images_per_side == 3:
        np.testing.assert_allclose(kernel, images, rtol=0, atol=4e-3 * images.max())


@pytest.mark.parametrize("ny", [8, 9])
@pytest.mark.parametrize(("velocity", "time"), [(0.0, 1.0), (-5.0, 1.0)])
def test_the_nearest_image_is_added_as_it_leaks(ny, velocity, time):
    """Expected: T(x, |y|) + T(x, L − |y|), as in the elastic kernel "nearest-image"."""
    grid = Grid((24, ny), ELEMENT, (False, True))
    kernel = thermal_influence(grid, STEEL, velocity, time, 16, length="nearest-image")
    free = thermal_influence(Grid((24, 2 * ny), ELEMENT, (False, False)), STEEL, velocity, time, 16)
    y = np.abs(np.fft.fftfreq(ny, 1 / ny)).round().astype(int)
    expected = free[:, y] + free[:, ny - y]
    np.testing.assert_allclose(kernel, expected, rtol=0, atol=1e-10 * kernel.max())


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("spacing", [(1e-6, 1e-3), (1e-3, 1e-6)])
@pytest.mark.parametrize("velocity", [0.0, -1.25, 1e5])
def test_extremes_give_finite_kernels_that_create_no_heat(periodic, spacing, velocity):
    for shape, time in itertools.product([(1, 7), (5, 1), (6, 3)], [1e-15, 1e-4, 1e9]):
        kernel = thermal_influence(Grid(shape, spacing, periodic), STEEL, velocity, time)
        share = kernel.sum() / uniform_flux_rise(1.0, time, STEEL.thermal_effusivity)
        assert np.isfinite(kernel).all()
        assert kernel.min() >= -TEN_NODES * kernel[0, 0]
        if periodic == (True, True) or time == 1e-15:
            assert share == pytest.approx(1.0, rel=1e-11)
        else:
            assert 0 < share < 1 + 1e-11
        # On a very fast surface a free element's centre warms in one dimension, for a time a/V.
        # The correction is of the order of 1/√(2π Pe), and Pe = Va/2κ is above 2000.
        if abs(velocity) > 1e4 and time > 1e-5 and spacing[0] <= spacing[1] and not periodic[0]:
            passage = spacing[0] / 2 / abs(velocity)
            once = uniform_flux_rise(1.0, passage, STEEL.thermal_effusivity)
            assert kernel[0, 0] == pytest.approx(once, rel=0.02)


@pytest.mark.parametrize("n", [1, 240])
@pytest.mark.parametrize("velocity", [0.01, -1.25])
def test_a_kernel_has_settled_once_the_heat_of_one_end_has_passed_the_other(n, velocity):
    grid = Grid((n, 4), ELEMENT)
    # Without the margin of 0.1 %: heat from the edge of the first element has passed the centre of
    # the last one, with its rear six diffusion lengths, 2√(κt) each, behind.
    time = settling_time(grid, STEEL, velocity) / 1.001
    rear = abs(velocity) * time - 6 * 2 * math.sqrt(STEEL.thermal_diffusivity * time)
    assert rear == pytest.approx((n - 0.5) * ELEMENT[0], rel=1e-9)

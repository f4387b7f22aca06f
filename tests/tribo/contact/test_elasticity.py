import itertools

import numpy as np
import pytest

from tribo import Grid
from tribo.contact import ElasticHalfSpace
from tribo.numerics import padded_shape

UNIT = 1 / np.pi  # contact modulus with which the influence is ∫∫ 1/r


def elastic_influence(grid, contact_modulus, kernel="periodic"):
    """Displacement under unit pressure on one element [m/Pa], in the order of the transform."""
    solid = ElasticHalfSpace(grid, contact_modulus, kernel)
    return np.fft.irfft2(solid.spectrum, s=padded_shape(grid))


def love(x, y, dx, dy):
    """∫∫ 1/r over an element by Love's closed form, in long double precision."""
    x, y, a, b = (np.longdouble(value) for value in (x, y, dx / 2, dy / 2))

    def corner(x, y):
        along = x * np.arcsinh(y / np.abs(x)) if x else x
        return along + (y * np.arcsinh(x / np.abs(y)) if y else y)

    ends = itertools.product((1, -1), repeat=2)
    return sum(s * t * corner(x + s * a, y + t * b) for s, t in ends)


@pytest.mark.parametrize("dy", [1.0, 1.25, 100.0, 0.01, 1000.0, 0.001])
@pytest.mark.parametrize("index", [(0, 0), (1, 0), (0, 1), (3, 2), (19, 1), (25, 30), (200, 150)])
def test_free_kernel_equals_love(index, dy):
    i, j = index
    influence = elastic_influence(Grid((i + 1, j + 1), (1.0, dy), (False, False)), UNIT)
    expected = float(love(i, j * dy, 1.0, dy))
    assert influence[i, j] == pytest.approx(expected, abs=1e-13 * influence[0, 0])
    if max(i, j) > 20:  # far entries have their own relative accuracy
        assert influence[i, j] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("periodic", [(False, False), (False, True), (True, True)])
def test_the_self_influence_is_that_of_one_element_without_its_images(periodic):
    # Contacts hide it: it is the unit of their gaps, and scales the first step of the iteration.
    solid = ElasticHalfSpace(Grid((8, 6), (1.0, 1.25), periodic), UNIT)
    assert solid.self_influence == pytest.approx(float(love(0, 0, 1.0, 1.25)), rel=1e-14)


def by_images(x, y, dy, ny):
    """Influence of an element and all its images along y, minus that on itself.

    The error of a sum cut after n images falls as even powers of n + ½; these are eliminated.
    """
    counts, period = [16 * 2**k for k in range(6)], ny * dy
    total, sums = love(x, y, 1.0, dy) - love(0, 0, 1.0, dy), []
    for n in range(1, counts[-1] + 1):
        pair = love(x, y + n * period, 1.0, dy) + love(x, y - n * period, 1.0, dy)
        total += pair - 2 * love(0, n * period, 1.0, dy)
        sums += [total] if n in counts else []
    powers = np.array([[(n + 0.5) ** (-2 * k) for k in range(6)] for n in counts])
    return np.linalg.solve(powers, np.array(sums, float))[0]


PERIODIC = [
    (dy, ny, index)
    for dy, ny in ((1.25, 16), (300.0, 1), (0.2, 27), (1000.0, 7))
    for index in ((1, 0), (0, ny // 3), (0, ny // 2), (5, ny // 4), (40, 0), (60, ny // 2))
    if any(index)
]


@pytest.mark.parametrize("axis", [1, 0])
@pytest.mark.parametrize(("dy", "ny", "index"), PERIODIC)
def test_line_periodic_kernel_equals_the_extrapolated_sum_over_images(dy, ny, index, axis):
    order = slice(None, None, 1 if axis == 1 else -1)
    grid = Grid((2 * index[0] + 2, ny)[order], (1.0, dy)[order], (False, True)[order])
    influence = elastic_influence(grid, UNIT)
    difference = influence[index[order]] - influence[0, 0]
    self_term = ElasticHalfSpace(grid, UNIT).self_influence
    expected = by_images(float(index[0]), index[1] * dy, dy, ny)
    assert difference == pytest.approx(expected, abs=1e-12 * self_term)


def alternating(function):
    """Sum of (-1)^k function(k) over all integers k, by accelerated convergence."""
    terms = 30
    d = (3 + np.sqrt(8)) ** terms  # Cohen, Rodriguez Villegas & Zagier (2000), algorithm 1
    d = (d + 1 / d) / 2
    b, c, total = -1.0, -d, 0.0
    for k in range(terms):
        c = b - c
        total += c * (function(k) - function(-1 - k))
        b *= (k + terms) * (k - terms) / ((k + 0.5) * (k + 1))
    return total / d


def wave(mode, shape, spacing):
    """Fourier coefficient of the influence function, by a sum over aliased waves."""
    (mu, nu), (dx, dy) = np.divide(mode, shape), spacing
    if mode[0] == 0:  # all other waves along x have whole periods in an element
        return np.sin(np.pi * nu) / np.pi * alternating(lambda r: dy / ((nu + r) * abs(nu + r)))
    if mode[1] == 0:
        return wave(mode[::-1], shape[::-1], spacing[::-1])

    def along_y(u):
        return alternating(lambda r: 1 / ((nu + r) * np.hypot(u / dx, (nu + r) / dy)))

    series = alternating(lambda p: along_y(mu + p) / (mu + p))
    return np.sin(np.pi * mu) * np.sin(np.pi * nu) / np.pi**2 * series


WAVES = [
    (shape, dy, mode)
    for shape, dy in (
        ((256, 256), 1.0), ((512, 480), 1.25), ((27, 35), 0.9), ((1, 6), 1.0), ((5, 1), 7.0),
        ((16, 9), 1000.0), ((16, 9), 0.001),
    )
    for mode in ((1, 0), (0, 1), (1, 2), (3, 4), (shape[0] // 2, shape[1] // 2))
    if any(mode) and mode[0] <= shape[0] // 2 and mode[1] <= shape[1] // 2
]  # fmt: skip


@pytest.mark.parametrize(("shape", "dy", "mode"), WAVES)
@pytest.mark.parametrize("order", [1, -1])
def test_doubly_periodic_spectrum_equals_the_alternating_sum_over_waves(shape, dy, mode, order):
    grid = Grid(shape[::order], (1.0, dy)[::order], (True, True))
    spectrum = ElasticHalfSpace(grid, UNIT).spectrum
    assert spectrum[mode[::order]] == pytest.approx(wave(mode, shape, (1.0, dy)), rel=1e-13)


@pytest.mark.parametrize("order", [1, -1])
def test_nearest_image_kernel_is_the_element_and_its_image_one_period_back(order):
    (dx, dy), ny = (1.632e-6, 1.9e-6), 10
    axes = slice(None, None, order)
    grid = Grid((7, ny)[axes], (dx, dy)[axes], (False, True)[axes])
    influence = elastic_influence(grid, UNIT, "nearest-image")
    free_influence = elastic_influence(
        Grid((7, ny + 1)[axes], (dx, dy)[axes], (False, False)), UNIT
    )
    for i, j in ((0, 0), (0, 1), (3, 5), (6, 9), (2, 7)):
        index, nearest, image = (pair[axes] for pair in ((i, j), (i, j), (i, ny - j)))
        assert influence[index] == pytest.approx(
            free_influence[nearest] + free_influence[image], rel=1e-12
        )

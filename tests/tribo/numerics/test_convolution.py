import numpy as np
import pytest

from tribo import Grid, InputError
from tribo.numerics import Convolution, padded_shape

AXES = [(False, False), (False, True), (True, False), (True, True)]


def direct(grid, kernel, field):
    """The sum that defines the convolution, entry by entry."""
    (nx, ny), (mx, my) = grid.shape, padded_shape(grid)
    result = np.zeros(grid.shape)
    for i in range(nx):
        for j in range(ny):
            for k in range(nx):
                for m in range(ny):
                    result[i, j] += kernel[(i - k) % mx, (j - m) % my] * field[k, m]
    return result


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (7, 1), (2, 3), (5, 4), (6, 7)])
def test_equals_the_sum_that_defines_it(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(1)
    kernel, field = random.normal(size=padded_shape(grid)), random.normal(size=shape)
    convolve = Convolution(grid, np.fft.rfft2(kernel))
    expected = direct(grid, kernel, field)
    assert convolve(field) == pytest.approx(expected, abs=1e-13)  # rounding of about 40 terms
    assert convolve(field) == pytest.approx(expected, abs=1e-13)  # kept buffers carry nothing over


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [(7, 1), (5, 4), (6, 7)])
def test_rows_without_a_source_may_be_left_out(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(4)
    convolve = Convolution(grid, np.fft.rfft2(random.normal(size=padded_shape(grid))))
    field = random.normal(size=shape)
    convolve(field)  # kept buffers carry nothing over
    field[:2], field[4:] = 0.0, 0.0
    for one in (convolve, convolve.single_precision()):
        assert one(field, rows=(2, 4))[2:4] == pytest.approx(one(field)[2:4], abs=1e-14)


@pytest.mark.parametrize("periodic", AXES)
def test_on_a_part_of_the_patch_the_map_is_the_same(periodic):
    grid = Grid((9, 7), (1.0, 0.5), periodic)
    random = np.random.default_rng(5)
    convolve = Convolution(grid, np.fft.rfft2(random.normal(size=padded_shape(grid))))
    part = tuple(n if p else n - 3 for n, p in zip(grid.shape, periodic, strict=True))
    window = tuple(slice(n - m, n) for n, m in zip(grid.shape, part, strict=True))
    field = np.zeros(grid.shape)
    field[window] = random.normal(size=part)
    cropped = convolve.cropped(part)
    assert cropped(field[window]) == pytest.approx(convolve(field)[window], abs=1e-13)
    assert cropped.grid.spacing == grid.spacing


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [(8, 6), (1, 6), (8, 1)])
def test_on_a_coarser_grid_it_maps_means_to_means(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(6)
    convolve = Convolution(grid, np.fft.rfft2(random.normal(size=padded_shape(grid))))
    coarse = convolve.coarsened()
    (nx, ny), (fx, fy) = coarse.grid.shape, (min(n, 2) for n in shape)
    means = random.normal(size=(nx, ny))
    fine = convolve(means.repeat(fx, 0).repeat(fy, 1))
    expected = fine.reshape(nx, fx, ny, fy).mean(axis=(1, 3))
    assert coarse(means) == pytest.approx(expected, abs=1e-13)
    assert coarse.grid.size == grid.size


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [(1, 1), (5, 4), (6, 7)])
def test_single_precision_keeps_seven_digits(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(3)
    convolve = Convolution(grid, np.fft.rfft2(random.normal(size=padded_shape(grid))))
    single = convolve.single_precision()
    for _ in range(2):  # kept buffers carry nothing over
        field = random.normal(size=shape)
        exact = convolve(field)
        # Some tens of roundings of 6e-8 each.
        assert single(field) == pytest.approx(exact, abs=2e-6 * max(1.0, np.abs(exact).max()))
        assert single(field).dtype == np.float64


@pytest.mark.parametrize("influence", [1e-30, 1e30])
def test_single_precision_is_taken_only_where_it_holds_the_influence(influence):
    grid = Grid((80, 80), (1.0, 1.0))
    convolve = Convolution(grid, np.fft.rfft2(np.ones(padded_shape(grid))))
    assert convolve.faster_precision(1.0).rounding > convolve.rounding
    assert convolve.faster_precision(influence).rounding == convolve.rounding
    small = Grid((8, 8), (1.0, 1.0))  # on which it would gain nothing
    convolve = Convolution(small, np.fft.rfft2(np.ones(padded_shape(small))))
    assert convolve.faster_precision(1.0) is convolve


def test_a_spectrum_of_the_wrong_shape_is_refused():
    with pytest.raises(InputError, match=r"shape \(4, 4\); this grid needs \(7, 3\)"):
        Convolution(Grid((4, 4), (1.0, 1.0)), np.ones((4, 4)))

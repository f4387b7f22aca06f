import numpy as np
import pytest

from tribo import Grid
from tribo.numerics import Convolution, padded_shape

AXES = [(False, False), (False, True), (True, False), (True, True)]


def direct(grid, kernel, field):
    """Convolution by its defining sum, entry by entry."""
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
    assert convolve(field) == pytest.approx(expected, abs=1e-13)  # reused buffers change nothing


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

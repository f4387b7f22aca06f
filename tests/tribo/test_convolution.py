import numpy as np
import pytest

from tribo import Convolution, Grid, InputError
from tribo.convolution import padded_shape, wrapped_offsets

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
@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (7, 1), (5, 4), (6, 7)])
def test_equals_the_sum_that_defines_it(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(1)
    kernel, field = random.normal(size=padded_shape(grid)), random.normal(size=shape)
    convolve = Convolution.from_kernel(grid, kernel)
    expected = direct(grid, kernel, field)
    assert convolve(field) == pytest.approx(expected, abs=1e-13)  # rounding of about 40 terms
    assert convolve(field) == pytest.approx(expected, abs=1e-13)  # kept buffers carry nothing over


def test_result_goes_where_it_is_asked_to():
    grid = Grid((4, 6), (1.0, 1.0))
    convolve = Convolution.from_kernel(grid, np.ones(padded_shape(grid)))
    out = np.empty(grid.shape)
    assert convolve(np.ones(grid.shape), out=out) is out
    assert out == pytest.approx(24.0)


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [(1, 1), (5, 4), (6, 7)])
def test_single_precision_keeps_seven_digits(shape, periodic):
    grid = Grid(shape, (1.0, 0.5), periodic)
    random = np.random.default_rng(3)
    convolve = Convolution.from_kernel(grid, random.normal(size=padded_shape(grid)))
    single = convolve.in_single_precision()
    for _ in range(2):  # kept buffers carry nothing over
        field = random.normal(size=shape)
        exact = convolve(field)
        # Some tens of roundings of 6e-8 each.
        assert single(field) == pytest.approx(exact, abs=2e-6 * max(1.0, np.abs(exact).max()))
        assert single(field).dtype == np.float64


def test_maps_add():
    grid = Grid((4, 6), (1.0, 1.0))
    random = np.random.default_rng(2)
    first, second = (
        Convolution.from_kernel(grid, random.normal(size=padded_shape(grid))) for _ in range(2)
    )
    field = random.normal(size=grid.shape)
    assert (first + second)(field) == pytest.approx(first(field) + second(field), abs=1e-13)


@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("n", [1, 2, 5, 8, 101])
def test_every_offset_between_two_elements_has_its_place(periodic, n):
    grid = Grid((n, n), (1.0, 1.0), periodic)
    for axis in (0, 1):
        offsets = wrapped_offsets(grid, axis)
        if periodic[axis]:
            assert sorted(offsets % n) == list(range(n))
        else:
            index = np.arange(-(n - 1), n)
            assert offsets[index].tolist() == index.tolist()


def test_a_spectrum_of_the_wrong_shape_is_refused():
    with pytest.raises(InputError, match="shape"):
        Convolution(Grid((4, 4), (1.0, 1.0)), np.ones((4, 4)))

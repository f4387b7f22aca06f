"""Tests of stencils that approximate a convolution among neighbours."""

import numpy as np

from tribo.numerics import Convolution, Grid, Neighbourhood


def test_an_inverse_that_could_not_precondition_is_that_of_the_element_alone():
    kernel = np.zeros((8, 8))
    kernel[0, 0], kernel[0, [1, -1]] = 2.0, 1.9
    grid = Grid(kernel.shape, (1.0, 1.0), periodic=(True, True))
    inverse = Neighbourhood(Convolution(grid, np.fft.rfft2(kernel).real)).inverse
    np.testing.assert_allclose(inverse, [[0, 0], [0.5, 0], [0, 0]])

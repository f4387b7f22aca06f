"""Correlations of unknown inputs that fit together, and the values that are left for one."""

import math

import numpy as np
import pytest

from pipeline.scene.correlation import allowed, first_unfit


@pytest.mark.parametrize("last", [-0.5, 0.0, 0.99])
def test_what_is_allowed_is_what_makes_the_matrix_positive_definite(last):
    matrix = np.array([[1.0, 0.8, last], [0.8, 1.0, 0.5], [last, 0.5, 1.0]])
    low, high = allowed(matrix, 2, 0)
    # By the closed form of three: the product of two, give or take that of their complements.
    half = math.sqrt((1 - 0.8**2) * (1 - 0.5**2))
    assert (low, high) == pytest.approx((0.4 - half, 0.4 + half), abs=1e-5)
    for value, is_fit in ((low - 1e-5, False), (low + 1e-5, True), (high + 1e-5, False)):
        matrix[2, 0] = matrix[0, 2] = value
        assert (np.linalg.eigvalsh(matrix).min() > 0) == is_fit
        assert (first_unfit(matrix) is None) == is_fit


def test_no_value_is_allowed_where_others_contradict_each_other():
    matrix = np.eye(4)
    for i, j, value in ((1, 0, 0.9), (2, 0, 0.9), (3, 1, 0.9), (3, 2, -0.9), (2, 1, 0.8)):
        matrix[i, j] = matrix[j, i] = value
    assert first_unfit(matrix) == 3
    assert allowed(matrix, 3, 0) is None

"""The metric of soft rows (tribo/contact/rows.py)."""

import numpy as np
import pytest
from scipy.linalg import cholesky
from scipy.optimize import brentq, lsq_linear

from tribo import ElasticHalfSpace, Grid, Wear, self_affine, solve_contact
from tribo.contact.rows import RowMetric

SHAPE = (5, 4)
NODES = np.array([0, 1, 2, 5, 6, 7, 9, 16, 17, 18, 19])  # row 3 is left out, row 2 holds one


def dense(d, c):
    """M of Eq. (1) as a matrix."""
    rows = NODES // SHAPE[1]
    return d * np.eye(len(NODES)) + c / SHAPE[1] * (rows[:, None] == rows)


@pytest.mark.parametrize("c", [1.0, 1e3])
@pytest.mark.parametrize("highest", [np.inf, 0.8])
def test_nearest_equals_bounded_least_squares(c, highest):
    metric, matrix = RowMetric(2.0, c / SHAPE[1], NODES // SHAPE[1]), dense(2.0, c)
    q, total = np.random.default_rng(1).normal(size=len(NODES)), 3.0
    root = cholesky(matrix)

    def carried(mu):
        target = root @ q + np.linalg.solve(root.T, np.full(len(q), mu))
        return lsq_linear(root, target, bounds=(0, highest), method="bvls", tol=1e-15).x

    mu = brentq(lambda mu: carried(mu).sum() - total, -10 * c - 10, 10 * c + 10, xtol=1e-13)
    nearest = metric.nearest(q, total, highest)
    assert nearest == pytest.approx(carried(mu), abs=1e-9)
    assert nearest.sum() == pytest.approx(total, rel=1e-14)


@pytest.mark.parametrize("softness", [1.0, 1e8])
@pytest.mark.parametrize("hardness", [np.inf, 3e9])
def test_iterations_do_not_grow_with_the_wear_of_a_step(softness, hardness):
    grid = Grid((64, 64), (2e-6, 2e-6))
    solid = ElasticHalfSpace(grid, 115e9)
    z = grid.coordinates(0)[:, None] ** 2 / 4e-3 - self_affine(grid, 0.2e-6, 0.8, 6e-6, 0)
    rate = softness * solid.self_influence * grid.shape[1]
    worn = Wear(rate, "swept").yielding(solid, 1.0)
    contact = solve_contact(worn, z, 0.02 * 6.6e9 * grid.area, hardness, tolerance=1e-6)
    assert contact.residual <= 1e-6
    # 21 to 33; without the metric up to 88 at a softness of 1, and none from 100 on
    assert contact.iterations < 60

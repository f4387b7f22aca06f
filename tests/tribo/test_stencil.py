"""Stencils of neighbours (tribo/stencil.py)."""

import numpy as np
import pytest

from tribo import ElasticHalfSpace, Grid, self_affine
from tribo.stencil import Neighbourhood, Preconditioner

PERIODIC = [(False, False), (False, True), (True, False), (True, True)]


def some_nodes(shape, seed=0):
    return np.flatnonzero(np.random.default_rng(seed).uniform(size=shape) < 0.4)


def dense(apply, size):
    return np.array([apply(unit) for unit in np.eye(size)]).T


@pytest.mark.parametrize("periodic", PERIODIC)
@pytest.mark.parametrize("shape", [(7, 9), (3, 3), (12, 1), (1, 12), (2, 8)])
def test_a_stencil_is_the_map_as_far_as_it_reaches(shape, periodic):
    grid = Grid(shape, (1e-6, 1.5e-6), periodic)
    solid = ElasticHalfSpace(grid, 115e9)
    nodes = some_nodes(shape)
    near = Neighbourhood(solid)
    stencil = dense(lambda values: near.on(nodes)(near.influence, values), nodes.size)

    def whole(values):
        field = np.zeros(shape)
        field.reshape(-1)[nodes] = values
        return solid(field).take(nodes)

    i, j = np.divmod(nodes, shape[1])
    distances = []
    for index, n, wraps in ((i, shape[0], periodic[0]), (j, shape[1], periodic[1])):
        apart = np.abs(index[:, None] - index)
        distances.append(np.minimum(apart, n - apart) if wraps else apart)
        # Of one or two elements, none has a neighbour of its own on each side.
        distances[-1] = np.where(apart > 0, distances[-1] + (2 if n < 3 else 0), 0)
    reached = np.maximum(*distances) <= 1
    assert stencil == pytest.approx(
        np.where(reached, dense(whole, nodes.size), 0.0), abs=1e-6 * solid.self_influence
    )


@pytest.mark.parametrize("periodic", PERIODIC)
def test_its_inverse_undoes_the_worst_condition(periodic):
    grid = Grid((24, 24), (1e-6, 1e-6), periodic)
    solid = ElasticHalfSpace(grid, 115e9)
    nodes = np.flatnonzero(self_affine(grid, 1e-6, 0.8, 5e-6, 0) > 0)
    near = Neighbourhood(solid)
    inverse = dense(lambda values: near.on(nodes)(near.inverse, values), nodes.size)
    assert inverse == pytest.approx(inverse.T, rel=1e-5)
    assert np.linalg.eigvalsh(inverse).min() > 0
    i, j = np.divmod(nodes, 24)
    kernel = np.fft.irfft2(solid.spectrum, s=[24 if p else 48 for p in periodic])
    matrix = kernel[i[:, None] - i, j[:, None] - j]
    # All but what one constant more or less decides about.
    plain = np.linalg.eigvalsh(matrix)
    undone = np.sort(np.linalg.eigvals(inverse @ matrix).real)
    assert undone[-2] / undone[1] < plain[-2] / plain[1] / 2


@pytest.mark.parametrize("coupling", [0.0, 0.1, 10.0, 1e6])
def test_the_preconditioner_is_symmetric_positive_and_keeps_the_load(coupling):
    grid = Grid((12, 10), (1e-6, 1e-6))
    solid = ElasticHalfSpace(grid, 115e9)
    nodes = some_nodes(grid.shape)
    coupling *= solid.self_influence
    near = Neighbourhood(solid, 1, coupling)
    precondition = Preconditioner(
        lambda residual: near.on(nodes)(near.inverse, residual), nodes // 10, coupling
    )
    matrix = dense(precondition, nodes.size)
    scale = np.abs(matrix).max()
    beyond_rows = 0 < coupling < 0.3 * solid.self_influence
    assert matrix == pytest.approx(matrix.T, abs=(0.1 if beyond_rows else 1e-6) * scale)
    assert np.abs(matrix.sum(axis=0)).max() < 1e-12 * scale
    # Positive but for the constant, which the load decides about.
    assert np.linalg.eigvalsh((matrix + matrix.T) / 2)[1] > 0

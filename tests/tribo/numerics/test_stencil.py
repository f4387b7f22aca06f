"""What elements do to their next neighbours, and what undoes it (tribo/numerics/stencil.py)."""

import itertools

import numpy as np
import pytest

from tribo import Grid
from tribo.numerics import Convolution, Neighbourhood, Preconditioner, padded_shape

AXES = [(False, False), (False, True), (True, False), (True, True)]
SHAPES = [(6, 5), (7, 1), (1, 6), (2, 4), (5, 2), (3, 3)]
NEAR = list(itertools.product((-1, 0, 1), repeat=2))


def falling(grid, is_even):
    """A kernel that falls off as the distance, even along y, and along x if so said."""
    offsets = (np.minimum(np.arange(n), n - np.arange(n)) for n in padded_shape(grid))
    i, j = np.meshgrid(*offsets, indexing="ij")
    kernel = 1 / (1.0 + 2.0 * np.hypot(i, 1.2 * j))
    if not is_even:  # downstream it is warmer
        kernel[1 : (len(kernel) + 1) // 2] *= 1.5
    return kernel


def neighbourhood(shape, periodic, is_even=True, **coupling):
    grid = Grid(shape, (1.0, 1.0), periodic)
    kernel = falling(grid, is_even)
    spectrum = np.fft.rfft2(kernel)
    if is_even:
        spectrum = spectrum.real
    return kernel, Neighbourhood(Convolution(grid, spectrum), **coupling)


def reach(n):
    """Of two elements along a periodic axis each is the neighbour of the other on both sides."""
    return 1 if n > 2 else 0


def block_inverse(kernel, rx, ry):
    """What a unit at the middle of a block has to be on its elements, by elimination."""
    block = list(itertools.product(range(-rx, rx + 1), range(-ry, ry + 1)))
    matrix = np.array([[kernel[i - k, j - m] for k, m in block] for i, j in block])
    column = np.linalg.inv(matrix)[:, block.index((0, 0))]
    return dict(zip(block, column, strict=True))


@pytest.mark.parametrize("is_even", [False, True])
@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", SHAPES)
def test_stencils_are_the_kernel_and_the_middle_of_the_inverse_of_a_block(shape, periodic, is_even):
    kernel, near = neighbourhood(shape, periodic, is_even)
    rx, ry = map(reach, shape)
    inverse = block_inverse(kernel, rx, ry)
    for i, j in NEAR:
        is_in_reach = abs(i) <= rx and abs(j) <= ry
        expected = kernel[i, j] if is_in_reach else 0.0
        assert near.influence[1 + i, abs(j)] == pytest.approx(expected, abs=1e-14)
        assert near.inverse[1 + i, abs(j)] == pytest.approx(inverse.get((i, j), 0.0), abs=1e-12)


@pytest.mark.parametrize("soft_axis", [0, 1])
@pytest.mark.parametrize(("coupling", "is_rigid"), [(0.05, False), (0.25, True)])
def test_coupling_within_rows_is_left_out_and_where_it_is_much_other_rows_are(
    soft_axis, coupling, is_rigid
):
    """Much is 0.3 of what an element does to itself without it, which is 1 with it."""
    kernel, near = neighbourhood((6, 5), (True, True), soft_axis=soft_axis, coupling=coupling)
    assert near.influence[1, 0] == pytest.approx(kernel[0, 0])  # which has it still
    own = kernel.copy()
    if soft_axis:
        own[0, :] -= coupling
    else:
        own[:, 0] -= coupling
    rx, ry = ((0, 1) if soft_axis else (1, 0)) if is_rigid else (1, 1)
    inverse = block_inverse(own, rx, ry)
    for i, j in NEAR:
        assert near.inverse[1 + i, abs(j)] == pytest.approx(inverse.get((i, j), 0.0), abs=1e-12)


ALONE = np.full((6, 5), 0.9)
ALONE[0, 0] = 1.0
ALONE[:, [1, 4]] *= -1.0


@pytest.mark.parametrize(
    ("kernel", "middle"),
    [
        (2.0 * ALONE, 0.5),  # neighbours nearly as strong as the element, of either sign
        (-2.0 * ALONE, 1.0),  # it cools where it is heated
        (np.full((6, 5), 4.0), 0.25),  # all alike, which nothing undoes
        (np.zeros((6, 5)), 1.0),
    ],
)
def test_where_a_block_has_no_dominant_middle_each_element_stands_alone(kernel, middle):
    grid = Grid(kernel.shape, (1.0, 1.0), (True, True))
    near = Neighbourhood(Convolution(grid, np.fft.rfft2(kernel).real))
    assert near.inverse.tolist() == [[0.0, 0.0], [pytest.approx(middle), 0.0], [0.0, 0.0]]


def applied(stencil, shape, periodic, nodes, values):
    """The sum over neighbours among the nodes, one by one."""
    (nx, ny), at = shape, dict(zip(nodes.tolist(), values.tolist(), strict=True))
    result = []
    for i, k in (divmod(node, ny) for node in nodes.tolist()):
        total = 0.0
        for di, dk in NEAR:
            x, y = i - di, k - dk
            if periodic[0]:
                x %= nx
            if periodic[1]:
                y %= ny
            if 0 <= x < nx and 0 <= y < ny:
                total += stencil[1 + di, abs(dk)] * at.get(x * ny + y, 0.0)
        result.append(total)
    return np.array(result)


@pytest.mark.parametrize("is_even", [False, True])
@pytest.mark.parametrize("periodic", AXES)
@pytest.mark.parametrize("shape", [*SHAPES, (9, 6)])
def test_on_nodes_a_stencil_is_the_sum_over_the_neighbours_among_them(shape, periodic, is_even):
    random = np.random.default_rng(7)
    _, near = neighbourhood(shape, periodic, is_even)
    count = shape[0] * shape[1]
    for nodes in (
        np.flatnonzero(random.random(count) < 0.6),
        np.arange(count),
        np.arange(count)[count // 3 : count // 3 + 2],  # rows at both ends hold none
    ):
        apply = near.on(nodes)
        for stencil in (near.influence, near.inverse, near.influence):
            values = 1e-9 * random.normal(size=nodes.size)
            expected = applied(stencil, shape, periodic, nodes, values)
            # Neighbours count in single precision.
            tolerance = 1e-6 * np.abs(values).max(initial=0.0)
            assert apply(stencil, values) == pytest.approx(expected, abs=tolerance)
        assert apply(near.influence, np.zeros(nodes.size)).tolist() == [0.0] * nodes.size


@pytest.mark.parametrize("coupling", [0.0, 0.4, 30.0])
def test_a_preconditioner_is_the_inverse_at_constant_load_where_rows_are_coupled(coupling):
    """With rows that yield as a whole, and stencils that stay within them."""
    random = np.random.default_rng(3)
    rows = np.array([0, 0, 0, 1, 2, 2, 2, 2])
    within = random.normal(size=(8, 8)) * 0.2
    stencil = np.where(rows[:, None] == rows, within + within.T, 0.0) + 2 * np.eye(8)
    solid = np.linalg.inv(stencil) + coupling * (rows[:, None] == rows)
    residual = random.normal(size=8)
    free, even = np.linalg.solve(solid, residual), np.linalg.solve(solid, np.ones(8))
    expected = free - even * free.sum() / even.sum()
    preconditioner = Preconditioner(lambda r: stencil @ r, rows, coupling)
    for _ in range(2):
        found = preconditioner(residual)
        assert found == pytest.approx(expected, abs=1e-13)
        assert found.sum() == pytest.approx(0.0, abs=1e-13)

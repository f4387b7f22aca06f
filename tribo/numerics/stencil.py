"""Stencils of 3 × 3 elements: the middle of a kernel, and its approximate inverse.

A kernel that falls off like 1/r is worst conditioned for short waves, where only the nearest
neighbours of an element matter. The stencil of its inverse is the middle column of the inverted
kernel of a block of 3 × 3 elements. It can be used on a set of nodes of any shape. Conjugate
gradients preconditioned with it need half the iterations; applying it takes a tenth to a fifth of a
convolution.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tribo.numerics.convolution import Convolution, padded_shape
from tribo.numerics.grid import largest
from tribo.types import Array, Nodes

# Coupling within rows, relative to an element's influence on itself. Above this value, the exact
# inverse of the influence within a row preconditions better than one that includes other rows.
_STRONG_COUPLING = 0.3


class Neighbourhood:
    """Stencils that approximate a convolution among neighbours, and its inverse.

    The kernel must be even along y.

    A stencil, shape (3, 2), has the factors of the elements at −1, 0 and 1 along x, and 0 and ±1
    along y. `influence` has the middle values of the kernel. `inverse` inverts the kernel without
    the coupling on a block of 3 × 3 elements, or on 3 elements of a row if the coupling is strong;
    if this could not precondition, `inverse` has only its middle factor. The `coupling` is the
    displacement that elements of a row along `soft_axis` add to each other at any distance (see
    `tribo.contact.soft_rows`). `Preconditioner` adds it to `inverse`.

    Examples
    --------
    >>> from tribo.numerics.grid import Grid
    >>> grid = Grid((4, 4), (1.0, 1.0), periodic=(True, True))
    >>> kernel = np.zeros((4, 4))
    >>> kernel[0, 0], kernel[0, 1], kernel[0, 3] = 1.0, 0.2, 0.2
    >>> near = Neighbourhood(Convolution(grid, np.fft.rfft2(kernel).real))
    >>> nodes = np.array([0, 1, 3, 10])  # (0, 3) is next to (0, 0); (2, 2) has no neighbours
    >>> apply = near.stencil_on(nodes)
    >>> apply(near.influence, np.array([1.0, 2.0, 0.0, 1.0])).round(6)
    array([1.4, 2.2, 0.2, 1. ])
    """

    def __init__(self, convolution: Convolution, soft_axis: int = 0, coupling: float = 0.0) -> None:
        (nx, ny), self._periodic = convolution.grid.shape, convolution.grid.periodic
        self._shape, self._is_even = (nx, ny), np.isrealobj(convolution.spectrum)
        rx, ry = min(1, (nx - 1) // 2), min(1, (ny - 1) // 2)
        kernel = _central_kernel(convolution)
        self.influence = np.zeros((3, 2))
        self.influence[1 - rx : 2 + rx, : 1 + ry] = kernel[2 - rx : 3 + rx, : 1 + ry]
        row = kernel[2, :] if soft_axis else kernel[:, 0]
        row -= coupling
        if coupling > _STRONG_COUPLING * kernel[2, 0]:
            rx, ry = (0, ry) if soft_axis else (rx, 0)
        self.inverse = _inverse_stencil(kernel, rx, ry)
        # Conjugate gradients need a stencil that is positive definite on any set of nodes, which a
        # dominant middle ensures. A kernel that is not even along x is not symmetric anyway.
        middle, total = self.inverse[1, 0], self.inverse.sum() + self.inverse[:, 1].sum()
        dominant = np.count_nonzero(self.inverse > 0) == 1 and 0 < total < np.inf
        if not (dominant if self._is_even else 0 < middle < np.inf):
            self.inverse = np.zeros((3, 2))
            self.inverse[1, 0] = 1 / kernel[2, 0] if kernel[2, 0] > 0 else 1.0

    def stencil_on(self, nodes: Nodes) -> Callable[[Array, Array], Array]:
        """Return a function that applies a stencil to values at `nodes`, ascending flat indices.

        The function takes the stencil and the values, and returns new values at the same nodes,
        computed in single precision. Threads must not share the function.
        """
        return _NodeStencil(nodes, self._shape, self._periodic, self._is_even)


class _NodeStencil:
    """Applies stencils to values at some nodes.

    Fields are padded by one element and flattened. Rows before the first and after the last node
    are omitted. Single precision takes half the time, and suffices for a search direction.
    """

    def __init__(
        self, nodes: Nodes, shape: tuple[int, int], periodic: tuple[bool, bool], is_even: bool
    ) -> None:
        (nx, ny), self._periodic, self._is_even = shape, periodic, is_even
        low, high = (0, nx) if periodic[0] else (int(nodes[0]) // ny, int(nodes[-1]) // ny + 1)
        self._row_length = ny + 2
        self._padded_nodes = nodes + 2 * (nodes // ny) + (1 + (1 - low) * self._row_length)
        self._flat, self._y_neighbours, self._to_upper, self._total = np.empty(
            (4, (high - low + 2) * self._row_length), dtype=np.float32
        )
        self._flat[...] = 0.0
        self._y_neighbours[[0, -1]] = 0.0

    def __call__(self, stencil: Array, values: Array) -> Array:
        """Values at the nodes after the stencil has been applied to `values` at the nodes."""
        flat, y_neighbours, to_upper = self._flat, self._y_neighbours, self._to_upper
        lower, centre, upper = (stencil / stencil[1, 0]).astype(np.float32)
        scale = largest(values)
        if scale == 0.0:
            return np.zeros(values.size)
        # Faster than casting on assignment.
        flat[self._padded_nodes] = (values / scale).astype(np.float32)
        field = flat.reshape(-1, self._row_length)
        if self._periodic[1]:
            field[:, 0], field[:, -1] = field[:, -2], field[:, 1]
        if self._periodic[0]:
            field[0], field[-1] = field[-2], field[1]
        np.add(flat[:-2], flat[2:], out=y_neighbours[1:-1])
        to_lower = self._weight(lower, to_upper)
        if not self._is_even:
            to_lower = self._weight(lower, np.empty_like(to_upper))
            self._weight(upper, to_upper)
        np.multiply(y_neighbours, centre[1], out=y_neighbours)
        np.add(
            to_upper[: -2 * self._row_length],
            to_lower[2 * self._row_length :],
            out=self._total[self._row_length : -self._row_length],
        )
        np.add(self._total, y_neighbours, out=self._total)
        result: Array = self._total.take(self._padded_nodes) * np.float64(scale)
        result += values
        result *= stencil[1, 0]
        return result

    def _weight(self, factors: Array, out: NDArray[np.float32]) -> NDArray[np.float32]:
        """Sum of the field and its neighbours along y, times their factors, written to `out`."""
        np.multiply(self._y_neighbours, factors[1], out=self._total)
        np.multiply(self._flat, factors[0], out=out)
        return np.add(out, self._total, out=out)


class Preconditioner:
    """Approximate inverse of a solid's map from pressure to displacement, on a subset of nodes.

    Called with a residual of the displacement at the nodes, it returns a search direction for their
    pressure.

    The stencil S inverts the influence of neighbouring elements. In addition, the pressures p of a
    row i displace the whole row by k·Σp (see `tribo.contact.soft_rows`). The approximate inverse of
    both is

        S − Σᵢ yᵢ(S1ᵢ)ᵀ k/(1 + k·Σyᵢ),   yᵢ the part of S·1 in row i,                           (1)

    where the vector 1 is 1 at all nodes, and 1ᵢ is 1 only at the nodes of row i. The direction is
    then shifted to sum to 0, so that the load stays constant. If the stencil stays
    within a row, yᵢ is S1ᵢ, and (1) is the exact inverse of S⁻¹ + k Σᵢ 1ᵢ1ᵢᵀ. If the stencil
    reaches into other rows, k must be small; then (1) is nearly symmetric, too.

    `inverse` applies the stencil S at the nodes, `rows` has the row of each node, and `coupling` is
    k.

    Examples
    --------
    Two soft rows of two nodes: a difference between the rows counts less than one within a row.

    >>> soft = Preconditioner(lambda r: r.copy(), rows=np.array([0, 0, 1, 1]), coupling=2.0)
    >>> soft(np.array([5.0, 5.0, 0.0, 0.0])), soft(np.array([1.0, -1.0, 0.0, 0.0]))
    (array([ 0.5,  0.5, -0.5, -0.5]), array([ 1., -1.,  0.,  0.]))
    """

    def __init__(self, inverse: Callable[[Array], Array], rows: Nodes, coupling: float) -> None:
        self._inverse, self._rows = inverse, rows
        self._unit_response = self._load_shift = inverse(np.ones(rows.size))
        self._row_weight: Array | None = None
        if coupling:
            stiffness = 1 + coupling * np.bincount(rows, self._unit_response)
            self._row_weight = np.asarray(coupling / stiffness)
            self._load_shift = self._unit_response / stiffness[rows]
        self._load_shift = self._load_shift / float(self._load_shift.sum())

    def __call__(self, residual: Array) -> Array:
        """Return the search direction for a residual; the direction sums to 0."""
        direction = self._inverse(residual)
        if self._row_weight is not None:
            row_sums = self._row_weight * np.bincount(self._rows, direction)
            direction -= self._unit_response * row_sums[self._rows]
        direction -= self._load_shift * float(direction.sum())
        return direction


def _inverse_stencil(kernel: Array, rx: int, ry: int) -> Array:
    """Stencil (3, 2) whose response on a block (2 rx + 1, 2 ry + 1) is 1 in the middle, else 0."""
    i, j, middle = _block_offsets(rx, ry)
    inverse = np.zeros((3, 2))
    try:
        column = np.linalg.solve(kernel[2 + i[:, None] - i, np.abs(j[:, None] - j)], middle)
    except np.linalg.LinAlgError:
        column = 0 * middle
    inverse[1 + i, np.abs(j)] = column
    return inverse


@functools.cache
def _block_offsets(rx: int, ry: int) -> tuple[Nodes, Nodes, Array]:
    """Flat offsets along x and y of a block's elements, and its middle element as a unit vector."""
    i, j = (steps.ravel() for steps in np.mgrid[-rx : rx + 1, -ry : ry + 1])
    return i, j, np.where((i == 0) & (j == 0), 1.0, 0.0)


def _central_kernel(convolution: Convolution) -> Array:
    """The kernel at the offsets -2 to 2 along x, and 0 to 2 along y, shape (5, 3)."""
    even, odd, wave_y = _waves(*padded_shape(convolution.grid))
    spectrum = convolution.spectrum
    profiles = (even @ spectrum.real)[[2, 1, 0, 1, 2]]
    if np.iscomplexobj(spectrum):
        odd_part = odd @ spectrum.imag
        profiles += np.concatenate((odd_part[::-1], np.zeros_like(odd_part[:1]), -odd_part))
    kernel: Array = profiles @ wave_y.T
    return kernel


@functools.lru_cache(maxsize=16)
def _waves(mx: int, my: int) -> tuple[Array, Array, Array]:
    """Cosines along x (3, mx), sines along x (2, mx), cosines along y (3, my // 2 + 1)."""
    phase_x = 2 * np.pi / mx * np.arange(3)[:, None] * np.arange(mx)
    wave_y = np.cos(2 * np.pi / my * np.arange(3)[:, None] * np.arange(my // 2 + 1)) / my
    wave_y[:, 1 : (my + 1) // 2] *= 2  # modes omitted from the half spectrum
    return np.cos(phase_x) / mx, np.sin(phase_x[1:]) / mx, wave_y

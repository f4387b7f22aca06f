"""Rough surfaces: random self-affine heights, means of blocks, and roughness parameters.

Heights are positive towards the other body.
"""

from __future__ import annotations

import numpy as np

from tribo.errors import InputError, require_integer, require_positive
from tribo.numerics import Grid
from tribo.types import Array


def self_affine(
    grid: Grid,
    ra: float,
    hurst_exponent: float,
    correlation_length: float | tuple[float, float],
    seed: int,
) -> Array:
    """Random heights [m], shape ``grid.shape``, with a self-affine power spectrum.

    White Gaussian noise is shaped in Fourier space by the power spectrum (1 + (q_x l_x)² + (q_y
    l_y)²)^−(1+H), with the angular wavenumber q, and scaled to the given Ra. The surface repeats
    along both axes.

    Parameters
    ----------
    grid : Grid
        The pixels of the surface.
    ra : float
        Average roughness, the mean of the absolute height about the mean plane [m].
    hurst_exponent : float
        H, above 0 and at most 1.
    correlation_length : float or tuple of float
        l along both axes, or ``(l_x, l_y)`` for a lay [m]. A surface ground along y has l_y > l_x.
    seed : int
        Seed of NumPy's ``default_rng``.

    Examples
    --------
    >>> grid = Grid((64, 64), (0.8e-6, 0.9e-6))
    >>> heights = self_affine(grid, ra=0.27e-6, hurst_exponent=0.8, correlation_length=4e-6, seed=0)
    >>> f"{average_roughness(heights):.3e} m"
    '2.700e-07 m'
    """
    length_x, length_y = np.broadcast_to(correlation_length, 2).tolist()
    require_positive(ra=ra, correlation_length_x=length_x, correlation_length_y=length_y)
    require_integer(0, seed=seed)
    if not 0 < hurst_exponent <= 1:
        raise InputError(f"hurst_exponent is {hurst_exponent!r}; it must be above 0 and at most 1")
    if grid.shape == (1, 1):
        raise InputError("a single element has no roughness; use more pixels or a smooth surface")
    nx, ny = grid.shape
    # Computed in place, since allocating memory costs more time than the arithmetic.
    heights = np.random.default_rng(seed).standard_normal(grid.shape)
    modes = np.fft.rfft2(heights, out=np.empty((nx, ny // 2 + 1), complex))
    amplitude = self_affine_amplitude(grid, hurst_exponent, (length_x, length_y))
    modes[: nx // 2 + 1] *= amplitude
    modes[nx // 2 + 1 :] *= amplitude[1 : (nx + 1) // 2][::-1]  # the amplitude is even in q_x
    np.fft.ifft(modes, axis=0, out=modes)
    np.fft.irfft(modes, n=ny, axis=1, out=heights)
    distance_buffer = modes.view(float).reshape(-1)[: heights.size].reshape(heights.shape)
    heights *= ra / _mean_distance(heights, out=distance_buffer)
    return heights


def self_affine_amplitude(
    grid: Grid, hurst_exponent: float, correlation_length: tuple[float, float]
) -> Array:
    """Relative amplitude of each wave of `self_affine`, shape (nx // 2 + 1, ny // 2 + 1).

    The wavenumbers along both axes ascend from 0; the amplitude is even in both.

    Examples
    --------
    >>> self_affine_amplitude(Grid((4, 4), (1e-6, 1e-6)), 1.0, (1e-6, 1e-6)).round(3)
    array([[0.   , 0.288, 0.092],
           [0.288, 0.168, 0.075],
           [0.092, 0.075, 0.048]])
    """
    (nx, ny), (dx, dy) = grid.shape, grid.spacing
    length_x, length_y = correlation_length
    q_x = 2 * np.pi * np.fft.rfftfreq(nx, dx)[:, None]
    q_y = 2 * np.pi * np.fft.rfftfreq(ny, dy)
    amplitude: Array = 1 + (q_x * length_x) ** 2 + (q_y * length_y) ** 2
    amplitude **= -(1 + hurst_exponent) / 2
    amplitude[0, 0] = 0.0
    return amplitude


def block_average(heights: Array, factor: int) -> Array:
    """Mean of each block of ``factor × factor`` pixels, shape ``(nx/factor, ny/factor)``.

    Examples
    --------
    >>> block_average(np.array([[1.0, 3.0], [5.0, 7.0]]), 2)
    array([[4.]])
    """
    averaged: Array = _split_into_blocks(heights, factor).mean(axis=(1, 3))
    return averaged


def block_sample(heights: Array, factor: int) -> Array:
    """Middle pixel of each block of ``factor × factor`` pixels, shape ``(nx/factor, ny/factor)``.

    For an even `factor` it is the pixel after the middle, along both axes.

    Examples
    --------
    >>> block_sample(np.arange(9.0).reshape(3, 3), 3)
    array([[4.]])
    """
    middle = factor // 2
    sampled: Array = _split_into_blocks(heights, factor)[:, middle, :, middle]
    return np.ascontiguousarray(sampled)


def _split_into_blocks(heights: Array, factor: int) -> Array:
    """Split heights into blocks of pixels, shape ``(nx/factor, factor, ny/factor, factor)``."""
    nx, ny = heights.shape
    if factor < 1 or nx % factor or ny % factor:
        raise InputError(
            f"{nx} × {ny} pixels cannot be averaged {factor} × {factor}; "
            "both numbers must be multiples of the factor"
        )
    return heights.reshape(nx // factor, factor, ny // factor, factor)


def average_roughness(heights: Array) -> float:
    """Ra, the mean distance from the mean plane [m].

    Examples
    --------
    >>> average_roughness(np.array([[0.0, 2.0, 4.0, 2.0]]))
    1.0
    """
    return _mean_distance(heights, out=np.empty(heights.shape))


def _mean_distance(heights: Array, out: Array) -> float:
    """The mean distance from the mean plane [m]; `out` receives the distance of each pixel."""
    np.subtract(heights, heights.mean(), out=out)
    return float(np.abs(out, out=out).mean())


def rms_slope(heights: Array, spacing: tuple[float, float]) -> float:
    """Root mean square of the gradient, from central differences on a surface that repeats.

    `spacing` has the distances between heights along x and y, in the unit of the heights.

    Examples
    --------
    A sine of amplitude A and wavenumber q has slope Aq/√2:

    >>> x = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    >>> f"{rms_slope(np.sin(3 * x)[:, None], (x[1], 1.0)):.4f}"
    '2.1212'
    """
    squares = 0.0
    for axis, step in enumerate(spacing):
        difference = np.roll(heights, -1, axis) - np.roll(heights, 1, axis)
        squares += float(np.mean((difference / (2 * step)) ** 2))
    return float(np.sqrt(squares))


def correlation_lengths(heights: Array, spacing: tuple[float, float]) -> tuple[float, float]:
    """Distances [m] along x and y at which the autocorrelation of `heights` [m] falls to 1/e.

    `spacing` has the sides of a pixel [m]. The surface is taken to repeat itself. A distance is at
    least one pixel, and at most half a side.

    Examples
    --------
    >>> x = np.arange(400)[:, None] * np.ones(4)
    >>> correlation_lengths(np.cos(2 * np.pi * x / 40), (1e-6, 1e-6))
    (8e-06, 2e-06)
    """
    power = np.abs(np.fft.rfft2(heights - heights.mean())) ** 2
    correlation = np.fft.irfft2(power, heights.shape)
    lines = correlation[: len(heights) // 2, 0], correlation[0, : heights.shape[1] // 2]
    lags = [
        next((lag for lag, value in enumerate(line) if value < correlation[0, 0] / np.e), len(line))
        for line in lines
    ]
    return lags[0] * spacing[0], lags[1] * spacing[1]

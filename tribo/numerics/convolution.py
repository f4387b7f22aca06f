"""Convolution of a field with an influence kernel, on any mix of free and periodic axes.

A free axis is padded with zeros to twice its length, so that nothing wraps around (the DC-FFT of
Liu, Wang and Liu, Wear 243, 2000); a periodic axis is not padded at all.
"""

from __future__ import annotations

import copy
import math
import threading
from collections import OrderedDict
from typing import Any, Literal, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from tribo.errors import InputError
from tribo.numerics.grid import Grid
from tribo.types import Array, Indices, Spectrum

_MIN_SINGLE_SIZE = 64**2  # number of elements from which single precision is faster than double
_MIN_INFLUENCE = 1e-25  # smallest influence whose results single precision can represent
_MAX_BUFFERS = 4  # number of transform sizes whose buffers a thread caches


def padded_shape(grid: Grid) -> tuple[int, int]:
    """Lengths of the transforms along x and y, for axes of n elements.

    They are n along a periodic axis, and at least 2n − 1 along a free one.
    """
    nx, ny = (
        n if periodic else scipy.fft.next_fast_len(2 * n - 1)
        for n, periodic in zip(grid.shape, grid.periodic, strict=True)
    )
    return nx, ny


def _wrapped_indices(grid: Grid, axis: int) -> Indices:
    """Offsets along `axis` in elements, in the order of the transform: 0, 1, 2, …, −2, −1."""
    n = padded_shape(grid)[axis]
    index = np.arange(n)
    return np.where(index <= (n - 1) // 2, index, index - n)


def _coarse_kernel(kernel: NDArray[Any], offsets: Indices, axis: int) -> NDArray[Any]:
    """Kernel along `axis` for elements twice as long: two short sources, mean over two targets."""
    before, at, after = (kernel.take(2 * offsets + side, axis, mode="wrap") for side in (-1, 0, 1))
    coarse: NDArray[Any] = at + (before + after) / 2
    return coarse


class Convolution:
    """A linear map between fields on a grid, diagonal in Fourier space.

    Parameters
    ----------
    grid : Grid
        The grid of both fields.
    spectrum : ndarray, shape (mx, my//2 + 1), real or complex
        Discrete Fourier transform of the kernel at the offsets 0, 1, 2, …, −2, −1 elements along
        each axis, with ``(mx, my) = padded_shape(grid)``.

    Notes
    -----
    The map of an instance never changes, so that threads may share it.

    Examples
    --------
    >>> grid = Grid((2, 2), (1.0, 1.0), periodic=(False, True))
    >>> neighbour = np.zeros(padded_shape(grid))
    >>> neighbour[1, 0] = 1.0                      # each source acts one element further along x
    >>> shifted = Convolution(grid, np.fft.rfft2(neighbour))(np.array([[1.0, 2.0], [3.0, 4.0]]))
    >>> np.allclose(shifted, [[0.0, 0.0], [1.0, 2.0]])
    True
    """

    def __init__(self, grid: Grid, spectrum: Spectrum) -> None:
        mx, my = padded_shape(grid)
        if spectrum.shape != (mx, my // 2 + 1):
            raise InputError(
                f"the spectrum has shape {spectrum.shape}; this grid needs {(mx, my // 2 + 1)}"
            )
        self.grid = grid
        self.spectrum = spectrum
        self._factors: Spectrum | None = None
        self._lengths = mx, my
        self._single = False

    def __call__(
        self,
        field: Array,
        out: Array | None = None,
        rows: tuple[int, int] | None = None,
    ) -> Array:
        """Return the convolution of `field`, shape ``grid.shape``, written to `out` if given.

        With `rows` = (low, high) it takes less time. The field must then be 0 outside rows low to
        high − 1 along x, and the result is undefined outside these rows.
        """
        (nx, ny), (mx, my) = self.grid.shape, self._lengths
        if out is None:
            out = np.empty(self.grid.shape)
        low, high = rows or (0, nx)
        # NumPy stays in single precision only where both transforms are scaled.
        norm: Literal["ortho"] | None = "ortho" if self._single else None
        if my == 1 and not self._single:
            modes = np.fft.rfft(field[:, 0], n=mx)
            modes *= self.spectrum[: modes.size, 0]
            out[:, 0] = np.fft.irfft(modes, n=mx)[:nx]
            return out
        source, target = field[low:high], out[low:high]
        modes, padded = _buffers(nx, mx, my, single=self._single)
        padded = padded[low:high]
        in_place = my == ny and not self._single
        if not in_place:
            padded[:, :ny] = source
            padded[:, ny:] = 0.0
            source = padded
        modes[:low] = 0.0
        np.fft.rfft(source, axis=1, norm=norm, out=modes[low:high])
        modes[high:] = 0.0
        if mx > 1:
            np.fft.fft(modes, axis=0, norm=norm, out=modes)
        self._multiply(modes)
        if mx > 1:
            np.fft.ifft(modes, axis=0, norm=norm, out=modes)
        if in_place:
            np.fft.irfft(modes[low:high], n=my, axis=1, out=target)
        else:
            np.fft.irfft(modes[low:high], n=my, axis=1, norm=norm, out=padded)
            target[...] = padded[:, :ny]
        return out

    def _multiply(self, modes: Spectrum) -> None:
        """Multiply Fourier modes by the spectrum, in place."""
        components = modes.view(modes.real.dtype) if np.isrealobj(self.spectrum) else modes
        if self._factors is None:
            spectrum = self.spectrum.astype(components.dtype, copy=False)
            self._factors = spectrum.repeat(2, axis=1) if components is not modes else spectrum
        np.multiply(components, self._factors, out=components)

    @property
    def rounding(self) -> float:
        """Machine epsilon of the transforms, in single or double precision."""
        return float(np.finfo(np.float32 if self._single else np.float64).eps)

    def single_precision(self) -> Self:
        """Return a copy that computes in single precision: seven digits, faster on large grids.

        Examples
        --------
        >>> grid = Grid((4, 4), (1.0, 1.0))
        >>> double = Convolution(grid, np.fft.rfft2(np.ones(padded_shape(grid))))
        >>> double.single_precision()(np.eye(4)).max().round(5), double.rounding < 1e-15
        (np.float64(4.0), True)
        """
        real = np.isrealobj(self.spectrum)
        single = self.replace_spectrum(self.spectrum.astype(np.float32 if real else np.complex64))
        single._single = True
        return single

    def faster_precision(self, influence: float) -> Self:
        """Return a copy in single precision, or `self` if that is slower or impossible.

        Single precision is slower on small grids. `influence` is the effect of an element on
        itself; single precision is impossible if this effect is too large or too small.
        """
        is_representable = _MIN_INFLUENCE < influence < 1 / _MIN_INFLUENCE
        is_faster = math.prod(self.grid.shape) >= _MIN_SINGLE_SIZE
        return self.single_precision() if is_representable and is_faster else self

    def replace_spectrum(self, spectrum: Spectrum) -> Self:
        """Return a copy with another spectrum."""
        copied = copy.copy(self)
        copied.spectrum, copied._factors = spectrum, None
        return copied

    def cropped(self, shape: tuple[int, int]) -> Self:
        """Return this convolution for fields on a part of the window, of `shape` elements.

        A periodic axis must keep its full length.
        """
        grid = Grid(shape, self.grid.spacing, self.grid.periodic)
        modes = self.spectrum.astype(np.complex128)
        kernel = np.fft.ifft(modes, axis=0, out=modes)[_wrapped_indices(grid, 0)]
        if grid.shape[1] < self.grid.shape[1]:
            values = np.fft.irfft(kernel, n=self._lengths[1], axis=1)
            kernel = np.fft.rfft(values[:, _wrapped_indices(grid, 1)], axis=1)
        return self._replace_grid(grid, np.fft.fft(kernel, axis=0, out=kernel))

    def coarsened(self) -> Self:
        """Return this convolution for fields of means over blocks of 2 × 2 elements.

        An axis of one element is unchanged; other axes must have an even number of elements.
        Attributes of a subclass keep their values, such as the influence of an element on itself.
        """
        (nx, ny), (dx, dy) = self.grid.shape, self.grid.spacing
        fx, fy = min(nx, 2), min(ny, 2)
        grid = Grid((nx // fx, ny // fy), (dx * fx, dy * fy), self.grid.periodic)
        modes = self.spectrum.astype(np.complex128)
        kernel: Spectrum = np.fft.ifft(modes, axis=0, out=modes)
        if fx == 2:
            kernel = _coarse_kernel(kernel, _wrapped_indices(grid, 0), axis=0)
        if fy == 2:
            values = np.fft.irfft(kernel, n=self._lengths[1], axis=1)
            kernel = np.fft.rfft(_coarse_kernel(values, _wrapped_indices(grid, 1), axis=1), axis=1)
        return self._replace_grid(grid, np.fft.fft(kernel, axis=0))

    def _replace_grid(self, grid: Grid, modes: Spectrum) -> Self:
        """Return a copy with another grid, and with `modes` as its spectrum, in its type."""
        spectrum = modes.real if np.isrealobj(self.spectrum) else modes
        copied = self.replace_spectrum(spectrum.astype(self.spectrum.dtype))
        copied.grid, copied._lengths = grid, padded_shape(grid)
        return copied

    def __add__(self, other: Convolution) -> Convolution:
        """Return the convolution whose result is the sum of the results of both convolutions."""
        return Convolution(self.grid, self.spectrum + other.spectrum)


_Pair = tuple[NDArray[Any], NDArray[Any]]


class _Buffers(threading.local):
    """Transform buffers of a thread, cached by transform size.

    Allocating new buffers costs more time, in page faults, than the transforms themselves.
    """

    def __init__(self) -> None:
        self._pairs: OrderedDict[tuple[int, int, int, bool], _Pair] = OrderedDict()

    def __call__(self, nx: int, mx: int, my: int, *, single: bool) -> _Pair:
        """Return an array for Fourier modes (mx, my//2 + 1), and one for padded rows (nx, my).

        The first is complex, the second real; both are in single precision if `single`. Their
        content is undefined, and a later call of this thread for the same sizes may return the same
        arrays.
        """
        key = nx, mx, my, single
        if key in self._pairs:
            self._pairs.move_to_end(key)
            return self._pairs[key]
        while len(self._pairs) >= _MAX_BUFFERS:
            self._pairs.popitem(last=False)
        real, modes = (np.float32, np.complex64) if single else (np.float64, np.complex128)
        self._pairs[key] = np.empty((mx, my // 2 + 1), modes), np.empty((nx, my), real)
        return self._pairs[key]

    def clear(self) -> None:
        """Free the buffers of the calling thread."""
        self._pairs.clear()


_buffers = _Buffers()


def forget_buffers() -> None:
    """Free the transform buffers cached by the calling thread."""
    _buffers.clear()

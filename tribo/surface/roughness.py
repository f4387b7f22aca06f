"""Surfaces of the disk: the protocol of all surfaces, a random surface and a measured one."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from tribo.errors import (
    InputError,
    InvariantError,
    finite_field,
    law_errors,
    require_integer,
    require_number,
    require_pair,
)
from tribo.numerics import Grid
from tribo.surface.topography import self_affine
from tribo.types import Array

_ROUNDING_BITS = 17  # of the mean deviation of an array, which its digest takes into account


class Surface(Protocol):
    """A surface of the disk. It must be hashable, and equal hashes must mean equal heights.

    Examples
    --------
    >>> ground: Surface = SelfAffineRoughness(0.27e-6, 0.8, correlation_length=(4e-6, 4e-6))
    >>> ground.heights(Grid((8, 4), (1e-6, 1e-6))).shape
    (8, 4)
    """

    def __hash__(self) -> int:
        """Hash of the surface; surfaces of equal hash must have equal heights, which are cached."""

    def heights(self, pixels: Grid) -> Array:
        """Heights, positive towards the pin [m], shape ``pixels.shape``."""


@dataclass(frozen=True, slots=True)
class SelfAffineRoughness:
    """A random, self-affine surface, which `tribo.surface.self_affine` makes.

    Parameters
    ----------
    ra : float
        Mean absolute height on the pixels, Ra [m].
    hurst_exponent : float
        Hurst exponent, above 0 (rough at all lengths) and at most 1 (smooth at short lengths).
    correlation_length : tuple of float
        Correlation lengths along x and y [m].
    seed : int
        Seed of the random surface; each seed gives another surface.

    Examples
    --------
    >>> ground = SelfAffineRoughness(0.27e-6, 0.8, correlation_length=(4e-6, 40e-6), seed=1)
    >>> ground.seed
    1
    """

    ra: float
    hurst_exponent: float
    correlation_length: tuple[float, float]
    seed: int = 0

    def __post_init__(self) -> None:
        require_number(ra=self.ra, hurst_exponent=self.hurst_exponent)
        require_pair(correlation_length=self.correlation_length)
        require_integer(0, seed=self.seed)

    def heights(self, pixels: Grid) -> Array:
        """Heights [m], shape ``pixels.shape``."""
        return self_affine(pixels, self.ra, self.hurst_exponent, self.correlation_length, self.seed)


def array_digest(array: Array) -> str:
    """SHA-256 of an array's shape and rounded values, as hexadecimal text.

    Values are rounded to about 1e-5 of their mean deviation, such as Ra. So heights of a scan keep
    their digest although each version of NumPy and SciPy levels them with other rounding errors.
    """
    numbers = np.asarray(array, float)
    deviation = np.abs(numbers - numbers.mean()).mean()
    # Its power of two does not depend on its last bits.
    _, exponent = np.frexp(deviation)
    rounded = np.rint(np.ldexp(numbers, _ROUNDING_BITS - exponent)) + 0.0  # without −0
    return hashlib.sha256(repr(numbers.shape).encode() + rounded.tobytes()).hexdigest()


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredRoughness:
    """A measured surface.

    Parameters
    ----------
    array : ndarray, shape (nx, ny)
        Heights [m], positive towards the pin. Axis 0 is x, the sliding direction. An array of
        float64 may be stored without a copy, so it must not be changed later. Surfaces are equal if
        their heights are, within about 1e-5 of Ra.

    Examples
    --------
    >>> import numpy as np
    >>> waves = 1e-7 * np.sin(np.linspace(0, 20, 64))[:, None] * np.ones((1, 32))
    >>> MeasuredRoughness(waves).array.shape
    (64, 32)
    """

    array: Array
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        shape = np.shape(self.array)
        if len(shape) != 2 or 0 in shape:
            raise InputError(
                f"measured heights have shape {shape}; they must be a two-dimensional array"
            )
        array = np.ascontiguousarray(finite_field("measured heights", self.array, shape))
        object.__setattr__(self, "array", array)
        object.__setattr__(self, "digest", array_digest(array))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeasuredRoughness) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def heights(self, pixels: Grid) -> Array:
        """Heights [m] above their mean; `InputError` unless their shape is ``pixels.shape``."""
        if self.array.shape != pixels.shape:
            raise InputError(
                f"the measured surface has {self.array.shape} pixels, the scene {pixels.shape}"
            )
        level: Array = self.array - self.array.mean()
        return level


class UnknownHeights:
    """Base class of a surface whose heights may be unknown when its scene is read.

    The scene can then be read, but not simulated. `summary` has what is known of the heights, see
    `tribo.simulation.lubrication.SurfaceSummary`, or is None.
    """

    summary: Any = None


def surface_heights(surface: Any, pixels: Grid) -> Array:
    """Heights of a surface [m]; `InvariantError` unless finite and of shape ``pixels.shape``."""
    with law_errors(f"surface {surface!r}"):
        heights = np.asarray(surface.heights(pixels), dtype=float)
    if heights.shape != pixels.shape:
        raise InvariantError(
            f"surface: its heights have the shape {heights.shape}, the window's pixels "
            f"{pixels.shape}; they must be the same"
        )
    nonfinite = np.argwhere(~np.isfinite(heights))
    if nonfinite.size:
        raise InvariantError(
            f"surface: its height is {heights[tuple(nonfinite[0])]} at pixel "
            f"{tuple(nonfinite[0].tolist())}, counted from 0; each must be finite"
        )
    return heights

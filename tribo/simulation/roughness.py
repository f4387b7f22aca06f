"""The roughness of the disk: random or measured."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

import numpy as np

from tribo.errors import InputError, finite_field
from tribo.grid import Grid
from tribo.topography import self_affine
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class SelfAffineRoughness:
    """A random surface; see `tribo.self_affine`.

    Parameters
    ----------
    ra : float
        Mean absolute height on the pixels, Ra [m].
    hurst_exponent : float
        Hurst exponent, from 0 (rough at every length) to 1 (smooth at short ones).
    correlation_length : tuple of float
        Correlation lengths along x and y [m].
    seed : int
        Number of the random surface.

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

    def heights(self, pixels: Grid) -> Array:
        """Heights [m], shape ``pixels.shape``."""
        return self_affine(pixels, self.ra, self.hurst_exponent, self.correlation_length, self.seed)


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredRoughness:
    """A surface as it was measured.

    Parameters
    ----------
    array : ndarray, shape (nx, ny)
        Heights [m], positive towards the pin; rows along x.

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
        digest = hashlib.sha256(repr(array.shape).encode() + array.tobytes()).hexdigest()
        object.__setattr__(self, "digest", digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeasuredRoughness) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def heights(self, pixels: Grid) -> Array:
        """Heights [m] above their mean, shape ``pixels.shape``."""
        if self.array.shape != pixels.shape:
            raise InputError(
                f"the measured surface has {self.array.shape} pixels, the scene {pixels.shape}"
            )
        level: Array = self.array - self.array.mean()
        return level

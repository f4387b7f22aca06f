"""What is simulated: two bodies, how one slides on the other, and to what fidelity."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tribo.errors import InputError, require_positive
from tribo.fidelity import Fidelity
from tribo.grid import Grid
from tribo.loading import Ramp
from tribo.material import Material
from tribo.topography import block_average, self_affine
from tribo.wear import Wear

__all__ = ["Ball", "Cylinder", "MeasuredRoughness", "Scene", "SelfAffineRoughness"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A smooth pin whose axis lies along y.

    Parameters
    ----------
    radius, length : float
        [m]. The load is spread evenly over the length.
    material : Material
    """

    radius: float
    length: float
    material: Material

    def __post_init__(self) -> None:
        require_positive(radius=self.radius, length=self.length)

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches, x²/(2R) [m], shape ``grid.shape``."""
        x = grid.coordinates(0)[:, None]
        return np.broadcast_to(x**2 / (2 * self.radius), grid.shape)

    def patches(self, grid: Grid) -> float:
        """How many times the patch's load and wear make up the whole pin's."""
        return self.length / grid.size[1]


@dataclass(frozen=True, slots=True)
class Ball:
    """A smooth ball as pin.

    Parameters
    ----------
    radius : float
        [m].
    material : Material
    """

    radius: float
    material: Material

    def __post_init__(self) -> None:
        require_positive(radius=self.radius)

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches, (x² + y²)/(2R) [m], shape ``grid.shape``."""
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        distance: Array = (x**2 + y**2) / (2 * self.radius)
        return distance

    def patches(self, grid: Grid) -> float:
        """How many times the patch's load and wear make up the whole pin's."""
        return 1.0


@dataclass(frozen=True, slots=True)
class SelfAffineRoughness:
    """A random surface; see `tribo.self_affine`.

    Parameters
    ----------
    ra : float
        [m], on the pixels.
    hurst_exponent : float
    correlation_length : tuple of float
        Along x and y [m].
    seed : int
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
    """

    array: Array
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        array = np.ascontiguousarray(self.array, dtype=np.float64)
        if array.ndim != 2 or not np.isfinite(array).all():
            raise InputError("measured heights must be a two-dimensional array of finite numbers")
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A pin pressed onto a moving disk.

    Parameters
    ----------
    pin : Cylinder or Ball
        Smooth, at rest.
    disk : Material
        Of the body that moves along +x.
    pixels : Grid
        The patch of the contact, and the pixels on which the disk's roughness is given.
    loading : Ramp
    roughness : SelfAffineRoughness or MeasuredRoughness, optional
        Of the disk; smooth if not given.
    wear : Wear, optional
        Of the pin; none if not given.
    fidelity : Fidelity

    Raises
    ------
    InputError
        If the parts do not fit together.
    """

    pin: Cylinder | Ball
    disk: Material
    pixels: Grid
    loading: Ramp
    roughness: SelfAffineRoughness | MeasuredRoughness | None = None
    wear: Wear | None = None
    fidelity: Fidelity = field(default_factory=Fidelity)

    def __post_init__(self) -> None:
        block = self.fidelity.pixels_per_element
        if any(n % block for n in self.pixels.shape):
            raise InputError(
                f"pixels_per_element is {block}, which does not divide the {self.pixels.shape} "
                "pixels of the surface; choose a common divisor"
            )
        if self.pixels.periodic[0]:
            raise InputError("the patch is periodic along x; under a round pin x must be free")
        if isinstance(self.pin, Ball) and self.pixels.periodic[1]:
            raise InputError("the patch is periodic along y; under a ball both axes must be free")
        if self.wear and self.wear.pattern == "swept" and not self.pixels.periodic[1]:
            raise InputError(
                "swept wear needs a patch that is periodic along y; use the pattern 'local'"
            )
        if isinstance(self.roughness, MeasuredRoughness):
            self.roughness.heights(self.pixels)

    @property
    def grid(self) -> Grid:
        """The elements, each of ``pixels_per_element`` squared pixels."""
        block = self.fidelity.pixels_per_element
        (nx, ny), (dx, dy) = self.pixels.shape, self.pixels.spacing
        return Grid((nx // block, ny // block), (dx * block, dy * block), self.pixels.periodic)

    @property
    def hardness(self) -> float:
        """Hardness of the softer body [Pa]."""
        return min(self.pin.material.hardness, self.disk.hardness)

    def separation(self) -> Array:
        """Distance of the unworn, undeformed surfaces [m], shape ``grid.shape``."""
        profile = self.pin.profile(self.grid)
        if self.roughness is None:
            return profile.copy()
        heights = self.roughness.heights(self.pixels)
        return profile - block_average(heights, self.fidelity.pixels_per_element)

"""Scene: two bodies, how one slides on the other, and with what numerical choices."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from tribo.errors import InputError, finite_field, require_positive
from tribo.grid import Grid
from tribo.loading.ramp import Ramp, Station
from tribo.loading.record import MeasuredLoad
from tribo.material import Material
from tribo.simulation.fidelity import Fidelity
from tribo.thermal.conduction import HeatedLength
from tribo.topography import block_average, block_sample, self_affine
from tribo.types import Array
from tribo.wear import Wear

__all__ = ["Ball", "Cylinder", "MeasuredRoughness", "Scene", "SelfAffineRoughness"]


# Elements along x with which the shape of the wear is still known well.
_FEWEST_ELEMENTS = 24


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A smooth pin whose axis lies along y.

    Parameters
    ----------
    radius, length : float
        Radius and length of the cylinder [m]. The load is spread evenly over the length.
    material : Material
        Material of the cylinder.
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
        Radius of the ball [m].
    material : Material
        Material of the ball.
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
        Mean absolute height on the pixels, Ra [m].
    hurst_exponent : float
        Hurst exponent, from 0 (rough at every length) to 1 (smooth at short ones).
    correlation_length : tuple of float
        Correlation lengths along x and y [m].
    seed : int
        Number of the random surface.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A pin pressed onto a moving disk.

    Parameters
    ----------
    pin : Cylinder or Ball
        Smooth, at rest.
    disk : Material
        Material of the body that moves along +x.
    pixels : Grid
        The patch of the contact, and the pixels on which the disk's roughness is given.
    loading : Ramp or MeasuredLoad
        How the load grows with time.
    roughness : SelfAffineRoughness or MeasuredRoughness, optional
        Roughness of the disk; smooth if not given.
    wear : Wear, optional
        Wear of the pin; none if not given.
    friction_heat : bool
        Whether there is friction, and with it heat. If not, no temperature is solved for: the rise
        is 0.
    fidelity : Fidelity
        Numerical choices.

    Raises
    ------
    InputError
        If the parts do not fit together.
    """

    pin: Cylinder | Ball
    disk: Material
    pixels: Grid
    loading: Ramp | MeasuredLoad
    roughness: SelfAffineRoughness | MeasuredRoughness | None = None
    wear: Wear | None = None
    friction_heat: bool = True
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
        if self.fidelity.kernel == "nearest-image" and not self.pixels.periodic[1]:
            raise InputError(
                "the kernel 'nearest-image' needs a patch that is periodic along y; use 'periodic'"
            )
        if self.fidelity.heat_kernel != "pin" and not self.pixels.periodic[1]:
            raise InputError(
                f"the heat_kernel {self.fidelity.heat_kernel!r} needs a patch that is periodic "
                "along y; use 'pin'"
            )
        if isinstance(self.roughness, MeasuredRoughness):
            self.roughness.heights(self.pixels)

    @property
    def grid(self) -> Grid:
        """The elements, each of ``pixels_per_element`` squared pixels.

        Where both bodies are smooth under a cylinder, on a patch that repeats along y, nothing
        depends on y: elements as long as the patch stand for whole rows.
        """
        block = self.fidelity.pixels_per_element
        (nx, ny), (dx, dy) = self.pixels.shape, self.pixels.spacing
        if self.is_plane:
            return Grid((nx // block, 1), (dx * block, dy * ny), self.pixels.periodic)
        return Grid((nx // block, ny // block), (dx * block, dy * block), self.pixels.periodic)

    @property
    def is_plane(self) -> bool:
        """Whether nothing depends on y."""
        smooth = self.roughness is None and isinstance(self.pin, Cylinder)
        kernels = self.fidelity.kernel, self.fidelity.heat_kernel
        return smooth and self.pixels.periodic[1] and "nearest-image" not in kernels

    @property
    def rows_per_element(self) -> int:
        """Rows of elements, as the fidelity has them, that one element stands for."""
        return self.pixels.shape[1] // self.fidelity.pixels_per_element if self.is_plane else 1

    @property
    def hardness(self) -> float:
        """Hardness of the softer body [Pa]."""
        return min(self.pin.material.hardness, self.disk.hardness)

    @property
    def remembers_heat(self) -> bool:
        """Whether a temperature depends on the heat of the steps before."""
        return self.friction_heat and self.fidelity.heat_model == "history"

    @property
    def heated_length(self) -> HeatedLength:
        """Length along y that is heated [m], for `tribo.ConductingHalfSpace`."""
        if self.fidelity.heat_kernel == "nearest-image":
            return "nearest-image"
        if isinstance(self.pin, Cylinder) and self.fidelity.heat_kernel == "pin":
            return self.pin.length
        return math.inf

    def separation(self) -> Array:
        """Distance of the unworn, undeformed surfaces [m], shape ``grid.shape``."""
        profile = self.pin.profile(self.grid)
        if self.roughness is None:
            return profile.copy()
        heights, block = self.roughness.heights(self.pixels), self.fidelity.pixels_per_element
        coarsened = block_sample if self.fidelity.averaging == "sample" else block_average
        return profile - coarsened(heights, block)

    def stations(self, normal_load: float, after: float = 0.0) -> Iterator[Station]:
        """Steps that lead to a load and through its hold, as many as the physics needs.

        What wears depends on its past, as temperature does by the heat model "history", and needs
        every step of the loading. Else nothing remembers the way, and only the steps are left at
        which a temperature is asked for.

        Parameters
        ----------
        normal_load : float
            Load on the whole pin at the end [N].
        after : float
            Load of a station on the trunk [N], or 0.
        """
        fidelity = self.fidelity
        stations = self.loading.stations(normal_load, fidelity.increments, after)
        wears = self.wear is not None and self.wear.specific_wear_rate > 0
        if wears or self.remembers_heat:
            yield from stations
            return
        interval = fidelity.temperature_interval
        for station in stations:
            asked = bool(interval) and station.index % interval == 0
            if asked:
                yield station
        if not asked:
            yield replace(station, on_trunk=False)

    def trunk(self, normal_load: float) -> float:
        """Increment of the trunk that leads to a load [N]; loads of one increment share it."""
        if isinstance(self.loading, MeasuredLoad):
            return 0.0
        return self.loading.increment(normal_load, self.fidelity.increments)

    @property
    def coarsening(self) -> int:
        """How many times larger elements are, along each axis, until a point's last step.

        The largest number up to the fidelity's ``history_coarsening`` that divides the grid and
        leaves enough of it to know the wear; 1 where the wear is local, or the heat of all the
        steps before acts on the last.
        """
        if (self.wear and self.wear.pattern == "local") or self.remembers_heat:
            return 1
        nx, ny = self.grid.shape
        fits = (
            factor
            for factor in range(self.fidelity.history_coarsening, 1, -1)
            if nx % factor == ny % factor == 0 and nx // factor >= _FEWEST_ELEMENTS
        )
        return next(fits, 1)

    def levels(self) -> Iterator[Scene]:
        """The scene on ever finer grids: first that of the history, last its own.

        From one to the next elements become at least four times smaller along each axis, or the
        scene's own: contacts on more grids would take longer than they save.
        """
        factor = self.coarsening
        while factor > 1:
            block = self.fidelity.pixels_per_element * factor
            yield replace(
                self,
                fidelity=replace(self.fidelity, pixels_per_element=block, history_coarsening=1),
            )
            factor = next((n for n in range(factor // 4, 1, -1) if factor % n == 0), 1)
        yield self

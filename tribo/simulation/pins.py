"""Shapes of the pin: a cylinder, a ball, or a body of two radii."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tribo.errors import require_positive
from tribo.grid import Grid
from tribo.material import Material
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A smooth pin whose axis lies along y.

    Parameters
    ----------
    radius, length : float
        Radius and length of the cylinder [m]. The load is spread evenly over the length.
    material : Material
        Material of the cylinder.

    Examples
    --------
    >>> import tribo
    >>> pin = tribo.Cylinder(radius=2e-3, length=3.4e-3, material=tribo.AISI_316)
    >>> pin.length
    0.0034
    """

    radius: float
    length: float
    material: Material
    crown_radius: ClassVar[None] = None

    def __post_init__(self) -> None:
        require_positive(radius=self.radius, length=self.length)

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches, x²/(2R) [m], shape ``grid.shape``."""
        x = grid.coordinates(0)[:, None]
        return np.broadcast_to(x**2 / (2 * self.radius), grid.shape)

    def patches(self, grid: Grid) -> float:
        """Ratio of the load and wear of the whole pin to the patch's."""
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

    Examples
    --------
    >>> import tribo
    >>> ball = tribo.Ball(radius=10e-3, material=tribo.AISI_316)
    >>> ball.radius
    0.01
    """

    radius: float
    material: Material
    length: ClassVar[None] = None
    crown_radius: ClassVar[None] = None

    def __post_init__(self) -> None:
        require_positive(radius=self.radius)

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches, (x² + y²)/(2R) [m], shape ``grid.shape``."""
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        distance: Array = (x**2 + y**2) / (2 * self.radius)
        return distance

    def patches(self, grid: Grid) -> float:
        """Ratio of the load and wear of the whole pin to the patch's."""
        return 1.0


@dataclass(frozen=True, slots=True)
class Crowned:
    """A smooth roller as pin, with a crown: of one radius along x and of another along y.

    Parameters
    ----------
    radius : float
        Radius in the plane of sliding, along x [m].
    crown_radius : float
        Radius across it, along y [m].
    material : Material
        Material of the roller.

    Examples
    --------
    >>> import tribo
    >>> roller = tribo.Crowned(radius=10e-3, crown_radius=0.5, material=tribo.AISI_316)
    >>> roller.crown_radius
    0.5
    """

    radius: float
    crown_radius: float
    material: Material
    length: ClassVar[None] = None

    def __post_init__(self) -> None:
        require_positive(radius=self.radius, crown_radius=self.crown_radius)

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches, x²/(2R) + y²/(2R_c) [m], shape ``grid.shape``."""
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        distance: Array = x**2 / (2 * self.radius) + y**2 / (2 * self.crown_radius)
        return distance

    def patches(self, grid: Grid) -> float:
        """Ratio of the load and wear of the whole pin to the patch's."""
        return 1.0

"""Shapes of the pin: a cylinder, a ball, or a body of two radii.

A pin of another shape is a class here with what `Pin` has, and its name in `PINS`. Entries of its
own in a scene file stand in ``pipeline/scene/format.py``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar, Protocol

import numpy as np

from tribo.analytic import HertzContact, hertz_contact
from tribo.errors import require_positive
from tribo.material import Material
from tribo.numerics import Grid
from tribo.types import Array


class Pin(Protocol):
    """A smooth pin: a frozen dataclass whose fields are its sizes [m], and its material.

    Examples
    --------
    >>> import tribo
    >>> pin: Pin = Ball(radius=10e-3, material=tribo.AISI_316)
    >>> pin.words, f"{pin.hertz(10.0, 115e9).half_width * 1e6:.0f} µm"
    ('ball, radius 10 mm', '87 µm')
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def radius(self) -> float:
        """Radius in the plane of sliding, along x [m]."""

    @property
    def length(self) -> float | None:
        """Length of a line contact along y [m]; None where the contact ends along y, too."""

    @property
    def crown_radius(self) -> float | None:
        """Radius along y [m], where it is another than along x."""

    @property
    def material(self) -> Material:
        """Material of the pin."""

    @property
    def words(self) -> str:
        """Shape and sizes in a few words."""

    def profile(self, grid: Grid) -> Array:
        """Distance from the flat that it touches [m], shape ``grid.shape``."""

    def patches(self, grid: Grid) -> float:
        """Ratio of the load and wear of the whole pin to the patch's."""

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""


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

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(normal_load, contact_modulus, self.radius, self.length)

    @property
    def words(self) -> str:
        """Shape and sizes in a few words."""
        return f"cylinder, {1e3 * self.length:g} mm long, radius {1e3 * self.radius:g} mm"


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

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(normal_load, contact_modulus, self.radius)

    @property
    def words(self) -> str:
        """Shape and sizes in a few words."""
        return f"ball, radius {1e3 * self.radius:g} mm"


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

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(
            normal_load, contact_modulus, self.radius, crown_radius=self.crown_radius
        )

    @property
    def words(self) -> str:
        """Shape and sizes in a few words."""
        across = f"crowned, {1e3 * self.crown_radius:g} mm across sliding"
        return f"{across}, radius {1e3 * self.radius:g} mm"


PINS: dict[str, type[Pin]] = {"cylinder": Cylinder, "ball": Ball, "crowned": Crowned}
"""Shapes of the pin, by their names in a scene file."""


def sizes_of(shape: str) -> tuple[str, ...]:
    """Names of the sizes of a pin of some shape.

    Examples
    --------
    >>> sizes_of("cylinder"), sizes_of("crowned")
    (('radius', 'length'), ('radius', 'crown_radius'))
    """
    return tuple(size.name for size in fields(PINS[shape]) if size.name != "material")

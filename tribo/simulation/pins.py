"""Shapes of the pin: a cylinder, a ball, or a body of two radii.

To add a shape, add a class with the attributes of `Pin`, and its name to `PINS`. If it has a size
that no other shape has, add an entry for this size to the scene file (`pipeline.scene.format`).
A shape with the size ``length`` is a line contact. Its window repeats along y, or is as long as the
pin, whose ends are then free.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass, fields
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from tribo.analytic import HertzContact, hertz_contact, worn_line_width, worn_point_width
from tribo.errors import InputError, require_instance, require_positive
from tribo.material import Material, minimum_line_film, minimum_point_film
from tribo.numerics import Grid
from tribo.types import Array


class WornContact(NamedTuple):
    """Width of the contact, and depth of wear, of a smooth pin worn without rolling [m]."""

    width: float  # along x [m]
    depth: float  # greatest depth [m]


class Relief(NamedTuple):
    """Relief of both ends of a cylinder: its radius decreases towards them as a parabola.

    Examples
    --------
    >>> relief = Relief(depth=2e-6, length=0.3e-3)
    >>> float(relief.drop(np.array([0.0, 0.15e-3, 0.4e-3]))[1])
    5e-07
    """

    depth: float  # drop at the end of the pin [m]
    length: float  # part of the pin that is relieved, at each end [m]

    def drop(self, distance: Array) -> Array:
        """Drop of the surface [m] at a `distance` from the end of the pin [m]."""
        share = np.clip(1 - distance / self.length, 0.0, None)
        return np.asarray(self.depth * share**2)


class OilEntry(NamedTuple):
    """Oil at the inlet of a contact: the data from which the thickness of its film follows.

    These are the mean speed of both surfaces [m/s], the viscosity [Pa s] and the pressure-viscosity
    coefficient [1/Pa].
    """

    speed: float  # mean of both surfaces [m/s]
    viscosity: float  # [Pa s]
    pressure_coefficient: float  # [1/Pa]


class Pin(Protocol):
    """Interface (protocol) of a smooth pin, such as `Cylinder`, `Ball` and `Crowned`.

    A class of your own need not inherit from it. It must be a frozen dataclass with the fields
    `material` and the sizes of the pin [m], and must have the properties ``radius`` and ``length``
    and the methods ``profile``, ``windows``, ``hertz``, ``worn`` and ``film_thickness``.

    Examples
    --------
    >>> import tribo
    >>> pin: Pin = Ball(radius=10e-3, material=steel)
    >>> f"{pin.hertz(10.0, 115e9).half_width * 1e6:.0f} µm"
    '87 µm'
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def radius(self) -> float:
        """Radius in the plane of sliding, along x [m]."""

    @property
    def length(self) -> float | None:
        """Length of a line contact along y [m]; None for a point contact."""

    @property
    def material(self) -> Material:
        """Material of the pin."""

    def profile(self, grid: Grid) -> Array:
        """Height of the pin above a plane that it touches [m], shape ``grid.shape``."""

    def windows(self, grid: Grid) -> float:
        """Number of windows like `grid` on the pin: the pin's load over the load on one window."""

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""

    def worn(self, half_width: float, volume: float) -> WornContact:
        """Contact of a pin at rest after it lost `volume` [m³]; `half_width` is before wear [m]."""

    def film_thickness(self, oil: OilEntry, normal_load: float, contact_modulus: float) -> float:
        """Minimum thickness of the oil film between the smooth, unworn bodies [m].

        `oil` has the mean speed of both surfaces and the oil's viscosity at the inlet. The load is
        in N, the contact modulus in Pa.
        """


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A smooth pin whose axis lies along y.

    Parameters
    ----------
    radius, length : float
        Radius and length of the cylinder [m]. In a window that repeats along y, the load is spread
        evenly over the length.
    material : Material
        Material of the cylinder.
    relief : Relief, optional
        Relief of both ends; sharp if not given. It needs a window with free ends.

    Examples
    --------
    >>> import tribo
    >>> pin = tribo.Cylinder(radius=2e-3, length=3.4e-3, material=steel)
    >>> pin.length
    0.0034
    """

    radius: float
    length: float
    material: Material
    relief: Relief | None = None

    def __post_init__(self) -> None:
        require_instance(Material, material=self.material)
        require_positive(radius=self.radius, length=self.length)
        if self.relief is None:
            return
        require_instance(Relief, relief=self.relief)
        require_positive(**{f"relief.{name}": size for name, size in self.relief._asdict().items()})
        if self.relief.length > self.length / 2:
            raise InputError(
                f"relief.length is {self.relief.length:g} m; it must be at most half the length of "
                f"the cylinder, {self.length / 2:g} m"
            )

    def profile(self, grid: Grid) -> Array:
        """Height of the pin above a plane that it touches [m], shape ``grid.shape``.

        It is x²/(2R), to which a relief adds its drop towards the ends.
        """
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        height: Array = x**2 / (2 * self.radius)
        if self.relief:
            height = height + self.relief.drop(self.length / 2 - np.abs(y))
        return np.broadcast_to(height, grid.shape)

    def windows(self, grid: Grid) -> float:
        """Number of windows like `grid` on the pin, side by side; 1 if its ends are free."""
        return self.length / grid.size[1] if grid.periodic[1] else 1.0

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(normal_load, contact_modulus, self.radius, self.length)

    def worn(self, half_width: float, volume: float) -> WornContact:
        """Contact of a pin at rest after it lost `volume` [m³]; `half_width` is before wear [m].

        Examples
        --------
        >>> import tribo
        >>> worn = Cylinder(2e-3, 3.4e-3, steel).worn(90e-6, 2.8e-12)
        >>> f"{1e6 * worn.width:.0f} µm wide, {1e6 * worn.depth:.2f} µm deep"
        '295 µm wide, 4.19 µm deep'
        """
        area = volume / self.length
        flat = worn_line_width(area, self.radius)
        width = float(np.cbrt((2 * half_width) ** 3 + flat**3))
        return WornContact(width, 1.5 * area / width)

    def film_thickness(self, oil: OilEntry, normal_load: float, contact_modulus: float) -> float:
        """Minimum thickness of the oil film between the smooth, unworn bodies [m]."""
        return minimum_line_film(*oil, normal_load / self.length, self.radius, contact_modulus)


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
    >>> ball = tribo.Ball(radius=10e-3, material=steel)
    >>> ball.radius
    0.01
    """

    radius: float
    material: Material
    length: ClassVar[None] = None

    def __post_init__(self) -> None:
        require_instance(Material, material=self.material)
        require_positive(radius=self.radius)

    def profile(self, grid: Grid) -> Array:
        """Height of the pin above a plane that it touches, (x² + y²)/(2R) [m]."""
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        distance: Array = (x**2 + y**2) / (2 * self.radius)
        return distance

    def windows(self, grid: Grid) -> float:
        """Number of windows like `grid` on the pin: 1, since one window has the whole contact."""
        return 1.0

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(normal_load, contact_modulus, self.radius)

    def worn(self, half_width: float, volume: float) -> WornContact:
        """Contact of a pin at rest after it lost `volume` [m³]; `half_width` is before wear [m]."""
        return _worn_ellipse(half_width, volume, self.radius, 1.0)

    def film_thickness(self, oil: OilEntry, normal_load: float, contact_modulus: float) -> float:
        """Minimum thickness of the oil film between the smooth, unworn bodies [m]."""
        return minimum_point_film(*oil, normal_load, self.radius, contact_modulus)


@dataclass(frozen=True, slots=True)
class Crowned:
    """A smooth, crowned roller as pin: it has one radius along x and another along y.

    Parameters
    ----------
    radius : float
        Radius in the plane of sliding, along x [m].
    crown_radius : float
        Radius across the sliding direction, along y [m].
    material : Material
        Material of the roller.

    Examples
    --------
    >>> import tribo
    >>> roller = tribo.Crowned(radius=10e-3, crown_radius=0.5, material=steel)
    >>> roller.crown_radius
    0.5
    """

    radius: float
    crown_radius: float
    material: Material
    length: ClassVar[None] = None

    def __post_init__(self) -> None:
        require_instance(Material, material=self.material)
        require_positive(radius=self.radius, crown_radius=self.crown_radius)

    def profile(self, grid: Grid) -> Array:
        """Height of the pin above a plane that it touches, x²/(2R) + y²/(2R_c) [m]."""
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        distance: Array = x**2 / (2 * self.radius) + y**2 / (2 * self.crown_radius)
        return distance

    def windows(self, grid: Grid) -> float:
        """Number of windows like `grid` on the pin: 1, since one window has the whole contact."""
        return 1.0

    def hertz(self, normal_load: float, contact_modulus: float) -> HertzContact:
        """Smooth, unworn contact under a load [N], for a contact modulus [Pa]."""
        return hertz_contact(
            normal_load, contact_modulus, self.radius, crown_radius=self.crown_radius
        )

    def worn(self, half_width: float, volume: float) -> WornContact:
        """Contact of a pin at rest after it lost `volume` [m³]; `half_width` is before wear [m].

        The worn flat is an ellipse with the aspect ratio √(crown radius/radius).
        """
        aspect = math.sqrt(self.crown_radius / self.radius)
        return _worn_ellipse(half_width, volume, self.radius, aspect)

    def film_thickness(self, oil: OilEntry, normal_load: float, contact_modulus: float) -> float:
        """Minimum thickness of the oil film between the smooth, unworn bodies [m]."""
        ellipticity = self.hertz(1.0, contact_modulus).aspect  # the same at any load
        return minimum_point_film(*oil, normal_load, self.radius, contact_modulus, ellipticity)


def _worn_ellipse(half_width: float, volume: float, radius: float, aspect: float) -> WornContact:
    """Worn contact of a paraboloid of `radius` [m]; the flat is `aspect` times as long as wide."""
    flat = worn_point_width(volume / aspect, radius)
    width = ((2 * half_width) ** 4 + flat**4) ** 0.25
    return WornContact(width, 8 * volume / (math.pi * width**2 * aspect))


PINS: dict[str, type[Pin]] = {"cylinder": Cylinder, "ball": Ball, "crowned": Crowned}
"""Shapes of the pin by name."""


def sizes_of(shape: str | Pin) -> tuple[str, ...]:
    """Names of the sizes that a pin needs, given as an object or by the name of its shape.

    Examples
    --------
    >>> sizes_of("cylinder"), sizes_of("crowned")
    (('radius', 'length'), ('radius', 'crown_radius'))
    """
    pin = PINS[shape] if isinstance(shape, str) else shape
    needed = (size.name for size in fields(pin) if size.default is MISSING)
    return tuple(name for name in needed if name != "material")

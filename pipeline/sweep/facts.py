"""What a scene means: its contact, motion, wear and surface in closed form, before any simulation.

The worn contact is that of a smooth, rigid pin (`tribo.analytic`), joined with the elastic one so
that each holds where the other is small. Against simulations of smooth pins the width is within
3 %, the depth within 10 %, and of rough ones the width within 12 %.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pipeline.sweep.model import Sweep
from tribo import (
    Ball,
    InputError,
    MeasuredRoughness,
    Scene,
    SelfAffineRoughness,
    analytic,
    contact_modulus,
)
from tribo.types import Array

_MOST_PIXELS = 1_000_000  # of a random surface that is made only to describe it
_RQ_OF_RA = math.sqrt(math.pi / 2)  # of heights distributed normally
_LAY = 2.0  # slopes across the grooves, in those along them, from which a surface has a lay
_ROUGH_RISE = 3.0  # root mean squares by which peaks reach beyond the smooth contact


class Span(NamedTuple):
    """Lowest and highest value over the loads and velocities of a sweep, in SI."""

    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float] | Array) -> Span:
        """Span of some values."""
        array = np.asarray(values if isinstance(values, np.ndarray) else list(values))
        return cls(float(array.min()), float(array.max()))


@dataclass(frozen=True, slots=True)
class SurfaceFacts:
    """The disk's surface, on its pixels.

    Attributes
    ----------
    measured : bool
        Whether the heights come from a file.
    ra, rq : float
        Mean and root mean square distance of the heights from their mean plane [m].
    mean_height : float
        Mean height [m].
    rise : tuple of float
        Heights by which the mean plane rises over the window, along x and along y [m].
    lay : float or None
        Angle between the grooves and the sliding direction, from 0 to 90 [°]; None for a surface
        without grooves.
    """

    measured: bool
    ra: float
    rq: float
    mean_height: float = 0.0
    rise: tuple[float, float] = (0.0, 0.0)
    lay: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the facts by name, each with its unit."""
        heights = {"ra": self.ra, "rq": self.rq, "mean_height": self.mean_height, "rise": self.rise}
        return (
            {"kind": "measured" if self.measured else "random"}
            | {name: _with_unit(value, "m") for name, value in heights.items()}
            | {"lay": "none" if self.lay is None else _with_unit(self.lay, "degree")}
        )


@dataclass(frozen=True, slots=True)
class Facts:
    """What a scene means. Spans are over its loads and velocities.

    Attributes
    ----------
    contact_modulus : float
        Contact modulus of the two bodies [Pa].
    hertz_pressure : Span
        Highest pressure of the smooth, elastic, unworn contact [Pa].
    hertz_half_width : Span
        Half-width of that contact [m].
    contact_width : Span
        Width expected at the end of the points, worn and rough [m].
    contact_widths : tuple of tuple of float
        The same by load and velocity [m].
    window : tuple of float
        Sides of the window along x and y [m].
    duration : Span
        Time from the first contact to the end of the points [s].
    sliding_distance : Span
        Distance slid until then [m].
    wear_depth : Span or None
        Depth expected to be worn off the pin by then [m]; None without wear.
    peclet_number : Span
        V·a/(2κ) of the disk, after Jaeger, with the Hertzian half-width a.
    greatest_load : float
        Load at which the whole window would be at the hardness [N]; infinite without hardness.
    surface : SurfaceFacts or None
        Surface of the disk; None if it is smooth.
    """

    contact_modulus: float
    hertz_pressure: Span
    hertz_half_width: Span
    contact_width: Span
    contact_widths: tuple[tuple[float, ...], ...]
    window: tuple[float, float]
    duration: Span
    sliding_distance: Span
    wear_depth: Span | None
    peclet_number: Span
    greatest_load: float
    surface: SurfaceFacts | None

    def as_dict(self) -> dict[str, Any]:
        """Return the facts by name, each with its unit; what is not there or infinite left out."""
        found = {name: _with_unit(getattr(self, name), unit) for name, unit in _UNITS.items()}
        if self.surface:
            found["surface"] = self.surface.as_dict()
        return {name: entry for name, entry in found.items() if entry is not None}


_UNITS = {
    "contact_modulus": "Pa",
    "hertz_pressure": "Pa",
    "hertz_half_width": "m",
    "contact_width": "m",
    "window": "m",
    "duration": "s",
    "sliding_distance": "m",
    "wear_depth": "m",
    "peclet_number": "1",
    "greatest_load": "N",
}


def _with_unit(value: Any, unit: str) -> dict[str, Any] | None:
    """A value as plain data, with its unit."""
    if isinstance(value, Span):
        return value._asdict() | {"unit": unit}
    if isinstance(value, tuple):
        return {"x": value[0], "y": value[1], "unit": unit}
    return None if value is None or math.isinf(value) else {"value": value, "unit": unit}


def facts_of(sweep: Sweep) -> Facts:
    """Find what a scene means, without a simulation."""
    modulus = contact_modulus(sweep.pin.material, sweep.disk)
    velocities = np.array(sweep.velocities)
    pressures, half_widths = np.transpose([_hertz(sweep, load, modulus) for load in sweep.loads])
    durations, impulses = np.transpose([_duration(sweep, load) for load in sweep.loads])
    surface = surface_facts(sweep)
    worn = (sweep.wear.specific_wear_rate if sweep.wear else 0.0) * np.outer(impulses, velocities)
    widths, depths = _worn(sweep, half_widths[:, None], worn)
    if surface:
        widths = np.sqrt(widths**2 + 8 * sweep.pin.radius * _ROUGH_RISE * surface.rq)
    return Facts(
        contact_modulus=modulus,
        hertz_pressure=Span.of(pressures),
        hertz_half_width=Span.of(half_widths),
        contact_width=Span.of(widths),
        contact_widths=tuple(tuple(row) for row in widths.tolist()),
        window=sweep.grid.size,
        duration=Span.of(durations),
        sliding_distance=Span.of(np.outer(durations, velocities)),
        wear_depth=Span.of(depths) if sweep.wear else None,
        peclet_number=Span.of(
            np.outer(half_widths, velocities) / (2 * sweep.disk.thermal_diffusivity)
        ),
        greatest_load=greatest_load(sweep),
        surface=surface,
    )


def greatest_load(scene: Scene) -> float:
    """Load on the pin at which the whole window is at the hardness of the softer body [N]."""
    return scene.hardness * math.prod(scene.grid.size) * scene.pin.patches(scene.grid)


def require_bearable_loads(sweep: Sweep) -> None:
    """Raise `InputError` if the window cannot carry the highest load."""
    load, greatest = max(sweep.loads), greatest_load(sweep)
    if load > greatest:
        nx, ny = (1e6 * side for side in sweep.grid.size)
        raise InputError(
            f"sweep.loads: {load:g} N is more than the window carries: its {nx:.4g} × {ny:.4g} µm, "
            f"all at the hardness of the softer body, {1e-9 * sweep.hardness:g} GPa, stand for "
            f"{greatest:.4g} N on the pin; give loads below that, or more window.pixels"
        )


def surface_facts(sweep: Sweep) -> SurfaceFacts | None:
    """Describe the disk's surface; None if it is smooth.

    A random surface of more than a million pixels is described as it is asked for, not made.
    """
    rough = sweep.roughness
    if isinstance(rough, SelfAffineRoughness):
        if math.prod(sweep.pixels.shape) > _MOST_PIXELS:
            along_x, along_y = rough.correlation_length
            lay = 0.0 if along_x >= _LAY * along_y else 90.0 if along_y >= _LAY * along_x else None
            return SurfaceFacts(False, rough.ra, rough.ra * _RQ_OF_RA, lay=lay)
        heights = rough.heights(sweep.pixels)
    elif isinstance(rough, MeasuredRoughness):
        heights = rough.array
    else:
        return None
    level, rise = _level(heights)
    return SurfaceFacts(
        measured=isinstance(rough, MeasuredRoughness),
        ra=float(np.abs(level).mean()),
        rq=float(np.sqrt(np.mean(level**2))),
        mean_height=float(heights.mean()),
        rise=rise,
        lay=_lay(level, sweep.pixels.spacing),
    )


def _hertz(sweep: Sweep, load: float, modulus: float) -> tuple[float, float]:
    """Peak pressure [Pa] and half-width [m] of the smooth contact."""
    radius = sweep.pin.radius
    if isinstance(sweep.pin, Ball):
        pressure = analytic.hertz_point_peak_pressure(load, radius, modulus)
        return pressure, analytic.hertz_point_radius(load, radius, modulus)
    line = load / sweep.pin.length
    pressure = analytic.hertz_line_peak_pressure(line, radius, modulus)
    return pressure, analytic.hertz_line_half_width(line, radius, modulus)


def _duration(sweep: Sweep, load: float) -> tuple[float, float]:
    """Time until a point's end [s], and the load integrated over it [N s]."""
    stations = list(sweep.loading.stations(load, sweep.fidelity.increments))
    times = np.array([0.0, *(station.time for station in stations)])
    loads = np.array([0.0, *(station.normal_load for station in stations)])
    return float(times[-1]), float(np.trapezoid(loads, times))


def _worn(sweep: Sweep, half_widths: Array, worn_volumes: Array) -> tuple[Array, Array]:
    """Width of the smooth, worn contact and depth of the wear [m]."""
    radius, hertz = sweep.pin.radius, 2 * half_widths
    if isinstance(sweep.pin, Ball):
        flat = np.vectorize(analytic.worn_point_width)(worn_volumes, radius)
        width = (hertz**4 + flat**4) ** 0.25
        return width, 8 * worn_volumes / (math.pi * width**2)
    area = worn_volumes / sweep.pin.length
    flat = np.vectorize(analytic.worn_line_width)(area, radius)
    width = np.cbrt(hertz**3 + flat**3)
    return width, 1.5 * area / width


def _level(heights: Array) -> tuple[Array, tuple[float, float]]:
    """Heights above their mean plane, and how far that rises over the window [m].

    The coordinates of a grid are orthogonal, so each slope is a sum of its own.
    """
    level, rises = heights - heights.mean(), []
    for axis, count in enumerate(heights.shape):
        place = np.arange(count) - (count - 1) / 2
        profile = level.mean(axis=1 - axis)
        slope = float(place @ profile / max(place @ place, 1.0))
        level = level - slope * (place[:, None] if axis == 0 else place)
        rises.append(slope * count)
    return level, (rises[0], rises[1])


def _lay(heights: Array, spacing: tuple[float, float]) -> float | None:
    """Angle from the x axis of the direction in which heights change least [°]; None if any."""
    if min(heights.shape) < 2:
        return None
    along_x, along_y = np.gradient(heights, *spacing)
    xx, yy = float(np.mean(along_x**2)), float(np.mean(along_y**2))
    values, vectors = np.linalg.eigh([[xx, (xy := float(np.mean(along_x * along_y)))], [xy, yy]])
    if values[1] <= _LAY**2 * max(values[0], 0.0):
        return None
    x, y = np.abs(vectors[:, 0])
    return math.degrees(math.atan2(y, x))

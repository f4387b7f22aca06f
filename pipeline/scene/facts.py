"""Contact, motion, wear and surface of a scene in closed form, before any simulation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.scene.expected import expect_contacts
from pipeline.scene.parts import Parts
from pipeline.sweep.model import Sweep
from pipeline.sweep.surface import SurfaceFacts, surface_facts
from tribo import Corrections, InputError
from tribo.types import Array

USUAL_HARDNESS = 0.001, 0.2  # share of the elastic modulus; lead has 0.003, diamond 0.1
# Least length of a track in contact widths, so that a pass under the contact is short compared with
# the time to the next pass.
_FEWEST_WIDTHS = 10.0


class Span(NamedTuple):
    """Range of a quantity over the loads and velocities of a sweep, in SI."""

    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float] | Array) -> Span:
        """Range from the lowest to the highest of `values`."""
        array = np.array(list(values))
        return cls(float(array.min()), float(array.max()))


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Numbers that describe a scene. Each `Span` is over its loads and velocities."""

    hertz_pressure: Span  # highest pressure, smooth, elastic and unworn [Pa]
    hertz_half_width: Span  # half-width of that contact [m]
    contact_width: Span  # width expected at the end of the points, worn and rough [m]
    window: tuple[float, float]  # sides along x and y [m]
    duration: Span  # time from the first contact to the end of the points [s]
    sliding_distance: Span  # distance slid until then [m]
    wear_depth: Span | None = None  # expected on the pin at the end [m]; None without wear
    peclet_number: Span  # u a/(2κ) of the disk, a the half-width of Hertz
    surface: SurfaceFacts | None  # surface of the disk; None if it is smooth


def facts_of(sweep: Sweep) -> Facts:
    """Calculate numbers that describe a scene, in closed form: contact, wear, Péclet number."""
    scene, surface = sweep.scene, surface_facts(sweep)
    velocities, diffusivity = sweep.velocities, scene.disk.thermal_diffusivity
    _, disk = np.transpose([scene.velocities_at(velocity) for velocity in velocities])
    expected = expect_contacts(scene, sweep.loads, velocities, surface.rq if surface else 0.0)
    peclet = np.outer(expected["hertz_half_width"], np.abs(disk)) / (2 * diffusivity)
    return Facts(
        **{name: Span.of(values) for name, values in expected.items()},
        window=scene.grid.size,
        peclet_number=Span.of(peclet),
        surface=surface,
    )


def require_bearable_load(sweep: Sweep, load: float, key: str) -> None:
    """Raise an `InputError` if `load` [N] is too high for the size of the simulated window.

    The mean pressure over the window must not exceed the hardness. The message names `key`, the
    entry or option that gives the load.
    """
    scene = sweep.scene
    if load > scene.greatest_load:
        raise InputError(
            f"{key}: {load:g} N is more than the window of {display_sides(scene.grid.size)} "
            f"carries, {scene.greatest_load:.4g} N on the pin at the hardness of the softer body, "
            f"{display(scene.hardness, 'GPa')}; stay below that, give more window.pixels, or check "
            "the units"
        )


def track_faults(parts: Parts) -> Iterator[tuple[str, str]]:
    """Yield pairs (path, reason) of entries that make a track too short for the model."""
    corrections = parts.conditions.corrections or Corrections()
    tracks = {"pin": corrections.pin_track, "disk": corrections.track}
    width, plane = 0.0, parts.declared.sweep
    if any(tracks.values()):
        expected = expect_contacts(parts.scene, plane.loads, plane.velocities)
        width = float(
            expected["contact_width"].max()
        )  # of smooth bodies: to describe a surface is slow
    for name, track in tracks.items():
        if track and track.length < _FEWEST_WIDTHS * width:
            key = "diameter" if getattr(parts.declared, name).diameter else "track_length"
            yield (
                f"{name}.{key}",
                f"the track is {display(track.length, 'mm', 4)} long, which is less than "
                f"{_FEWEST_WIDTHS:g} times the width of the contact, {display(width, 'mm', 3)}; "
                f"give the whole way around the {name}",
            )

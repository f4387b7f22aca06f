"""Contact, motion, wear and surface of a scene in closed form, before any simulation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, get_origin, get_type_hints

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.scene.expected import expect_contacts
from pipeline.sweep.model import Parts, Sweep
from pipeline.sweep.surface import SurfaceFacts, surface_facts, unit_value
from tribo import Corrections, InputError, Track, contact_modulus
from tribo.types import Array

USUAL_HARDNESS = 0.001, 0.2  # share of the elastic modulus; lead has 0.003, diamond 0.1
_FEWEST_WIDTHS = 10.0  # contact widths in a track, so that a pass is short beside a round


class Span(NamedTuple):
    """Lowest and highest value over the loads and velocities of a sweep, in SI."""

    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float] | Array) -> Span:
        """Span of some values."""
        array = np.array(list(values))
        return cls(float(array.min()), float(array.max()))


@dataclass(frozen=True, slots=True)
class Facts:
    """Meaning of a scene in numbers. Spans are over its loads and velocities."""

    contact_modulus: Annotated[float, "Pa"]
    hertz_pressure: Annotated[Span, "Pa"]  # highest pressure, smooth, elastic and unworn
    hertz_half_width: Annotated[Span, "m"]  # half-width of that contact
    contact_width: Annotated[Span, "m"]  # width expected at the end of the points, worn and rough
    window: Annotated[tuple[float, float], "m"]  # sides along x and y
    duration: Annotated[Span, "s"]  # time from the first contact to the end of the points
    sliding_distance: Annotated[Span, "m"]  # distance slid until then
    wear_depth: Annotated[Span | None, "m"]  # expected on the pin by then; None without wear
    peclet_number: Annotated[Span, "1"]  # u a/(2κ) of the disk, a the half-width of Hertz
    pin_velocity: Annotated[Span | None, "m/s"]  # that of its surface through the contact
    disk_velocity: Annotated[Span | None, "m/s"]  # the same; both are None where the pin is at rest
    pin_turns: Annotated[Span | None, "1"]  # around its track until the end; None likewise
    greatest_load: Annotated[float, "N"]  # all the window at the hardness; may be infinite
    contact_widths: tuple[tuple[float, ...], ...]  # by load and velocity [m]
    surface: SurfaceFacts | None  # surface of the disk; None if it is smooth

    def as_dict(self) -> dict[str, Any]:
        """Return the facts by name, each with its unit; what is not there or infinite left out."""
        hints = get_type_hints(Facts, include_extras=True)
        units = {
            name: hint.__metadata__[0]
            for name, hint in hints.items()
            if get_origin(hint) is Annotated
        }
        facts = {
            name: value._asdict() | {"unit": unit}
            if isinstance(value := getattr(self, name), Span)
            else unit_value(value, unit)
            for name, unit in units.items()
        }
        if self.surface:
            facts["surface"] = self.surface.as_dict()
        return {name: entry for name, entry in facts.items() if entry is not None}


def facts_of(sweep: Sweep | Parts) -> Facts:
    """Calculate the facts of a scene in closed form."""
    scene, surface = sweep.scene, surface_facts(sweep)
    velocities = sweep.plane.velocities
    pin, disk = np.transpose([scene.velocities_at(velocity) for velocity in velocities])
    expected = expect_contacts(scene, sweep.plane.loads, velocities, surface.rq if surface else 0.0)
    turns = np.outer(expected.durations, np.abs(pin)) / scene.track_length
    peclet = np.outer(expected.half_widths, np.abs(disk)) / (2 * scene.disk.thermal_diffusivity)
    return Facts(
        contact_modulus=contact_modulus(scene.pin.material, scene.disk),
        hertz_pressure=Span.of(expected.peak_pressures),
        hertz_half_width=Span.of(expected.half_widths),
        contact_width=Span.of(expected.widths),
        contact_widths=tuple(tuple(row) for row in expected.widths.tolist()),
        window=scene.grid.size,
        duration=Span.of(expected.durations),
        sliding_distance=Span.of(expected.distances),
        wear_depth=Span.of(expected.depths) if scene.wear else None,
        peclet_number=Span.of(peclet),
        greatest_load=scene.greatest_load,
        surface=surface,
        pin_velocity=Span.of(pin) if scene.motion else None,
        disk_velocity=Span.of(disk) if scene.motion else None,
        pin_turns=Span.of(turns) if scene.motion else None,
    )


def require_bearable_load(sweep: Sweep, load: float, key: str) -> None:
    """Raise `InputError`, which names the key, if the window cannot carry a load."""
    greatest, hardness = sweep.scene.greatest_load, sweep.scene.hardness
    if load <= greatest:
        return
    raise InputError(
        f"{key}: {load:g} N is more than the window carries: its "
        f"{display_sides(sweep.scene.grid.size)}, all at the hardness of the softer body, "
        f"{display(hardness, 'GPa')}, stand for {greatest:.4g} N on the pin; stay below that, give "
        "more window.pixels, or check the units"
    )


def tracks_of(sweep: Sweep | Parts) -> dict[str, Track]:
    """Tracks that earlier turns have warmed, by their body."""
    corrections = sweep.conditions.corrections or Corrections()
    tracks = {"pin": corrections.pin_track, "disk": corrections.track}
    return {body: track for body, track in tracks.items() if track}


def track_faults(sweep: Sweep | Parts) -> Iterator[tuple[str, str]]:
    """Bodies whose track is too short, and why: each turn is taken to release its heat at once."""
    tracks = tracks_of(sweep)
    width = facts_of(sweep).contact_width.high if tracks else 0.0
    for body, track in tracks.items():
        if track.length < _FEWEST_WIDTHS * width:
            yield (
                body,
                f"the track is {display(track.length, 'mm', 4)} long, {track.length / width:.2g} "
                f"times the width of the contact, which is expected to be "
                f"{display(width, 'mm', 3)}; give the whole way around the {body}, at least "
                f"{_FEWEST_WIDTHS:g} times that width, {display(_FEWEST_WIDTHS * width, 'mm', 3)}",
            )

"""Warnings of a sweep, as every command counts them, and earlier turns that it does not count."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from pipeline.sweep.model import Sweep
from tribo import Corrections, Material, Motion, Pin, Track, contact_modulus
from tribo.types import Array

MELTS = 1700.0  # K, where a carbon steel of 1 % begins to

MOLTEN = (
    f"the deciding temperature is above {MELTS - 273.15:.0f} °C, where steel melts: the bodies "
    "of the model do not melt, so it says only that wear is severe; if tests were made here, check "
    "load, velocity and units"
)


@dataclass(frozen=True, slots=True)
class Warned:
    """Points of a sweep that carry a warning, by kind.

    Attributes
    ----------
    points : int
        Number of points with at least one warning.
    kinds : dict of int
        Number of points with a warning of each kind that occurs.
    at_boundary : int or None
        Number of these beside the boundary: a neighbour in load or in velocity has the other kind
        of wear.
        None where there is no boundary, for want of a critical temperature.
    example : str
        One of the points beside the boundary, or else any of them, with its warning.

    Examples
    --------
    >>> warned = Warned(2, {"contact at edge": 2}, 1, "400 N, 2.2 m/s: contact at edge")
    >>> first, second = warned.lines()
    >>> print(second)
    warning: at 400 N, 2.2 m/s: contact at edge
    """

    points: int
    kinds: dict[str, int]
    at_boundary: int | None
    example: str = ""

    def __add__(self, other: Warned) -> Warned:
        """Points of two sweeps."""
        beside = (self.at_boundary, other.at_boundary)
        return Warned(
            self.points + other.points,
            dict(Counter(self.kinds) + Counter(other.kinds)),
            None if None in beside else sum(filter(None, beside)),
            self.example or other.example,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)

    def lines(self) -> Iterator[str]:
        """Lines for the user; none where no point carries a warning."""
        if not self.points:
            return
        kinds = ", ".join(f"{kind} at {count}" for kind, count in self.kinds.items())
        if self.at_boundary is None:
            lies = "and it is not known which of them lie beside the boundary"
        elif self.at_boundary:
            lies = f"{self.at_boundary} beside the boundary, which may be wrong there"
        else:
            lies = "none beside the boundary"
        carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
        yield f"warning: {carry} a warning ({kinds}), {lies}"
        yield f"warning: at {self.example}"


NO_WARNING = Warned(0, {}, 0)
"""Of a sweep in which no point carries one."""


_HOT = 1e9  # K: a rise beside which the warming changes no share


def cold_bodies(motion: Motion | None, corrections: Corrections | None) -> tuple[str, ...]:
    """Bodies that roll as if each turn met a cold track; none unless both bodies roll.

    Examples
    --------
    >>> cold_bodies(Motion(slide_roll_ratio=0.5), None), cold_bodies(None, None)
    (('pin', 'disk'), ())
    """
    if motion is None or motion.slide_roll_ratio in (-2.0, 2.0):
        return ()
    present = corrections or Corrections()
    tracks = {"pin": present.pin_track, "disk": present.track}
    return tuple(body for body, track in tracks.items() if track is None)


def with_turns(
    corrections: Corrections | None, pin: Pin, disk: Material, motion: Motion | None
) -> tuple[Corrections, float]:
    """Corrections with earlier turns of all cold bodies, and the length of their tracks [m].

    That is the length around the pin by which it wears.
    """
    around = (motion and motion.track_length) or 2 * math.pi * pin.radius
    materials, names = {"pin": pin.material, "disk": disk}, {"pin": "pin_track", "disk": "track"}
    tracks: Any = {
        names[body]: Track.under(pin, materials[body], around)
        for body in cold_bodies(motion, corrections)
    }
    return replace(corrections or Corrections(), motion=motion, **tracks), around


def note_on_turns(
    sweep: Sweep, load: float | None = None, velocity: float | None = None
) -> str | None:
    """Say that earlier turns of bodies that roll are not counted; None where all are.

    By how much they would warm the contact at a load and velocity, by default those in the middle
    of the sweep, follows in closed form: the bodies share the heat as their effusivities times the
    roots of their speeds.
    """
    scene, conditions, plane = sweep.scene, sweep.conditions, sweep.plane
    load = plane.loads[len(plane.loads) // 2] if load is None else load
    if velocity is None:
        velocity = plane.velocities[len(plane.velocities) // 2]
    motion, pin = scene.motion, scene.pin
    cold = cold_bodies(motion, conditions.corrections)
    if not cold or motion is None or not velocity:
        return None
    turns, around = with_turns(conditions.corrections, pin, scene.disk, motion)
    alone = Corrections(
        motion=motion,
        pin_track=turns.pin_track if "pin" in cold else None,
        track=turns.track if "disk" in cold else None,
    )
    columns = columns_in_closed_form(sweep, load, velocity, _HOT)
    warming = conditions.friction * float(alone.added_rise(columns)[-1])
    return on_cold_bodies(
        cold,
        around,
        f"warm the contact by about {warming:.2g} K more at {load:g} N and {velocity:g} m/s",
    )


def columns_in_closed_form(
    sweep: Sweep, load: float, velocity: float, rise: float
) -> dict[str, Array]:
    """Columns that corrections need, of a smooth contact with a rise at its end [K]."""
    scene, pin = sweep.scene, sweep.scene.pin
    stations = list(scene.loading.stations(load, scene.fidelity.increments))
    times = np.array([station.time for station in stations])
    part_of_pin, part_of_disk = (
        body.thermal_effusivity * math.sqrt(abs(speed))
        for body, speed in zip(
            (pin.material, scene.disk), scene.velocities_at(velocity), strict=True
        )
    )
    hertz = pin.hertz(load, contact_modulus(pin.material, scene.disk))
    return {
        "time": times,
        "normal_load": np.array([station.normal_load for station in stations]),
        "sliding_distance": velocity * times,
        "mean_pressure": np.full_like(times, hertz.peak_pressure),
        "contact_width": np.full_like(times, 2 * hertz.half_width),
        "pin_heat_share": np.full_like(times, part_of_pin / (part_of_pin + part_of_disk)),
        "mean_rise": np.append(np.full(len(times) - 1, np.nan), rise),
    }


def on_cold_bodies(bodies: tuple[str, ...], around: float, by_how_much: str) -> str:
    """Say that earlier turns of some bodies are not counted, and how much they would matter."""
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"earlier turns of the {' and the '.join(bodies)} are not counted, as if each met a cold "
        f"track: on tracks of {1e3 * around:.3g} mm they would {by_how_much}; give {entries}, or "
        "track_length"
    )

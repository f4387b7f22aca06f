"""Earlier turns of bodies that roll, where a scene does not count them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.sweep.model import Sweep
from tribo import Corrections, Material, Motion, Pin, Track, contact_modulus

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
    stations = list(scene.loading.stations(load, scene.fidelity.increments))
    times = np.array([station.time for station in stations])
    part_of_pin, part_of_disk = (
        body.thermal_effusivity * math.sqrt(abs(speed))
        for body, speed in zip((pin.material, scene.disk), motion.velocities(velocity), strict=True)
    )
    hertz = pin.hertz(load, contact_modulus(pin.material, scene.disk))
    columns = {
        "time": times,
        "normal_load": np.array([station.normal_load for station in stations]),
        "sliding_distance": velocity * times,
        "mean_pressure": np.full_like(times, hertz.peak_pressure),
        "contact_width": np.full_like(times, 2 * hertz.half_width),
        "pin_heat_share": np.full_like(times, part_of_pin / (part_of_pin + part_of_disk)),
        "mean_rise": np.append(np.full(len(times) - 1, np.nan), _HOT),
    }
    warming = conditions.friction * float(alone.added_rise(columns)[-1])
    return on_cold_bodies(
        cold,
        around,
        f"warm the contact by about {warming:.2g} K more at {load:g} N and {velocity:g} m/s",
    )


def on_cold_bodies(bodies: tuple[str, ...], around: float, by_how_much: str) -> str:
    """Say that earlier turns of some bodies are not counted, and how much they would matter."""
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"earlier turns of the {' and the '.join(bodies)} are not counted, as if each met a cold "
        f"track: on tracks of {1e3 * around:.3g} mm they would {by_how_much}; give {entries}, or "
        "track_length"
    )

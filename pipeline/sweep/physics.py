"""Notes on what a scene leaves out: the earlier turns of bodies that roll, and sharp ends."""

from __future__ import annotations

import math
from collections.abc import Iterable
from statistics import median_high
from typing import Any

import numpy as np

from pipeline.quantities import display
from pipeline.sweep.model import Sweep
from tribo import Corrections, Motion, Scene, Track, contact_modulus
from tribo.types import Array

_HOT = 1e9  # K: a rise beside which the warming of earlier turns changes no share


def cold_bodies(motion: Motion | None, corrections: Corrections | None) -> tuple[str, ...]:
    """Bodies that roll as if each turn met a cold track; none unless both bodies roll."""
    if motion is None or motion.slide_roll_ratio in (-2.0, 2.0):
        return ()
    present = corrections or Corrections()
    tracks = {"pin": present.pin_track, "disk": present.track}
    return tuple(body for body, track in tracks.items() if track is None)


def turn_parts(scene: Scene, cold: Iterable[str]) -> tuple[dict[str, Any], float]:
    """Arguments of `Corrections` for earlier turns of cold bodies, and their tracks' length [m]."""
    pin, motion = scene.pin, scene.motion
    around = (motion and motion.track_length) or 2 * math.pi * pin.radius
    bodies = {"pin": ("pin_track", pin.material), "disk": ("track", scene.disk)}
    pairs = (bodies[body] for body in cold)
    tracks = {name: Track.under(pin, material, around) for name, material in pairs}
    return {"motion": motion, **tracks}, around


def note_on_turns(
    sweep: Sweep, load: float | None = None, velocity: float | None = None
) -> str | None:
    """Say that earlier turns of bodies that roll are not counted; None where all are.

    By how much they warm the contact at a load and velocity, by default in the middle of the sweep,
    follows in closed form: bodies share the heat as their effusivities times the roots of their
    speeds.
    """
    scene, conditions, plane = sweep.scene, sweep.conditions, sweep.plane
    load = median_high(plane.loads) if load is None else load
    velocity = median_high(plane.velocities) if velocity is None else velocity
    cold = cold_bodies(scene.motion, conditions.corrections)
    if not cold or not velocity:
        return None
    turns, around = turn_parts(scene, cold)
    columns = columns_in_closed_form(sweep, load, velocity, _HOT)
    rise = float(Corrections(**turns).added_rise(columns)[-1])
    warming = conditions.friction_at(velocity) * rise
    return describe_cold_bodies(
        cold,
        around,
        f"warm the contact by about {warming:.2g} K more at {load:g} N and {velocity:g} m/s",
    )


def note_on_ends(sweep: Sweep) -> str | None:
    """Say when sharp ends of a pin turn severe; None of other pins."""
    pin_turns = any(sweep.scene.velocities_at(v).pin for v in sweep.plane.velocities)
    if sweep.scene.pin.length is None or pin_turns:
        return None
    return (
        "only the pin's middle is computed: at sharp ends, wear turns severe at velocities 9 to "
        "23 % lower"
    )


def columns_in_closed_form(
    sweep: Sweep, load: float, velocity: float, rise: float
) -> dict[str, Array]:
    """Columns that corrections need, of a smooth contact with a rise at its end [K]."""
    scene, pin = sweep.scene, sweep.scene.pin
    stations = list(scene.way(load))
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


def describe_cold_bodies(bodies: tuple[str, ...], around: float, by_how_much: str) -> str:
    """Say that earlier turns of some bodies are not counted, and how much they would matter."""
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"earlier turns of the {' and the '.join(bodies)} are not counted, as if each met a cold "
        f"track: on tracks of {display(around, 'mm', 3)} they would {by_how_much}; give {entries} "
        "and width, or track_length"
    )

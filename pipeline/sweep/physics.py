"""Notes on what a scene leaves out: the earlier turns of bodies that roll, and sharp ends."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from pipeline.quantities import display
from pipeline.sweep.model import Sweep
from tribo import Corrections, Motion, Scene, Track


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


def note_on_turns(sweep: Sweep) -> str | None:
    """Say that earlier turns of bodies that roll are not counted; None where all are."""
    cold = cold_bodies(sweep.scene.motion, sweep.conditions.corrections)
    if not cold or not any(sweep.plane.velocities):
        return None
    _, around = turn_parts(sweep.scene, cold)
    return describe_cold_bodies(cold, around, "warm the contact further")


def note_on_ends(sweep: Sweep) -> str | None:
    """Say when sharp ends of a pin turn severe; None of other pins."""
    pin_turns = any(sweep.scene.velocities_at(v).pin for v in sweep.plane.velocities)
    if sweep.scene.pin.length is None or pin_turns:
        return None
    return (
        "only the pin's middle is computed: at sharp ends, wear turns severe at velocities 9 to "
        "23 % lower"
    )


def describe_cold_bodies(bodies: tuple[str, ...], around: float, by_how_much: str) -> str:
    """Say that earlier turns of some bodies are not counted, and how much they would matter."""
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"earlier turns of the {' and the '.join(bodies)} are not counted, as if each met a cold "
        f"track: on tracks of {display(around, 'mm', 3)} they would {by_how_much}; give {entries} "
        "and width, or track_length"
    )

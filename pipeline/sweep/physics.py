"""Notes on what a scene leaves out: the earlier turns of bodies that roll, and sharp ends."""

from __future__ import annotations

import math

from pipeline.quantities import display
from pipeline.sweep.model import Sweep
from tribo import Corrections


def note_on_turns(sweep: Sweep) -> str | None:
    """Say that earlier turns of bodies that roll are not counted; None where all are."""
    motion, pin = sweep.scene.motion, sweep.scene.pin
    is_rolling = motion is not None and motion.slide_roll_ratio not in (-2.0, 2.0)
    if not (is_rolling and any(sweep.plane.velocities)):
        return None
    present = sweep.conditions.corrections or Corrections()
    tracks = {"pin": present.pin_track, "disk": present.track}
    cold = [body for body, track in tracks.items() if track is None]
    if not cold:
        return None
    around = (motion and motion.track_length) or 2 * math.pi * pin.radius
    entries = " and ".join(f"{body}.diameter" for body in cold)
    return (
        f"earlier turns of the {' and the '.join(cold)} are not counted, as if each met a cold "
        f"track: on tracks of {display(around, 'mm', 3)} they would warm the contact further; give "
        f"{entries} and width, or track_length"
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

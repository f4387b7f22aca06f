"""What the model leaves out of a scene: heat of earlier turns of a track, sharp ends."""

from __future__ import annotations

from pipeline.sweep.sweep import Sweep
from tribo import Corrections, Track


def cold_tracks(sweep: Sweep) -> dict[str, Track | None]:
    """Tracks of rolling bodies that the scene treats as cold, although earlier turns warm them.

    A value is None if the length of the body's track is unknown. Keys are "pin_track" and "track"
    (of the disk), as in `Corrections`. The result is empty if no body rolls, all velocities are 0,
    or the heat of earlier turns is included.
    """
    motion, pin = sweep.scene.motion, sweep.scene.pin
    is_rolling = motion is not None and motion.slide_roll_ratio not in (-2.0, 2.0)
    if motion is None or not (is_rolling and any(sweep.velocities)):
        return {}
    present = sweep.conditions.corrections or Corrections()
    bodies = {
        "pin_track": (pin.material, motion.pin_track_length),
        "track": (sweep.scene.disk, motion.disk_track_length),
    }
    return {
        name: Track.from_pin(pin, material, length) if length else None
        for name, (material, length) in bodies.items()
        if getattr(present, name) is None
    }


def has_sharp_ends(sweep: Sweep) -> bool:
    """True for a cylinder, at whose sharp ends severe wear begins earlier, unless it turns."""
    pin_turns = any(sweep.scene.velocities_at(v).pin for v in sweep.velocities)
    return sweep.scene.pin.length is not None and not pin_turns

"""What the model leaves out of a scene: heat of earlier turns of a track, sharp ends."""

from __future__ import annotations

import math
from typing import Any

from pipeline.sweep.sweep import Sweep
from tribo import Corrections, Track


def cold_tracks(sweep: Sweep) -> dict[str, Any]:
    """Tracks of rolling bodies that the scene treats as cold, although earlier turns warm them.

    Values are `Track` objects. Keys are "pin_track" and "track" (of the disk), as in `Corrections`.
    The result is empty if no body rolls, all velocities are 0, or the heat of earlier turns is
    included.
    """
    motion, pin = sweep.scene.motion, sweep.scene.pin
    is_rolling = motion is not None and motion.slide_roll_ratio not in (-2.0, 2.0)
    if not (is_rolling and any(sweep.velocities)):
        return {}
    present = sweep.conditions.corrections or Corrections()
    around = (motion and motion.track_length) or 2 * math.pi * pin.radius
    materials = {"pin_track": pin.material, "track": sweep.scene.disk}
    cold = [name for name in materials if getattr(present, name) is None]
    return {name: Track.from_pin(pin, materials[name], around) for name in cold}


def has_sharp_ends(sweep: Sweep) -> bool:
    """True for a cylinder, at whose sharp ends severe wear begins earlier, unless it turns."""
    pin_turns = any(sweep.scene.velocities_at(v).pin for v in sweep.velocities)
    return sweep.scene.pin.length is not None and not pin_turns

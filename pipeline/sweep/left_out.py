"""What the model leaves out of a scene, in words: heat of earlier turns, sharp ends, films."""

from __future__ import annotations

import math
from typing import Any

from pipeline.quantities import display
from pipeline.shipped import typed_name
from pipeline.sweep.sweep import Sweep
from tribo import Corrections, Track

UNKNOWN_FILM = "the share of the load carried by the oil film is unknown here (irg help physics)"
"""Note for smooth bodies, balls and crowned pins in oil."""


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
    return {name: Track.under(pin, materials[name], around) for name in cold}


def note_on_turns(sweep: Sweep) -> str | None:
    """Note on how to include the heat of a track's earlier turns; None if none is left out."""
    tracks = cold_tracks(sweep)
    if not tracks:
        return None
    bodies = ["pin" if name == "pin_track" else "disk" for name in tracks]
    around = display(next(iter(tracks.values())).length, "mm", 3)
    entries = " and ".join(f"{body}.diameter" for body in bodies)
    return (
        f"heat from earlier revolutions of the {' and the '.join(bodies)} is not included; on "
        f"tracks of {around} it warms the contact further: set {entries} and width, or "
        "track_length, or enter the bulk temperature of the warm tracks"
    )


def has_sharp_ends(sweep: Sweep) -> bool:
    """True for a cylinder, at whose sharp ends severe wear begins earlier, unless it turns."""
    pin_turns = any(sweep.scene.velocities_at(v).pin for v in sweep.velocities)
    return sweep.scene.pin.length is not None and not pin_turns


def note_on_ends(sweep: Sweep) -> str | None:
    """Note that severe wear begins earlier at the sharp ends of a cylinder; None for others."""
    if not has_sharp_ends(sweep):
        return None
    return (
        "the pin's sharp ends are not modelled; severe wear starts there at 9–23 % lower velocity "
        "(irg help physics)"
    )


def doubt_lines(sweep: Sweep, most: int = 3, answered: bool = False) -> list[str]:
    """Lines with the gravest doubts about a scene, `most` of them, and the number of the others.

    In an answer (`answered`) those are left out that have caveats of their own: on sharp ends, on
    earlier turns, and on a narrow window, which stands at the points that it limits.
    """
    own = (note_on_ends(sweep), note_on_turns(sweep))
    lines = [
        str(doubt)
        for doubt in sweep.doubts
        if not answered or (doubt.words not in own and doubt.place != "window.pixels")
    ]
    if (more := len(lines) - most) > 0:
        lines[most:] = [f"and {more} more: irg check {typed_name(sweep.name)}"]
    return lines

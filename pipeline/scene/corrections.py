"""Physics beside the two half-spaces, from what a scene says of it."""

from __future__ import annotations

from typing import Any

import tribo
from pipeline.scene.entries import entry_at, quoted
from pipeline.scene.faults import Fault


def corrections_of(
    entries: dict[str, Any], pin: tribo.Cylinder | tribo.Ball | tribo.Crowned, disk: tribo.Material
) -> tribo.Corrections | None:
    """Corrections of sound entries; None if there are none.

    Parameters
    ----------
    entries : dict
        Parts of the format that describe the file.
    pin : tribo.Cylinder, tribo.Ball or tribo.Crowned
        The pin.
    disk : tribo.Material
        Material of the disk.
    """
    coefficient = entries["friction"]["coefficient"]
    stem, film = entries["pin"]["stem"], entries["disk"]["film"]
    track = entries["disk"]["track_length"]
    measured = sorted(
        (entry["velocity"], entry["coefficient"]) for entry in entries["friction"]["by_velocity"]
    )
    corrections = tribo.Corrections(
        friction=tuple((velocity, mu / coefficient) for velocity, mu in measured),
        track=tribo.Track.under(pin, disk, track) if track else None,
        stem=_stem(stem, pin.material) if stem else None,
        film_resistance=film["thickness"] / film["thermal_conductivity"] if film else 0.0,
    )
    return corrections if corrections != tribo.Corrections() else None


def check_corrections(entries: dict[str, Any], faults: list[Fault]) -> None:
    """Note corrections that do not fit the rest of a scene."""
    measured = entry_at(entries, "friction.by_velocity")
    if measured and all(measured):
        velocities = [entry["velocity"] for entry in measured]
        twice = sorted({velocity for velocity in velocities if velocities.count(velocity) > 1})
        if twice and None not in velocities:
            problem = f"has {twice[0]:g} m/s twice; give each velocity once"
            faults.append(Fault("friction.by_velocity", problem))
        if entry_at(entries, "friction.coefficient") == 0:
            problem = "0 cannot be scaled by friction.by_velocity; give a typical one, such as 0.1"
            faults.append(Fault("friction.coefficient", problem))
        if isinstance(entry_at(entries, "temperature.bulk"), dict):
            problem = (
                "pin and disk have bulk temperatures of their own, and then the rise is not "
                "proportional to friction; give one temperature.bulk, or leave this out"
            )
            faults.append(Fault("friction.by_velocity", problem))
    if entry_at(entries, "disk.track_length") and entries.get("motion"):
        problem = (
            "earlier passes are counted under a pin at rest, and the scene has a [motion]; leave "
            f"out {quoted('disk.track_length')} or [motion]"
        )
        faults.append(Fault("disk.track_length", problem))


def _stem(stem: dict[str, Any], material: tribo.Material) -> tribo.Stem:
    if "resistance" in stem:
        return tribo.Stem(stem["resistance"])
    conduction = material.thermal_conductivity, material.thermal_diffusivity
    return tribo.Stem.rod(stem["length"], stem["area"], *conduction)

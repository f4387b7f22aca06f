"""Earlier turns that a stored sweep does not count, and how far they would move its boundary."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.boundary import boundary_under
from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import has_one_scene
from pipeline.sweep.turns import cold_bodies, on_cold_bodies, with_turns
from tribo import Ball, Crowned, Cylinder, Material, Motion

_PARTS = {kind.__name__: kind for kind in (Ball, Crowned, Cylinder, Material, Motion)}


def turns_left_out(ds: xr.Dataset, crossings: xr.Dataset, **conditions: Any) -> str | None:
    """Say that bodies roll as if each turn met a cold track; None where none does.

    Parameters
    ----------
    ds : Dataset
        A sweep of loads and velocities.
    crossings : Dataset
        Its boundary, of `pipeline.boundary`.
    **conditions
        Conditions that the boundary was judged by in place of the sweep's own.
    """
    scene = attributes_of(ds).get("scene", {})
    if not (scene.get("motion") and has_one_scene(ds)) or np.ndim(conditions.get("friction", 0.0)):
        return None
    judged = conditions_of(ds, **conditions)
    motion = _made(scene["motion"])
    cold = cold_bodies(motion, judged.corrections)
    if not cold:
        return None
    pin, disk = _made(scene["pin"]), _made(scene["disk"])
    corrections, around = with_turns(judged.corrections, pin, disk, motion)
    warm = boundary_under(ds, replace(judged, corrections=corrections))
    moved = (warm["critical_velocity"] / crossings["critical_velocity"] - 1).values
    moved = 100 * moved[np.isfinite(moved)]
    size = "move the boundary to lower velocities, by more than is computed here"
    if moved.size:
        size = f"move the critical velocities by {moved.max():+.0f} to {moved.min():+.0f} %"
    return on_cold_bodies(cold, around, size)


def _made(plain: Any) -> Any:
    """A part of `tribo` from the plain data that a store has of it."""
    if not isinstance(plain, dict):
        return plain
    entries = {name: _made(value) for name, value in plain.items() if name != "type"}
    return _PARTS[plain["type"]](**entries)

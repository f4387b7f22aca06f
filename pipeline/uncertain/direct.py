"""Direct simulations of draws, without the emulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import run_point
from pipeline.sweep.severity import worst_rises
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import FRICTION
from tribo.types import Array

SceneWith = Callable[[Mapping[str, Any]], Sweep]
"""Gives the scene of the samples with entries by their paths, as a scene file has them."""


def log_rise(sweep: Sweep, load: float, velocity: float, judged: Conditions) -> float:
    """Logarithm of the rise that decides at friction 1, by a simulation from the start on.

    It is judged as the samples are, with the corrections of its own scene.
    """
    columns = run_point(sweep.changed(steps="end"), load, velocity).columns
    conditions = replace(judged, corrections=sweep.conditions.corrections)
    return math.log(float(worst_rises(columns, load, conditions)))


def scene_values(ensemble: Ensemble, row: Sequence[float] | Array) -> dict[str, Any]:
    """Inputs drawn and fixed as entries of a scene, without friction: rises are at friction 1."""
    pairs = [*zip(ensemble.unknown, np.asarray(row).tolist(), strict=True)]
    pairs += [(one.unknown, one.value) for one in ensemble.fixed]
    return {one.path: _entry(one, value) for one, value in pairs if one.path != FRICTION}


def _entry(unknown: Unknown, value: float) -> float | int | str:
    unit = unknown.shown
    if unit.name != "1":
        return f"{float(unit.express(value))!r} {unit.name}"
    return int(value) if unknown.kind == "list" and value == int(value) else float(value)

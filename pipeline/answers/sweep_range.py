"""Reasons that a point lies outside the loads and velocities of its sweep."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pipeline.answers.case_results import CaseResults
from pipeline.quantities import UNITS
from tribo import Stages

_AXIS_ENTRIES = {"load": "loads", "velocity": "velocities"}


def outside_reason(
    case: CaseResults, ranges: Mapping[str, tuple[float, float]], **point: float
) -> str:
    """Reason that a load and a velocity are unknown; empty if they lie within `ranges`."""
    outside = {
        name: value
        for name, value in point.items()
        if not (ranges[name][0] <= value <= ranges[name][1] and value > 0)
    }
    if not outside:
        return ""
    texts = []
    for name, value in outside.items():
        (low, high), unit = ranges[name], UNITS[name]
        texts.append(f"{name} {value:g} {unit} is outside the sweep ({low:g} to {high:g} {unit})")
    limits = ", ".join(texts)
    if not all(0 < value < math.inf for value in point.values()):
        return f"{limits}; give a value inside it"
    if case.own_load is not None and "velocity" not in outside:
        return f"{limits}; add a factor to sweep.load_factors, and run the scene again"
    if case.is_row:
        requested = ", ".join(f"{name} {value:g} {UNITS[name]}" for name, value in point.items())
        return (
            f"{requested} is not a case of the sweep, in which each case has its own load and "
            "velocity; add it to sweep.along, and run the scene again"
        )
    if isinstance(case.sweep.scene.loading, Stages):  # which end at the highest load
        return f"{limits}; run the scene with it into another store"
    entries = " and ".join(f"sweep.{_AXIS_ENTRIES[name]}" for name in outside)
    return f"{limits}; add it to {entries}, and run the scene again"

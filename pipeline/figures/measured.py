"""Measured transitions, and what is computed at the friction that was measured there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from pipeline.analysis.interpolation import crossing
from pipeline.figures.style import BLACK, GREY
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit

_NEAR = 0.02  # relative difference of friction that is not worth a mark of its own


def measured_transitions(axes: Axes, measured: Sequence[Mapping[str, Any]]) -> list[Artist]:
    """Mark the transitions that were measured."""
    if not measured:
        return []
    line = axes.plot(
        [point["velocity"] for point in measured],
        [point["normal_load"] for point in measured],
        ls="none", marker="D", ms=8, mfc=BLACK, mec="white", mew=1.3, zorder=4,
        label="measured transition", gid="measured",
    )  # fmt: skip
    return list(line)


def at_own_friction(
    axes: Axes, plane: xr.DataArray, measured: Sequence[Mapping[str, Any]], conditions: Conditions
) -> list[Artist]:
    """Mark the transition computed at the friction of each measured one, and join both.

    One at about the friction of the diagram lies beside its line anyway, and is left out.
    """
    transitions = []
    loads, velocities = plane["load"].values, plane["velocity"].values
    for point in measured:
        friction = point.get("friction")
        if not friction or abs(friction / (conditions.friction or math.inf) - 1) < _NEAR:
            continue
        if not loads[0] <= point["normal_load"] <= loads[-1]:
            continue
        off = np.abs(loads - point["normal_load"])
        row = plane.values[np.flatnonzero(off == off.min())[-1]]  # of two as near, the higher load
        limit = rise_limit(conditions.at_friction(friction))
        velocity = crossing(velocities, row, limit)
        if math.isfinite(velocity):
            transitions.append((velocity, point))
    for velocity, point in transitions:
        ends = [velocity, point["velocity"]], [point["normal_load"]] * 2
        axes.plot(*ends, color=GREY, lw=1.0, zorder=3.6, gid="to own friction")
    if not transitions:
        return []
    line = axes.plot(
        [velocity for velocity, _ in transitions],
        [point["normal_load"] for _, point in transitions],
        ls="none", marker="D", ms=5.5, mfc="white", mec=BLACK, mew=1.1, zorder=3.9,
        label="computed at the friction measured", gid="at own friction",
    )  # fmt: skip
    return list(line)

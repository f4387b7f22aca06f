"""Why a place of a sweep is unknown, and the command that adds it."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping

from pipeline.analysis.results import Results
from pipeline.quantities import UNITS
from pipeline.shipped import typed_name

_ENTRIES = {"load": "sweep.loads", "velocity": "sweep.velocities"}


def why_unknown(
    data: Results,
    ranges: Mapping[str, tuple[float, float]],
    load: float,
    velocity: float,
    is_known: bool,
) -> str:
    """Why nothing is known at a load [N] and a velocity [m/s]; empty if `is_known` within `ranges`.

    `ranges` has the lowest and the highest "load" and "velocity" of the sweep.
    """
    for name, value in (("load", load), ("velocity", velocity)):
        lowest, highest = ranges[name]
        if not (lowest <= value <= highest and value > 0):
            unit = UNITS[name]
            said = f"{name} is {value:g} {unit}; the sweep has {lowest:g} to {highest:g} {unit}"
            if not 0 < value < math.inf:
                return f"{said}: give one within"
            return f"{said}; this adds it: {_adding_command(data, name, value)}"
    if is_known:
        return ""
    if data.surface and not data.asked.all():
        name = typed_name(data.stored.name)
        return (
            f"patch {data.surface[0][1]} has points beside the boundary alone, none about "
            f"{load:g} N and {velocity:g} m/s; judge all patches without --at realization, or "
            f"compute all points of each: irg run {name} --set sweep.realizations=4"
        )
    return (
        f"too few points about {load:g} N and {velocity:g} m/s are done to tell; run the sweep to "
        "its end, or add points there"
    )


def _adding_command(data: Results, name: str, value: float) -> str:
    """Command that computes the sweep at a further "load" [N] or "velocity" [m/s], too."""
    sweep, entry = data.stored, _ENTRIES[name]
    axis = sweep.loads if name == "load" else sweep.velocities
    listed = [f"{one!r} {UNITS[name]}".replace(".0 ", " ") for one in sorted({*axis, value})]
    setting = f"{entry}={json.dumps(listed)}"
    store = str(data.store or "")
    usual = store.endswith(f"results/{sweep.name}.zarr") or not store
    out = [] if usual else ["-o", store]
    return shlex.join(["irg", "run", typed_name(sweep.name), *out, "--set", setting])

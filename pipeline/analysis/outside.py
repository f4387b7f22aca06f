"""The command that adds a load or a velocity to a sweep."""

from __future__ import annotations

import json
import math
import shlex
from typing import Any

from pipeline.analysis.results import Results
from pipeline.quantities import UNITS
from pipeline.scene.shipped import typed_name
from pipeline.scene.units import to_si

_ENTRIES = {"load": "sweep.loads", "velocity": "sweep.velocities"}
_BESIDE = 1e-9  # rounding of a number of steps


def adding_command(data: Results, name: str, value: float) -> str:
    """Command that computes the sweep at a further "load" [N] or "velocity" [m/s], too."""
    sweep, entry = data.stored, _ENTRIES[name]
    written = sweep.entries.get("sweep", {}).get(entry.partition(".")[2])
    axis = sweep.loads if name == "load" else sweep.velocities
    setting = _longer_range(entry, written, value, UNITS[name]) or _list(entry, axis, value, name)
    store = str(data.store or "")
    usual = store.endswith(f"results/{sweep.name}.zarr") or not store
    out = [] if usual else ["-o", store]
    return shlex.join(["irg", "run", typed_name(sweep.name), *out, "--set", setting])


def _longer_range(entry: str, written: Any, value: float, unit: str) -> str:
    """Setting that lengthens a range by whole steps up to a value; empty without a step."""
    if not isinstance(written, dict) or "step" not in written:
        return ""
    first, last, step = (to_si(written[key], f"1 {unit}") for key in ("from", "to", "step"))
    if value > last:
        count = math.ceil((value - last) / step - _BESIDE)
        return f"{entry}.to={last + count * step:.10g} {unit}"
    count = math.ceil((first - value) / step - _BESIDE)
    lowest = first - count * step
    return f"{entry}.from={lowest:.10g} {unit}" if lowest > 0 else ""


def _list(entry: str, axis: tuple[float, ...], value: float, name: str) -> str:
    """Setting that lists the values of an axis, and a further one."""
    listed = [f"{one!r} {UNITS[name]}".replace(".0 ", " ") for one in sorted({*axis, value})]
    return f"{entry}={json.dumps(listed)}"

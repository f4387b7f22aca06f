"""What the dataset of a sweep holds: its variables and its attributes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import metadata
from typing import Any, NamedTuple

from pipeline.store.identity import describe, scene_hash
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from tribo import QUANTILES, WarningKind

__all__ = [
    "BY_POINT",
    "COLUMNS",
    "COMPACT",
    "COORDINATES",
    "DONE",
    "FAILED",
    "FIELDS",
    "FORMAT",
    "HASHED",
    "PENDING",
    "RECORDS",
    "VARIABLES",
    "Variable",
    "grown",
    "lasting_attributes",
    "note_versions",
    "present_attributes",
    "variables",
    "versions",
]

FORMAT = 2
"""Version of the layout; a program reads this one and older ones."""
HASHED = 2
"""Version from which the root has a hash, and a point's checksum holds its load and velocity."""

BY_POINT, COMPACT = ".", "/"
"""What separates the numbers in the names of chunks that hold one point, and of those with many."""

PENDING, DONE, FAILED = 0, 1, 2
"""Values of the variable ``status``."""


class Variable(NamedTuple):
    """Dimensions, unit, meaning, NumPy type and further attributes of a variable."""

    dims: tuple[str, ...]
    units: str | None
    long_name: str
    dtype: str = "float64"
    attributes: Mapping[str, Any] = {}


_POINT = ("load", "velocity")
_STEP = (*_POINT, "step")
_FIELD = (*_POINT, "x", "y")
_RISE = "per unit friction coefficient"


def _of_contact(units: str, long_name: str) -> Variable:
    """Give a variable at every step, which the size of the elements decides."""
    comment = (
        "Depends on the size of the elements: a rough surface on larger ones touches on more of "
        "the window at a lower pressure. In the paper's system the preset 'standard' has 14 to "
        "17 % more contact than the pixels themselves, 'draft' 40 to 50 %. NaN at steps on the "
        "coarser grid of the history."
    )
    return Variable(_STEP, units, long_name, attributes={"comment": comment})


COORDINATES = {
    "realization": Variable(("realization",), "1", "seed of the random surface", "int64"),
    "load": Variable(("load",), "N", "normal load on the pin at the end of the ramp"),
    "velocity": Variable(("velocity",), "m/s", "sliding velocity"),
    "step": Variable(("step",), "1", "step of the ramp", "int64"),
    "quantile": Variable(("quantile",), "1", "share of the contact area that is cooler"),
    "x": Variable(("x",), "m", "position along the sliding direction"),
    "y": Variable(("y",), "m", "position across the sliding direction"),
}
COLUMNS = {
    "time": Variable(_STEP, "s", "time since the start of the ramp"),
    "normal_load": Variable(_STEP, "N", "normal load on the pin"),
    "sliding_distance": Variable(_STEP, "m", "sliding distance since the start of the ramp"),
    "contact_fraction": _of_contact("1", "share of the window in contact"),
    "contact_width": _of_contact("m", "width of the contact along the sliding direction"),
    "max_pressure": _of_contact("Pa", "highest contact pressure"),
    "mean_pressure": _of_contact("Pa", "mean pressure over the contact"),
    "saturated_fraction": _of_contact("1", "share of the contact at the hardness"),
    "wear_depth_max": Variable(_STEP, "m", "greatest wear depth of the pin"),
    "wear_volume": Variable(_STEP, "m3", "worn volume of the whole pin"),
    "iterations": Variable(_STEP, "1", "iterations of the contact solver"),
    "residual": Variable(_STEP, "1", "residual of the contact solver"),
    "max_rise": Variable(_STEP, "K", f"highest temperature rise of the contact {_RISE}"),
    "mean_rise": Variable(_STEP, "K", f"mean temperature rise of the contact {_RISE}"),
    "pin_heat_share": Variable(_STEP, "1", "share of the friction heat that enters the pin"),
    "rise_quantile": Variable(
        (*_STEP, "quantile"), "K", f"quantile of the temperature rise of the contact {_RISE}"
    ),
}
FIELDS = {
    "pressure": Variable(_FIELD, "Pa", "contact pressure at the end of the ramp"),
    "rise": Variable(_FIELD, "K", f"temperature rise of the pin at the end of the ramp {_RISE}"),
    "wear_depth": Variable(_FIELD, "m", "wear depth of the pin at the end of the ramp"),
}
RECORDS = {
    "status": Variable(
        _POINT,
        None,
        "state of the point",
        "int8",
        {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"},
    ),
    "wall_time": Variable(_POINT, "s", "duration of the point's computation"),
    "finished_at": Variable(_POINT, "s", "when the point was finished, since 1970-01-01 UTC"),
    "message": Variable(_POINT, None, "why the point failed, or what to know of it", "str"),
    "warning_flags": Variable(
        _POINT,
        None,
        "what to know of the point before relying on it",
        "int32",
        {
            "flag_masks": [int(kind) for kind in WarningKind],
            "flag_meanings": " ".join(kind.label.replace(" ", "_") for kind in WarningKind),
        },
    ),
    "checksum": Variable(_POINT, None, "BLAKE2b-64 of the point's data", "uint64"),
}

VARIABLES = COORDINATES | RECORDS | COLUMNS | FIELDS
"""All that a store may hold; its status first, so that who reads all has it before the data."""


def variables(over_surfaces: bool, with_fields: bool) -> dict[str, Variable]:
    """Variables of a store, the leading dimension ``realization`` only over several surfaces."""
    left_out = set() if with_fields else {"x", "y", *FIELDS}
    found = {name: variable for name, variable in VARIABLES.items() if name not in left_out}
    if not over_surfaces:
        del found["realization"]
        return found
    return {
        name: variable
        if name in COORDINATES
        else variable._replace(dims=("realization", *variable.dims))
        for name, variable in found.items()
    }


def lasting_attributes(sweep: Sweep) -> dict[str, Any]:
    """Attributes that a store keeps from its creation: the scene, and what computed it."""
    description = describe(sweep)
    return {
        "Conventions": "CF-1.11",
        "format": FORMAT,
        "scene": description,
        "scene_hash": scene_hash(description),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Versions of what computes and stores."""
    try:
        tribo = metadata.version("irg-transition")
    except metadata.PackageNotFoundError:  # run from its source
        tribo = "unknown"
    return {"tribo": tribo} | {name: metadata.version(name) for name in ("numpy", "scipy", "zarr")}


def note_versions(attributes: dict[str, Any]) -> None:
    """Add the present versions to a store's attributes, if its last run had others."""
    later = attributes.get("later_versions", [])
    last = later[-1]["versions"] if later else attributes["versions"]
    if last != (present := versions()):
        since = datetime.now(UTC).isoformat(timespec="seconds")
        attributes["later_versions"] = [*later, {"since": since, "versions": present}]


def present_attributes(sweep: Sweep) -> dict[str, Any]:
    """Attributes that follow the scene file, since they do not decide the numbers.

    Why the fidelity was picked is kept from an earlier run, if this one did not pick it.
    """
    picked = {"selection": sweep.selection.as_dict()} if sweep.selection else {}
    return picked | {
        "name": sweep.name,
        "title": sweep.title,
        "preset": sweep.preset,
        "conditions": asdict(sweep.conditions),
        "friction_band": list(sweep.friction_band) if sweep.friction_band else None,
        "measured": [asdict(measurement) for measurement in sweep.measured],
        "loads": list(sweep.loads),
        "velocities": list(sweep.velocities),
        "realizations": list(sweep.realizations),
        "chosen": None if sweep.chosen is None else [list(point) for point in sweep.chosen],
    }


def grown(axes: Mapping[str, list[float]], sweep: Sweep) -> dict[str, list[float]]:
    """Values along each dimension: those of a store, in their order, then what a sweep adds."""
    steps = max(step_count(sweep, load) for load in sweep.loads)

    def widened(name: str, wanted: Iterable[float]) -> list[float]:
        known = axes.get(name, [])
        return [*known, *(new for new in wanted if new not in known)]

    return {
        "realization": widened("realization", sweep.realizations),
        "load": widened("load", sweep.loads),
        "velocity": widened("velocity", sweep.velocities),
        "step": list(range(1, max(steps, len(axes.get("step", []))) + 1)),
        "quantile": list(QUANTILES),
        "x": sweep.grid.coordinates(0).tolist(),
        "y": sweep.grid.coordinates(1).tolist(),
    }

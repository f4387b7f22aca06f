"""What the dataset of a sweep holds: its variables and its attributes."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import Any, NamedTuple

from pipeline.store.identity import describe, scene_hash
from pipeline.sweep.chosen import Chosen, Variant
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.unknown import drawn
from tribo import BULK_RATIOS, QUANTILES, WarningKind

FORMAT = 4
"""Version of the layout; a program reads this one and older ones."""
PACKED = 4
"""Version of stores of samples, which say in bits what a search chose; others list the points."""
SHARED = 3
"""Version of other stores, in which points may share chunks, as they do not in older ones."""
HASHED = 2
"""Version from which the root has a hash, and a point's checksum holds its load and velocity."""

BY_POINT, COMPACT = ".", "/"
"""Separators of the numbers in the names of chunks: where points are written, and where not."""

POINTS_PER_CHUNK = "points_per_chunk"
"""Attribute of a store whose chunks hold several points also where they are written."""
KEPT_COMPACT = "kept_compact"
"""Attribute of a store that was compact once, and is to be so whenever no run computes points."""
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
    """A variable at every step that depends on the size of the elements."""
    comment = (
        "Depends on the size of the elements: a rough surface on larger ones touches on more of "
        "the window at a lower pressure. In the paper's system the preset 'standard' has 14 to "
        "17 % more contact than the pixels themselves, 'draft' 40 to 50 %. NaN at steps on the "
        "coarser grid of the history."
    )
    return Variable(_STEP, units, long_name, attributes={"comment": comment})


COORDINATES = {
    "realization": Variable(("realization",), "1", "seed of the random surface", "int64"),
    "sample": Variable(("sample",), "1", "number of the sample of unknown inputs", "int64"),
    "load": Variable(("load",), "N", "normal load on the pin at the end of the ramp"),
    "velocity": Variable(("velocity",), "m/s", "sliding velocity"),
    "step": Variable(("step",), "1", "step of the ramp", "int64"),
    "quantile": Variable(("quantile",), "1", "share of the contact area that is cooler"),
    "bulk_ratio": Variable(
        ("bulk_ratio",), "K", "bulk temperature of the disk less that of the pin, over friction"
    ),
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
    "wear_volume": Variable(_STEP, "m^3", "worn volume of the whole pin"),
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
BULK_COLUMNS = {
    "mean_bulk_response": Variable(
        _STEP, "1", "mean rise of the contact for each kelvin by which the disk's bulk is warmer"
    ),
    "bulk_rise_quantile": Variable(
        (*_STEP, "bulk_ratio", "quantile"),
        "K",
        f"quantile of the contact's rise above the pin's bulk at a bulk ratio, {_RISE}",
    ),
}
"""What scenes with unequal bulk temperatures have besides `COLUMNS`."""
BULK_FIELDS = {
    "bulk_response": Variable(
        _FIELD, "1", "rise of the pin for each kelvin by which the disk's bulk is warmer"
    ),
}
"""What they have besides `FIELDS`."""
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

VARIABLES = COORDINATES | RECORDS | COLUMNS | BULK_COLUMNS | FIELDS | BULK_FIELDS
"""All that a store may hold; the status first, so that a reader of all has it before the data."""


LEADING = ("realization", "sample")
"""Dimensions of which one may stand in front of the others."""

_INPUT = Variable(("sample",), None, "value drawn of an input that is not known exactly")
_PATH = re.compile(r"[\w-]+(\.[\w-]+)+")


def is_coordinate(name: str) -> bool:
    """Whether a variable is a coordinate: of a dimension, or an input by its path in the scene."""
    return name in COORDINATES or _PATH.fullmatch(name) is not None


def variable_of(name: str) -> Variable | None:
    """What a store may hold under a name, without what leads its dimensions; None if nothing."""
    return VARIABLES.get(name) or (_INPUT if is_coordinate(name) else None)


def variables(
    leading: str | None,
    with_fields: bool,
    of_bulks: bool,
    inputs: Mapping[str, str] | None = None,
) -> dict[str, Variable]:
    """Variables of a store.

    Parameters
    ----------
    leading : str or None
        The one of `LEADING` that stands in front of the dimensions, if one does.
    with_fields : bool
        Whether the fields at the end of each point are kept.
    of_bulks : bool
        Whether the bodies differ in bulk temperature.
    inputs : mapping, optional
        Unit of each input that is drawn, by its path in the scene.
    """
    left_out = {name for name in LEADING if name != leading}
    if not with_fields:
        left_out |= {"x", "y", *FIELDS, *BULK_FIELDS}
    if not of_bulks:
        left_out |= {"bulk_ratio", *BULK_COLUMNS, *BULK_FIELDS}
    found = {name: variable for name, variable in VARIABLES.items() if name not in left_out}
    coordinates = {path: _INPUT._replace(units=unit) for path, unit in (inputs or {}).items()}
    if leading is None:
        return found
    return coordinates | {
        name: variable if name in COORDINATES else variable._replace(dims=(leading, *variable.dims))
        for name, variable in found.items()
    }


def lasting_attributes(sweep: Sweep) -> dict[str, Any]:
    """Attributes that a store keeps from its creation: the scene, and what computed it."""
    description = describe(sweep)
    return {
        "Conventions": "CF-1.11",
        "format": PACKED if sweep.axis and sweep.axis[0] == "sample" else SHARED,
        "scene": description,
        "scene_hash": scene_hash(description),
        "versions": versions(),
    }


@functools.cache
def versions() -> Mapping[str, str]:
    """Versions of the packages that compute and store."""
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


def present_attributes(sweep: Sweep, version: int = SHARED) -> dict[str, Any]:
    """Attributes that follow the scene file, since they do not decide the numbers.

    Why the fidelity was picked is kept from an earlier run, if this one did not pick it. The store
    has the layout of a version.
    """
    picked = {"selection": sweep.selection.as_dict()} if sweep.selection else {}
    lubrication = Lubrication.of(sweep)
    oiled = {"lubrication": lubrication.as_dict()} if lubrication else {}
    return (
        picked
        | oiled
        | _samples_of(sweep)
        | {
            "name": sweep.name,
            "title": sweep.title,
            "preset": sweep.preset,
            "conditions": sweep.conditions.as_dict(),
            "friction_band": list(sweep.friction_band) if sweep.friction_band else None,
            "measured": [measurement.as_dict() for measurement in sweep.measured],
            "loads": list(sweep.loads),
            "velocities": list(sweep.velocities),
            "realizations": list(sweep.realizations),
            "chosen": _chosen_as_data(sweep, version),
        }
    )


PRESENT = ("coordinates", "lubrication", "samples", "sample_seed", "unknown")
"""Present attributes that a store has only where there are samples, or an oil."""


def _samples_of(sweep: Sweep) -> dict[str, Any]:
    """What is unknown and how it was drawn; nothing where there are no samples.

    ``coordinates`` is where readers of CF look for coordinates that are not dimensions.
    """
    if not sweep.samples:
        return {}
    samples = sweep.samples
    paths = " ".join(each.path for each in samples.unknown)
    return ({"coordinates": paths} if samples.are_simulated and paths else {}) | {
        "samples": len(samples),
        "sample_seed": samples.seed,
        "unknown": [each.as_dict() for each in samples.unknown],
    }


def _chosen_as_data(sweep: Sweep, version: int) -> Any:
    """The points that a sweep chose, if it did: as a text that `Chosen` reads, or as a list."""
    if sweep.chosen is None:
        return None
    if sweep.samples is None or version < PACKED:
        return [_short(point) for point in sweep.chosen]
    variants = _variants(len(sweep.samples))
    return Chosen.of(sweep.chosen).packed(variants, sweep.loads, sweep.velocities)


def chosen_of(attributes: Mapping[str, Any]) -> Chosen | None:
    """The points that the last run of a store chose; None if it chose none."""
    chosen = attributes.get("chosen")
    if chosen is None:
        return None
    if not isinstance(chosen, str):
        return Chosen.of(itertools.starmap(Point, chosen))
    variants = _variants(attributes["samples"])
    return Chosen.from_text(chosen, variants, attributes["loads"], attributes["velocities"])


def _variants(samples: int) -> list[Variant]:
    return [(None, number) for number in range(samples)]


def _short(point: Point) -> list[float | None]:
    """A point as a list, without a sample where there are none."""
    return list(point if point.sample is not None else point[:3])


def grown(axes: Mapping[str, list[float]], sweep: Sweep) -> dict[str, list[float]]:
    """Values along each dimension: those of a store, in their order, then what a sweep adds."""
    steps = max(step_count(sweep, load) for load in sweep.loads)

    def widened(name: str, wanted: Iterable[float]) -> list[float]:
        known = axes.get(name, [])
        return [*known, *(new for new in wanted if new not in known)]

    name, values = sweep.axis or (None, ())
    leading = {name: widened(name, values)} if name else {}
    return (
        leading
        | _inputs(sweep, len(leading.get("sample", [])))
        | {
            "load": widened("load", sweep.loads),
            "velocity": widened("velocity", sweep.velocities),
            "step": list(range(1, max(steps, len(axes.get("step", []))) + 1)),
            "quantile": list(QUANTILES),
            "bulk_ratio": list(BULK_RATIOS),
            "x": sweep.grid.coordinates(0).tolist(),
            "y": sweep.grid.coordinates(1).tolist(),
        }
    )


def _inputs(sweep: Sweep, count: int) -> dict[str, list[float]]:
    """Values drawn of each input for so many samples, which may be more than the sweep's."""
    if not (count and sweep.samples and sweep.samples.unknown):
        return {}
    if count == len(sweep.samples):
        return sweep.samples.columns
    values = drawn(sweep.samples.unknown, sweep.samples.seed, count)
    return {each.path: values[:, i].tolist() for i, each in enumerate(sweep.samples.unknown)}

"""Entries of a scene, by their paths in a scene file and in the units of its format."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from pipeline.quantities import UNITS, display
from pipeline.scene.reference import all_keys, number_in
from pipeline.scene.units import typeset
from pipeline.sweep.conditions import FIELDS
from pipeline.sweep.laws import is_given, law_record
from pipeline.sweep.model import Sweep
from tribo import Scene

_PATHS = {
    "pixels.shape": "window.pixels",
    "pixels.spacing": "window.pixel_size",
    "pixels.periodic": "window.periodic",
    "roughness": "disk.roughness",
    "disk": "disk.material",
    **{f"conditions.{name}": path for name, path in FIELDS.items()},
    "conditions.rule": "temperature.criterion",
    "conditions.disk_temperature": "temperature.bulk.disk",
    "conditions.critical_sd": "temperature.critical_sd",
    "conditions.corrections.friction": "friction",
    "conditions.corrections.stem": "pin.stem",
    "conditions.corrections.track.disc": "disk",
    "conditions.corrections.pin_track.disc": "pin",
    "conditions.corrections.track": "disk.track",
    "conditions.corrections.pin_track": "pin.track",
    "conditions.corrections.pin_bulk": "pin",
    "conditions.corrections.disk_bulk": "disk",
    "conditions.corrections.film_resistance": "disk.film",
}
"""Paths in the scene file of fields that a sweep calls otherwise, the more special ones first."""
_NOT_SHOWN = (
    "friction_heat", "unequal_bulks", "loading.stops", "conditions.corrections.course",
    "conditions.corrections.motion", "conditions.corrections.rate", "conditions.rule.law",
    "conditions.corrections.friction.coefficient",
)  # fmt: skip
"""Paths of values that follow from other entries."""


def scene_entries(sweep: Sweep) -> dict[str, str]:
    """Entries of a sweep by their paths in a scene file, those that have a value."""
    entries = {}
    for path, value in _values(sweep):
        if not path.startswith(_NOT_SHOWN):
            entries[_scene_path(path)] = value if path.endswith("periodic") else shown(path, value)
    for unknown in sweep.variants.unknown:
        path, _, distribution = str(unknown).partition(": ")
        entries[f'unknown."{path}"'] = distribution
    return entries


def _values(sweep: Sweep) -> Iterator[tuple[str, Any]]:
    """Values by the paths of fields, in the order of a scene file."""
    about, table, plane = sweep.about, sweep.variants, sweep.plane
    sweep = sweep.variant(next(iter(table.given)))
    for one in fields(Scene):
        part: Any = getattr(sweep.scene, one.name)
        if one.name == "pixels":
            repeated = [axis for axis, repeats in zip("xy", part.periodic, strict=True) if repeats]
            yield "pixels.shape", part.shape
            yield "pixels.spacing", part.spacing
            yield "pixels.periodic", f"along {' and '.join(repeated)}" if repeated else "no"
            continue
        if one.name == "pin" and not is_given(part):
            yield "pin.shape", type(part).__name__
        yield from (pair for pair in _flat(part, one.name) if pair[0] not in table.drawn_fields)
    yield from _flat(sweep.conditions, "conditions")
    yield from _flat(about.caveat, "caveat")
    yield from _flat(about.friction_band, "friction.band")
    yield from _flat(about.model_scatter, "model.scatter")
    yield from _flat(about.oil, "oil")
    yield "sweep.loads", plane.loads
    yield "sweep.velocities", plane.velocities
    yield from _flat(table.axes.get("realization"), "sweep.realizations")
    if table.draw:
        yield "sweep.samples", len(dict(table.axes)["variant"])
        yield "sweep.sample_seed", table.draw.design.seed
    yield from _flat(about.measured, "measured")
    yield from _flat(about.tested, "tested")
    yield from _flat(about.preset, "fidelity.preset")


def _flat(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Values of a part by their paths, without those that are missing; arrays by their hash."""
    if is_given(value):
        law = law_record(value)
        yield f"{path}.law", law.name
        for name, one in law.parameters:
            yield from _flat(one, f"{path}.parameters.{name}")
        yield f"{path}.source_sha256", law.source_sha256
    elif is_dataclass(value):
        for one in fields(value):
            if one.init:
                yield from _flat(getattr(value, one.name), f"{path}.{one.name}")
    elif isinstance(value, tuple) and value and is_dataclass(value[0]):
        for number, one in enumerate(value, 1):
            yield from _flat(one, f"{path}.{number}")
    elif isinstance(value, np.ndarray):
        digest = hashlib.sha256(value.tobytes()).hexdigest()[:8]
        yield path, f"{' × '.join(map(str, value.shape))} numbers, SHA-256 {digest}…"
    elif value is not None and value != () and not (value == 0 and "corrections" in path):
        yield path, value


def _scene_path(path: str) -> str:
    """Path of an entry in a scene file."""
    for name, other in _PATHS.items():
        if path == name or path.startswith(f"{name}."):
            return other + path[len(name) :]
    is_test = path.startswith(("measured.", "tested."))
    return path.replace("normal_load", "load") if is_test else path


def shown(path: str, value: Any) -> str:
    """The value of an entry, in SI, in the unit in which such entries are usually given."""
    key = path.split(".")[-1]
    unit = "" if ".parameters." in path else _units().get(key) or UNITS.get(key, "")
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        items = [shown(path, item).removesuffix(f" {unit}") for item in value]
        return f"{', '.join(items)} {unit}".rstrip()
    if not isinstance(value, int | float):
        return str(value)
    return display(value, unit) if unit else f"{value:g}"


@functools.cache
def _units() -> Mapping[str, str]:
    """Unit of each key of the format, by that of its example."""
    units: dict[str, str] = {}
    for path, entry in all_keys():
        if (number := number_in(entry.kind)) and number.unit:
            units.setdefault(path.rpartition(".")[2], typeset(number.unit))
    return units

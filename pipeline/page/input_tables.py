"""Inputs of a sweep as tables, from the objects that were simulated, not from the scene's text."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from pipeline.quantities import display
from pipeline.sweep.case import Case
from pipeline.sweep.case_table import PLACE_UNITS, Column, Label
from pipeline.sweep.notes import FromLibrary
from pipeline.sweep.sweep import Sweep
from pipeline.sweep.user_laws import UserObject
from pipeline.units import to_si
from tribo import Material, Oil
from tribo.surface import UnknownHeights

_UNITS = {
    "elastic_modulus": "GPa", "thermal_conductivity": "W/(m K)", "density": "kg/m^3",
    "specific_heat": "J/(kg K)", "hardness": "GPa",
    "radius": "mm", "crown_radius": "mm", "length": "mm",
    "ra": "µm", "correlation_length": "µm", "pixel_size": "µm",
    "rate": "N/s", "reference_load": "N", "hold": "s", "loads": "N", "hold_times": "s",
    "times": "s", "specific_wear_rate": "mm³/(N m)", "pin_track_length": "mm",
    "disk_track_length": "mm",
    "viscosities": "mm²/s", "pressure_coefficient": "1/GPa",
    "bulk_temperature": "°C", "critical_temperature": "°C", "added_rise_fraction": "%",
    "critical_area_fraction": "%", "model_bias": "%", "model_scatter": "%",
}  # fmt: skip
"""Unit of each quantity in the table; others are numbers."""
_LIBRARY_NAMES = {
    "viscosities": "kinematic_viscosity",
    "pressure_coefficient": "pressure_viscosity_coefficient",
}
"""Entries of the library, if they have other names than the quantities of the objects."""

Part = Mapping[str, str]
"""Values of a part of the inputs as text, by quantity."""


def input_rows(sweep: Sweep) -> Iterator[list[str]]:
    """Yield rows (part, values, source); each material and the oil have one."""
    base, *cases = (dict(_parts(case)) for case in (sweep.base, *sweep.cases))
    for part, values in base.items():
        texts = [
            f"{quantity.replace('_', ' ')} {_common_text(text, part, quantity, cases)}".strip()
            for quantity, text in values.items()
        ]
        yield [part, "; ".join(texts), _source(part, sweep)]


def case_rows(sweep: Sweep) -> tuple[list[str], list[list[str]]]:
    """Headings and rows of the cases that the user chose; no rows for a single case."""
    table = sweep.case_table.without_surfaces
    headings = [column.name.replace("_", " ") for column in table.columns]
    rows = [
        [_label_text(column, row[column.name]) for column in table.columns] for row in table.rows
    ]
    return headings, rows if headings else []


def _label_text(column: Column, label: Label) -> str:
    """A label of a case with its unit."""
    unit = PLACE_UNITS.get(column.name)
    if unit and not isinstance(label, str):
        return display(float(label), unit, 5)
    return str(column.to_text(label))


def _parts(case: Case) -> Iterator[tuple[str, Part]]:
    """Yield the parts of a case, with their values as text."""
    scene = case.scene
    yield "pin", {"shape": type(scene.pin).__name__.lower(), **_texts(scene.pin, ["material"])}
    yield "material of the pin", _texts(scene.pin.material)
    yield "material of the disk", _texts(scene.disk)
    yield "roughness of the disk", _texts(scene.roughness) if scene.roughness else {"": "none"}
    shape = " × ".join(map(str, scene.pixels.shape))
    yield "window", {"pixels": shape, "pixel size": _text("pixel_size", scene.pixels.spacing)}
    yield "loading", _texts(scene.loading)
    yield "wear", _texts(scene.wear) if scene.wear else {"": "none"}
    if scene.motion:
        yield "motion", _texts(scene.motion)
    if case.lubricant:
        yield "oil", _texts(case.lubricant)
    conditions = {**_texts(case.conditions, ["corrections"])}
    if case.conditions.corrections:
        conditions["corrections"] = case.conditions.corrections.text
    if case.critical_from_tests:
        conditions["critical temperature"] = "from tests"
    yield "conditions", conditions
    errors = "model_bias", "model_scatter"
    yield "model error", {name: _text(name, getattr(case, name)) for name in errors}


def _texts(physics: Any, without: Iterable[str] = ()) -> Part:
    """Values of an object's fields as text; for an object of a user, its own text."""
    if not is_dataclass(physics) or isinstance(physics, UserObject | UnknownHeights):
        return {"": str(physics)}
    return {
        name: _text(name, value)
        for name in (field.name for field in fields(physics))
        if (value := getattr(physics, name)) is not None and name not in (*without, "digest")
    }


def _text(name: str, value: Any) -> str:
    """A value with its unit; up to eight are listed, more are counted."""
    unit = _UNITS.get(name, "")
    if isinstance(value, str | bool):
        return str(value)
    numbers = np.asarray(value)
    if numbers.size > 8:
        return f"{' × '.join(map(str, numbers.shape))} values"
    texts = [display(number, unit, 5).rstrip() for number in numbers.ravel().tolist()]
    return ", ".join(dict.fromkeys(texts))


def _common_text(text: str, part: str, quantity: str, cases: Iterable[Mapping[str, Part]]) -> str:
    """The text of a value, or that it differs between the cases."""
    is_common = all(case.get(part, {}).get(quantity) == text for case in cases)
    return text if is_common else "differs between the cases"


def _source(part: str, sweep: Sweep) -> str:
    """The scene, and the sources of the values that a part has from the library."""
    base = sweep.base
    materials = {"material of the pin": base.scene.pin.material,
                 "material of the disk": base.scene.disk}  # fmt: skip
    if part in materials:
        values = _library_values(materials[part], sweep.sources)
        names = [field.name for field in fields(Material)]
    elif part == "oil":
        values = [value for value in sweep.sources if value.key.startswith("oil.")]
        names = [_LIBRARY_NAMES.get(field.name, field.name) for field in fields(Oil)]
    else:
        return "scene"
    names_by_source = dict[str, list[str]]()
    for value in values:
        names_by_source.setdefault(value.source, []).append(value.key.rpartition(".")[2])
    library_names = {*itertools.chain(*names_by_source.values())}
    if scene_names := [name for name in names if name not in library_names]:
        names_by_source["scene"] = scene_names
    if [*names_by_source] == ["scene"]:
        return "scene"
    return "; ".join(
        f"{', '.join(group).replace('_', ' ')}: {source}"
        for source, group in names_by_source.items()
    )


def _library_values(material: Material, sources: Iterable[FromLibrary]) -> list[FromLibrary]:
    """Values of the material of the library that agrees with `material` in most values."""
    by_material = dict[str, list[FromLibrary]]()
    for value in sources:
        path = value.key.rpartition(".")[0]
        if path.startswith("materials."):
            by_material.setdefault(path, []).append(value)
    matches = [
        values
        for values in by_material.values()
        if all(_has_value(material, value) for value in values)
    ]
    return max(matches, key=len, default=[])


def _has_value(material: Material, value: FromLibrary) -> bool:
    """True if a material has a value of the library."""
    quantity = getattr(material, value.key.rpartition(".")[2], None)
    return quantity is not None and bool(np.isclose(to_si(value.value, value.value), quantity))

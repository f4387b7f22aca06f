"""Entries of the scene that a store holds, as text in usual units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.analysis.transition import ENTRIES
from pipeline.scene.quantities import display
from pipeline.sweep.unknown import Unknown

_ATTRIBUTES = (
    "scene", "conditions", "friction_band", "lubrication", "loads", "velocities", "realizations",
    "samples", "sample_seed", "wear_rates", "measured", "tested", "preset",
)  # fmt: skip
_NOT_SHOWN = (
    "friction_heat",
    "unequal_bulks",
    "lubrication.",
    "sweep.samples.",
    "conditions.corrections.motion",
)
"""Paths of values that follow from other entries."""
_TESTS = ("measured.", "tested.")
_TYPES = tuple(
    f"{name}.type"
    for name in ("material", "disk", "pixels", "loading", "roughness", "wear", "motion", "fidelity")
)
_PATHS = {
    "pin.type": "pin.shape",
    "pixels.shape": "window.pixels",
    "pixels.spacing": "window.pixel_size",
    "pixels.periodic": "window.periodic",
    "roughness": "disk.roughness",
    "disk": "disk.material",
    "lubrication.oil": "oil",
    "friction_band": "friction.band",
    "loads": "sweep.loads",
    "velocities": "sweep.velocities",
    "realizations": "sweep.realizations",
    "samples": "sweep.samples",
    "sample_seed": "sweep.sample_seed",
    "wear_rates": "sweep.wear_rates",
    "preset": "fidelity.preset",
    **{f"conditions.{name}": path for name, path in ENTRIES.items()},
    "conditions.disk_temperature": "temperature.bulk.disk",
    "conditions.corrections.friction": "friction.by_velocity",
    "conditions.corrections.stem": "pin.stem",
    "conditions.corrections.track": "disk.track",
    "conditions.corrections.pin_track": "pin.track",
    "conditions.corrections.pin_bulk": "pin",
    "conditions.corrections.disk_bulk": "disk",
    "conditions.corrections.film_resistance": "disk.film",
}
"""Paths in the scene file of what a store calls otherwise, the more special ones first."""

_UNITS = {
    "mm": ("radius", "length", "width", "crown_radius", "track_length"),
    "µm": ("spacing", "ra", "correlation_length"),
    "GPa": ("elastic_modulus", "hardness"),
    "W/(m K)": ("thermal_conductivity",),
    "kg/m³": ("density",),
    "J/(kg K)": ("specific_heat",),
    "N/s": ("rate",),
    "N": ("reference_load", "loads", "normal_load", "load_scatter"),
    "m/s": ("entrainment_velocity", "velocities", "velocity", "velocity_scatter"),
    "s": ("hold", "settling_time"),
    "mm³/(N m)": ("specific_wear_rate", "wear_rates"),
    "°C": ("bulk_temperature", "disk_temperature", "critical_temperature", "temperatures"),
    "1/GPa": ("pressure_coefficients",),
    "mm²/s": ("viscosities", "thermal_diffusivity"),
    "K/W": ("resistance",),
    "J/K": ("capacity",),
    "W/K": ("loss",),
    "mm² K/W": ("film_resistance",),
    "MJ/(m³ K)": ("heat_capacity",),
}
_UNIT_OF = {name: unit for unit, names in _UNITS.items() for name in names}


def entries_of(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Entries of a store's scene by their paths in a scene file, those that have a value.

    Parameters
    ----------
    attributes : mapping
        Attributes of a sweep as plain data, of `pipeline.analysis.dataset.attributes_of`.

    Examples
    --------
    >>> scene = {"pin": {"type": "Ball", "radius": 0.005}, "pixels": {"spacing": [1e-6, 2e-6]}}
    >>> entries_of({"scene": scene, "conditions": {"critical_temperature": 418.15}})
    {'pin.shape': 'Ball', 'pin.radius': '5 mm', 'window.pixel_size': '1, 2 µm', \
'temperature.critical': '145 °C'}
    """
    entries = {}
    for attribute in _ATTRIBUTES:
        prefix = "" if attribute == "scene" else attribute
        for path, value in _flat(attributes.get(attribute), prefix):
            entry = _in_scene(path)
            if entry.startswith(_NOT_SHOWN) or path.endswith(_TYPES):
                continue
            if path == "pixels.periodic":
                repeated = [axis for axis, repeats in zip("xy", value, strict=True) if repeats]
                entries[entry] = f"along {' and '.join(repeated)}" if repeated else "no"
            elif path.startswith("roughness.") and _is_digest(value):
                continue  # its words stand beside
            else:
                entries[entry] = in_usual_unit(path, value)
    for data in attributes.get("unknown") or []:
        path, _, distribution = str(Unknown.from_dict(data)).partition(": ")
        entries[f'unknown."{path}"'] = distribution
    return entries


def _is_digest(value: Any) -> bool:
    """True of the hash of an array, which says nothing to a reader."""
    return isinstance(value, str) and re.fullmatch(r"(sha256:)?[0-9a-f]{32,64}", value) is not None


def in_usual_unit(path: str, value: Any) -> str:
    """Write the value of an entry, in SI, in the unit in which such entries are usually given.

    Examples
    --------
    >>> in_usual_unit("pin.radius", [0.002, 0.003])
    '2, 3 mm'
    """
    return _text(value, _UNIT_OF.get(path.split(".")[-1], ""))


def _flat(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Values of nested tables by their paths, without those that are missing."""
    if isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        value = {str(number): item for number, item in enumerate(value, 1)}
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _flat(entry, f"{path}.{key}" if path else key)
    elif value is not None and value != []:
        yield path, value


def _in_scene(path: str) -> str:
    """Path of an entry in a scene file."""
    for name, other in _PATHS.items():
        if path == name or path.startswith(f"{name}."):
            return other + path[len(name) :]
    return path.replace("normal_load", "load") if path.startswith(_TESTS) else path


def _text(value: Any, unit: str) -> str:
    """Value with its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        items = [_text(item, unit).removesuffix(f" {unit}") for item in value]
        return f"{', '.join(items)} {unit}".rstrip()
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return display(value, unit) if unit else f"{value:g}"

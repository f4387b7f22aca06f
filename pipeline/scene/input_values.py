"""Inputs of a scene: their values, and their declared uncertainties."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pipeline.faults import Faults
from pipeline.kinds import Quantity, Share
from pipeline.messages import did_you_mean, listed
from pipeline.scene.entries import entry_at
from pipeline.scene.format import SceneFile, number_at
from pipeline.sweep.case import CLOSED_FORM, TEMPERATURES, Uncertainty
from pipeline.units import si_unit
from tribo import InputError

_MATERIAL = "hardness", "elastic_modulus", "thermal_conductivity", "density", "specific_heat"
_SCALE_OF_SCAN = "disk.roughness.height_unit"
_TEMPERATURE = Quantity(
    "5 K", name="a temperature difference", ends=("0.001 K", "200 K")
)  # 5 °C is 278 K
_SHARE = Share(above=0, at_most=1)
_OTHERS = (
    "pin.radius", "pin.length", "pin.crown_radius", "disk.roughness.ra", _SCALE_OF_SCAN,
    "disk.roughness.correlation_length", "disk.roughness.rsm", "wear.specific_wear_rate",
    "loading.rate", "loading.hold", "loading.stages.hold", "motion.slide_roll_ratio",
)  # fmt: skip


class Input(NamedTuple):
    """An input of a scene: its value [SI], of which there may be two, and its units."""

    keys: tuple[str, ...]  # of the tables that hold it, and its own
    value: float | tuple[float, ...]
    si_unit: str
    unit: str  # in which it is printed

    def times(self, factor: float) -> dict[str, Any]:
        """Tables of a scene file with the value multiplied by a factor, and nothing else."""
        values = self.value if isinstance(self.value, tuple) else (self.value,)
        entries = [f"{x * factor!r} {self.si_unit}" if self.si_unit else x * factor for x in values]
        tables: Any = entries if isinstance(self.value, tuple) else entries[0]
        for key in reversed(self.keys):
            tables = {key: tables}
        return dict(tables)

    @property
    def first(self) -> float:
        """The value, or the first of two."""
        return self.value[0] if isinstance(self.value, tuple) else self.value


def inputs_of(tables: SceneFile) -> dict[str, Input]:
    """Inputs of a scene that change its simulation, by path."""
    inputs = dict[str, Input]()
    for name in dict.fromkeys((tables.pin.material, tables.disk.material)):
        for key in _MATERIAL:
            value = getattr((tables.materials or {})[name], key)
            path, kind = f"materials.{name}.{key}", number_at(f"materials.NAME.{key}")
            _add(inputs, path, ("materials", name, key), value, kind)
    for path in _OTHERS:
        _add(inputs, path, (*path.split("."),), entry_at(tables, path), number_at(path))
    return inputs


def _add(inputs: dict[str, Input], path: str, keys: tuple[str, ...], value: Any, kind: Any) -> None:
    """Add the input at a path, unless it is missing, 0 or infinite."""
    first = value[0] if isinstance(value, tuple) else value
    if isinstance(first, float) and 0 < abs(first) < float("inf"):
        si, unit = "", kind.unit
        if path == _SCALE_OF_SCAN:
            si, unit = "m", "um"
        elif isinstance(kind, Quantity):
            si = si_unit(kind.example)
        inputs[path] = Input(keys, value, si, unit)


def uncertainty_of(tables: SceneFile, faults: Faults) -> tuple[Uncertainty, ...]:
    """Standard deviations of the table ``[uncertainty]``."""
    if not tables.uncertainty:
        return ()
    inputs, uncertainties, all_paths = inputs_of(tables), list[Uncertainty](), list[str]()
    names = [*inputs, *CLOSED_FORM]
    for key, deviation in tables.uncertainty.items():
        paths = tuple(path.strip() for path in key.split(","))
        if unknown := [path for path in paths if path not in names]:
            hint = did_you_mean(unknown[0], names) or f"; give {listed(names, 30)}"
            faults.refuse(f"uncertainty.{key}", f"is no input of the scene{hint}")
            continue
        if repeated := [path for path in paths if (*all_paths, *paths).count(path) > 1]:
            problem = f"has {repeated[0]} a second time; give each input once"
            faults.refuse(f"uncertainty.{key}", problem)
            continue
        all_paths += paths
        deviations = set[float]()
        for path in paths:
            try:
                deviations.add(_deviation(path, deviation, inputs))
            except InputError as error:
                faults.refuse(f"uncertainty.{key}", str(error))
        if len(deviations) > 1:
            faults.refuse(f"uncertainty.{key}", "differs between its entries; give a share")
        elif deviations:
            uncertainties.append(Uncertainty(paths, deviations.pop()))
    return tuple(uncertainties)


def _deviation(path: str, typed: Any, inputs: Mapping[str, Input]) -> float:
    """Standard deviation of an input: relative, or in K for a temperature."""
    if path in TEMPERATURES:
        return float(_TEMPERATURE.value(typed))
    unit = inputs[path].si_unit if path in inputs else ""
    is_share = not isinstance(typed, str) or typed.rstrip().endswith(("%", "percent"))
    if is_share or not unit or path == _SCALE_OF_SCAN:
        return float(_SHARE.value(typed))
    deviation = float(Quantity(f"1 {unit}").value(typed)) / inputs[path].first
    return float(_SHARE.value(deviation))

"""Inputs of a scene: their values, and their declared uncertainties."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pipeline.messages import did_you_mean, listed
from pipeline.scene.entries import entry_at
from pipeline.scene.faults import Faults
from pipeline.scene.format import SceneFile, number_at
from pipeline.scene.kinds import Quantity
from pipeline.sweep.case import CLOSED_FORM, TEMPERATURES, Uncertainty
from pipeline.units import UnitError, share_of, si_unit, to_si
from tribo import InputError

_MATERIAL = "hardness", "elastic_modulus", "thermal_conductivity", "density", "specific_heat"
_OTHERS = (
    "pin.radius", "pin.length", "pin.crown_radius", "disk.roughness.ra",
    "disk.roughness.correlation_length", "wear.specific_wear_rate", "loading.rate", "loading.hold",
)  # fmt: skip


class Input(NamedTuple):
    """An input of a scene: its value [SI], of which there may be two, and the unit to print it."""

    value: float | tuple[float, ...]
    si_unit: str
    unit: str

    def times(self, factor: float) -> Any:
        """Entry of a scene file with the value multiplied by a factor."""
        if isinstance(self.value, tuple):
            return [f"{value * factor!r} {self.si_unit}" for value in self.value]
        return f"{self.value * factor!r} {self.si_unit}"

    @property
    def first(self) -> float:
        """The value, or the first of two."""
        return self.value[0] if isinstance(self.value, tuple) else self.value


def inputs_of(tables: SceneFile) -> dict[str, Input]:
    """Inputs of a scene that change its simulation, by path."""
    materials = dict.fromkeys((tables.pin.material, tables.disk.material))
    paths = [f"materials.{name}.{key}" for name in materials for key in _MATERIAL]
    inputs = dict[str, Input]()
    for path in (*paths, *_OTHERS):
        value, kind = entry_at(tables, path), number_at(path)
        first = value[0] if isinstance(value, tuple) else value
        if isinstance(kind, Quantity) and first and 0 < first < float("inf"):
            inputs[path] = Input(value, si_unit(kind.example), kind.unit)
    return inputs


def uncertainty_of(tables: SceneFile, faults: Faults) -> tuple[Uncertainty, ...]:
    """Standard deviations of the table ``[uncertainty]``."""
    inputs, uncertainties = inputs_of(tables), list[Uncertainty]()
    names = [*inputs, *CLOSED_FORM]
    for key, deviation in (tables.uncertainty or {}).items():
        paths = tuple(path.strip() for path in key.split(","))
        if unknown := [path for path in paths if path not in names]:
            hint = did_you_mean(unknown[0], names) or f"; give {listed(names, 30)}"
            faults.refuse(f"uncertainty.{key}", f"is no input of the scene{hint}")
            continue
        deviations = set[float]()
        for path in paths:
            try:
                deviations.add(_deviation(path, deviation, inputs, tables))
            except (InputError, UnitError) as error:
                faults.refuse(f"uncertainty.{key}", str(error))
        if len(deviations) > 1:
            faults.refuse(f"uncertainty.{key}", "differs between its entries; give a share")
        elif deviations:
            uncertainties.append(Uncertainty(paths, deviations.pop()))
    return tuple(uncertainties)


def _deviation(path: str, text: Any, inputs: Mapping[str, Input], tables: SceneFile) -> float:
    """Standard deviation of an input: relative, or in K for a temperature."""
    if path in TEMPERATURES:
        return _positive(to_si(text, like="1 K"), text)
    if not isinstance(text, str) or text.rstrip().endswith(("%", "percent")):
        return _positive(share_of(text), text)
    kind, value = number_at(path), entry_at(tables, path)
    if path in inputs:
        value = inputs[path].first
    if not isinstance(kind, Quantity):
        return _positive(float(text) / value, text)
    return _positive(to_si(text, like=kind.example) / value, text)


def _positive(deviation: float, text: Any) -> float:
    if not deviation > 0:
        raise InputError(f'{text!r} is not above 0; give a deviation such as "10 %" or "5 K"')
    return deviation

"""The table ``[fidelity]`` of a scene: its format, and the numerical choices that it makes."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Annotated as A
from typing import Any, get_type_hints

import tribo
from pipeline.scene.declare import Declared, StoreOnly, table_of
from pipeline.scene.faults import Faults
from pipeline.scene.kinds import OneOf

USUAL_PRESET = "standard"
# fmt: off
_CHOICES = {
    "pixels_per_element":
        "Pixels of the surface along each side of an element; the largest number allowed if "
        "`fewest_elements` is above 0.",
    "increments": "Steps of the ramp up to its reference load.",
    "fewest_elements":
        "Least number of elements that touch: elements are made small enough for this and for the "
        "summits of the surface. With 0 they have the size given, and their mean height.",
    "contact_tolerance": "Residual of the contact at which its solver stops.",
    "heat_model":
        '"elapsed": the present friction heat is taken to have acted since time 0 (Bosman & de '
        'Rooij); "history": all heat since then acts at its own time, linear between the steps.',
}


class _Preset(OneOf):
    def read(self, value: object, place: str, faults: Faults, allowed: object = None) -> Any:
        return super().read(value, place, faults, f"{self}, or irg run --accuracy 5%")

class _FidelityTable(Declared):
    preset: A[str, _Preset(tuple(tribo.PRESETS)),
        'Preset, from "standard", the fastest, to "reference", the most accurate.'] = USUAL_PRESET

_HINTS = get_type_hints(tribo.Fidelity)
FidelityTable: Any = type("FidelityTable", (_FidelityTable,), {
    "__annotations__": {
        name: A[hint | None, _CHOICES.get(name, StoreOnly())] for name, hint in _HINTS.items()},
    **dict.fromkeys(_HINTS),
})
# fmt: on


def complete_fidelity(preset: str | None, made: tribo.Fidelity) -> Any:
    """Table ``[fidelity]`` with the name of a preset, the numbers of `made` and its own choices."""
    usual, keys = asdict(tribo.Fidelity()), table_of(FidelityTable).listed
    choices = {
        key: value for key, value in asdict(made).items() if key in keys or value != usual[key]
    }
    return FidelityTable(preset=preset, **choices)


def fidelity_of(table: Any, faults: Faults) -> tuple[tribo.Fidelity, str | None]:
    """Numerical choices of the table ``[fidelity]``, and the preset with them, or None."""
    name = (table and table.preset) or USUAL_PRESET
    fidelity = tribo.PRESETS[name]
    listed = (vars(table) if table else {}).items()
    given = {key: value for key, value in listed if key != "preset" and value is not None}
    for key, value in given.items():
        with faults.at(f"fidelity.{key}"):
            fidelity = replace(fidelity, **{key: value})
    if faults.is_complete:  # whatever the preset is today
        return fidelity, table and table.preset
    return fidelity, name if fidelity == tribo.PRESETS[name] else None

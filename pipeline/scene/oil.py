"""The lubricant of a scene."""

from __future__ import annotations

from typing import Any

import tribo
from pipeline.scene.faults import Fault

_NOMINAL = 1000.0  # kg/m³: makes of a viscosity in mPa s as much in mm²/s


def oil_of(tables: dict[str, Any], faults: list[Fault]) -> tribo.Oil | None:
    """Make the oil; None if there is none, or a faulty one.

    Where the dynamic viscosity is given, the equation between its two temperatures is applied to
    its value in mPa s, as ASTM D341 does it to the kinematic one in mm²/s; it needs no density
    then.
    """
    table = tables["oil"]
    if table is None or any(fault.key.split(".")[0] == "oil" for fault in faults):
        return None
    kinematic, dynamic = table["kinematic_viscosity"], table["dynamic_viscosity"]
    if (kinematic is None) == (dynamic is None):
        which = "both are given" if kinematic else "neither is given"
        problem = f"{which}; give kinematic_viscosity with a density, or dynamic_viscosity"
        faults.append(Fault("oil", f"kinematic_viscosity, dynamic_viscosity: {problem}"))
        return None
    if kinematic and table["density"] is None:
        faults.append(Fault("oil.density", "missing; a kinematic viscosity needs one"))
        return None
    coefficient = table["pressure_viscosity_coefficient"]
    pair = coefficient if isinstance(coefficient, tuple) else (coefficient, coefficient)
    density = table["density"] if kinematic else _NOMINAL
    try:
        return tribo.Oil(
            table["temperatures"],
            kinematic or tuple(value / _NOMINAL for value in dynamic),
            density,
            None if coefficient is None else pair,
        )
    except tribo.InputError as error:
        faults.append(Fault("oil", str(error)))
        return None

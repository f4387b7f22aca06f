"""The conditions that a sweep is judged by: its own, and those that are given in their place."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.scene.faults import quoted
from pipeline.scene.quantities import in_si, share_of
from pipeline.sweep.conditions import Conditions, changes_of
from pipeline.sweep.criterion import require_bulks
from pipeline.sweep.own_laws import OwnLawError
from tribo import InputError

Bulk = float | str | Mapping[str, float | str]
"""A bulk temperature [K] or with a unit; or one for each body, by ``"pin"`` and ``"disk"``."""

CONDITIONS = (
    "friction", "bulk_temperature", "critical_temperature", "share", "criterion", "own_laws",
)  # fmt: skip
"""Names of the conditions that may be given in place of the sweep's own, and the permission."""

_STORED = {entry.name for entry in fields(Conditions)} - {"own_criterion"}
_COLDEST_OIL, _HOTTEST_OIL = 220.0, 900.0  # bulk temperatures [K]


def conditions_of(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
) -> Conditions:
    """Take the sweep's own conditions, and those that are given in their place.

    Raises
    ------
    InputError
        If one lies outside its range, or is neither given nor in the sweep; an `OwnLawError` if
        the criterion is code, and that is not given and allowed.
    """
    bulk: Any = bulk_temperature
    stored = attributes_of(ds).get("conditions") or {}
    values = {name: value for name, value in stored.items() if name in _STORED} | changes_of(
        friction,
        {body: _kelvin("bulk_temperature", one) for body, one in bulk.items()}
        if isinstance(bulk, Mapping)
        else _kelvin("bulk_temperature", bulk),
        _kelvin("critical_temperature", critical_temperature),
        None if share is None else share_of(share),
        criterion,
        own_laws,
    )
    named = str(values.get("criterion", ""))
    if ":" in named and "own_criterion" not in values:
        raise OwnLawError(
            f"the store was judged by the criterion {quoted(named)} (SHA-256 "
            f"{stored.get('criterion_hash')}), which is code, and nothing that a store names is "
            f"run; give --criterion={quoted(named)} --own-laws in the folder of its file, or "
            "another, such as --criterion=share"
        )
    for name in ("friction", "failing_share", "bulk_temperature"):
        if values.get(name) is None:
            raise InputError(f"the sweep has no {name} of its own; give one")
    conditions = Conditions(**values)
    require_bulks(ds, conditions)
    if conditions.friction and not attributes_of(ds).get("scene", {}).get("friction_heat", True):
        raise InputError(
            f"friction is {conditions.friction:g}; the sweep was computed without friction, and "
            "so without any heat: run it again with friction, into another store"
        )
    return conditions


def _kelvin(name: str, value: float | str | None) -> float | None:
    """Read a temperature [K], and refuse one at which no oil works."""
    if isinstance(value, str):
        value = in_si(name, value, "80 degC")
    if value is None or isinstance(value, Iterable):
        return value  # several are refused with the other conditions
    hottest = _HOTTEST_OIL if name == "bulk_temperature" else np.inf
    if value < _COLDEST_OIL or hottest < value < np.inf:
        raise InputError(
            f"{name} is {value - 273.15:.4g} °C ({value:g} K), at which no oil works; give one "
            f"from {_COLDEST_OIL - 273.15:.4g} °C on; in Python a plain number is in kelvins, and "
            'text has its unit, such as "80 degC"'
        )
    return value


def attributes_by(conditions: Conditions) -> dict[str, Any]:
    """Conditions as attributes of types that netCDF can store; corrections as JSON."""
    plain = conditions.as_dict()
    if "corrections" in plain:
        plain["corrections"] = json.dumps(plain["corrections"])
    return plain

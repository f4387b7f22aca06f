"""The conditions of a scene: their entries, their changes, and their values as plain data."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pipeline.sweep.case_table import dimension_of
from tribo import Conditions as Conditions
from tribo import InputError
from tribo.simulation import verdict

OIL_WORKS = "-53 degC", "627 degC"
"""Bulk temperatures between which an oil may work."""
PATHS = {
    "friction": "friction.coefficient",
    "bulk_temperature": "temperature.bulk",
    "critical_temperature": "temperature.critical",
    "critical_area_fraction": "temperature.critical_area_fraction",
    "added_rise_fraction": "model.rise",
}
"""Entries of the scene file that act after the simulation, by the conditions' names."""
DIMENSIONS = {dimension_of(path): path for path in PATHS.values()}
"""Those entries by the name of the dimension that several values make."""
CONDITION_ENTRIES = {name: path for name, path in PATHS.items() if name != "added_rise_fraction"}
"""Conditions that rows of tables may set, and their entries in a scene."""
UNITS = {
    "friction": "1", "bulk_temperature": "K", "critical_temperature": "K",
    "critical_area_fraction": "1", "added_rise_fraction": "1",
}  # fmt: skip
"""Units of those of `plain_values` that are numbers."""
OF_TESTS = "friction", "bulk_temperature", "corrections"
"""Conditions that each test has of its own; all others are the oil's."""


def plain_values(conditions: Conditions) -> dict[str, Any]:
    """Values of conditions by name, as plain data.

    Corrections that are None are left out.
    """
    corrections = conditions.corrections
    values = {
        "friction": conditions.friction,
        "bulk_temperature": conditions.bulk_temperature,
        "critical_temperature": conditions.critical_temperature,
        "added_rise_fraction": conditions.added_rise_fraction,
        "corrections": corrections and corrections.as_dict(),
        "critical_area_fraction": conditions.critical_area_fraction,
    }
    return {k: v for k, v in values.items() if v is not None or k != "corrections"}


def known_critical_temperature(conditions: Conditions) -> float:
    """Critical temperature [K]; raises an `InputError` if it is not known."""
    if conditions.critical_temperature is None:
        raise InputError(
            "temperature.critical is missing, and this needs it; add one to the scene, such as "
            'critical = "145 degC", or give --critical-temperature (in Python '
            "critical_temperature) where it is taken"
        )
    return conditions.critical_temperature


def allowable_rise(conditions: Conditions) -> float:
    """Temperature rise per unit friction coefficient above which wear is severe [K].

    It is infinite if the friction coefficient is 0. Raises an `InputError` if the critical
    temperature is not known.
    """
    known_critical_temperature(conditions)
    return verdict.allowable_rise(conditions)


def with_own(conditions: Conditions, own: Conditions) -> Conditions:
    """The `conditions` with what each test has of its own taken from `own`."""
    return replace(conditions, **{name: getattr(own, name) for name in OF_TESTS})

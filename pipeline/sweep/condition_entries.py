"""The conditions of a scene: their entries, and limits that follow from them."""

from __future__ import annotations

from dataclasses import replace

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
CONDITION_ENTRIES = {name: path for name, path in PATHS.items() if name != "added_rise_fraction"}
"""Conditions that rows of tables may set, and their entries in a scene."""
OF_TESTS = "friction", "bulk_temperature", "corrections"
"""Conditions that each test sets; all others are those of the oil."""


def known_critical_temperature(conditions: Conditions) -> float:
    """Critical temperature [K]; raises an `InputError` if it is not known."""
    if conditions.critical_temperature is None:
        raise InputError(
            "a critical temperature is needed; add one to the scene, such as critical = "
            '"145 degC" under [temperature], or use --critical-temperature '
            "(critical_temperature in Python)"
        )
    return conditions.critical_temperature


def allowable_rise(conditions: Conditions) -> float:
    """Temperature rise per unit friction coefficient above which wear is severe [K].

    It is infinite if the friction coefficient is 0. Raises an `InputError` if the critical
    temperature is not known.
    """
    known_critical_temperature(conditions)
    return verdict.allowable_rise(conditions)


def with_test_conditions(conditions: Conditions, test_conditions: Conditions) -> Conditions:
    """The `conditions` with those named in `OF_TESTS` taken from `test_conditions`."""
    return replace(conditions, **{name: getattr(test_conditions, name) for name in OF_TESTS})

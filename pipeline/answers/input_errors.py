"""Sensitivities of ln(rise ratio) to the inputs of a scene, and its error by their uncertainties.

With y = ln(rise/allowable rise), the sensitivity to an input p is s = dy/d ln(p), from variants of
the scene on both sides, or on one side and the point itself; friction and temperatures act in
closed form, the latter by dy/dT. For independent uncertainties, sd(y)² = Σ (s σ)². Inputs with one
uncertainty in common add before they are squared.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from pipeline.answers.case_results import CaseResults
from pipeline.store.schema import PENDING
from pipeline.sweep.case import (
    CLOSED_FORM,
    INPUT_STEP,
    VELOCITY_INPUT,
    Conditions,
    Uncertainty,
)
from tribo.types import Array

STEP = math.log(INPUT_STEP)
"""Change of ln(input) on either side."""


def sensitivity_dataset(case: CaseResults, conditions: Conditions) -> xr.Dataset:
    """Sensitivities of a case along (input, point), from the variants of its scene.

    ``sensitivity`` is dy/d ln(input), or dy/dT [1/K] of a temperature; ``curvature`` is the sum of
    the changes of y on both sides, NaN in closed form or if one side has no result; ``sides`` has
    the factors of the input that were simulated. ``velocity_exponent`` is that of the rise.
    """
    logs, values = dict[tuple[str, float, float, float], float](), dict[str, tuple[float, str]]()
    for variant, point in case.variants:
        changed = replace(conditions, corrections=variant.case.conditions.corrections)
        rise = math.nan if point.missing_reason else point.rise(changed)
        key = variant.entry, variant.load, variant.velocity, variant.factor
        if rise > 0 or point.status == PENDING:
            logs[key] = math.log(rise) if rise > 0 else math.nan
        values[variant.entry] = variant.value, variant.unit
    points = [*dict.fromkeys((v.load, v.velocity) for v, _ in case.variants)]
    names = [name for name in values if name != VELOCITY_INPUT]

    def changes(entries: list[str], factor: float) -> Array:
        """Change of y (entry, point), infinite where the factor was refused or failed."""
        rows = [
            [
                logs.get((entry, *point, factor), math.inf)
                - logs.get((VELOCITY_INPUT, *point, 1.0), math.nan)
                for point in points
            ]
            for entry in entries
        ]
        return np.array(rows).reshape(len(entries), len(points))

    def slopes(entries: list[str]) -> tuple[Array, Array]:
        up, down = (changes(entries, factor) for factor in (INPUT_STEP, 1 / INPUT_STEP))
        is_up, is_down = ~np.isinf(up), ~np.isinf(down)
        with np.errstate(invalid="ignore"):
            both, curvature = (up - down) / (2 * STEP), up + down
        slope = np.select(
            (is_up & is_down, is_up, is_down), (both, up / STEP, -down / STEP), np.nan
        )
        return slope, np.where(is_up & is_down, curvature, np.nan)

    closed = closed_sensitivities(conditions)
    shape = len(closed), len(points)
    closed_rows = np.broadcast_to([[slope] for slope in closed.values()], shape)
    sensitivity, curvature = slopes(names)
    sides = [
        " and ".join(
            text
            for factor, text in ((INPUT_STEP, "+"), (1 / INPUT_STEP, "−"))
            if all((name, *point, factor) in logs for point in points)
        )
        for name in names
    ]
    values |= _closed_values(conditions)
    rows = [*names, *closed]
    return xr.Dataset(
        {
            "sensitivity": (("input", "point"), np.concatenate([sensitivity, closed_rows])),
            "curvature": (("input", "point"), np.concatenate([curvature, closed_rows * np.nan])),
            "velocity_exponent": ("point", slopes([VELOCITY_INPUT])[0][0]),
        },
        {
            "input": rows,
            "load": ("point", [load for load, _ in points]),
            "velocity": ("point", [velocity for _, velocity in points]),
            "value": ("input", [values[name][0] for name in rows]),
            "unit": ("input", [values[name][1] for name in rows]),
            "sides": ("input", [*sides, *("+ and −" for _ in closed)]),
        },
    )


def closed_sensitivities(conditions: Conditions) -> dict[str, float]:
    """Sensitivities of y to friction, and to temperatures [1/K], by path."""
    critical, bulk = conditions.critical_temperature, conditions.bulk_temperature
    if critical is None:
        return {CLOSED_FORM[0]: 1.0}
    margin = critical - bulk
    return dict(zip(CLOSED_FORM, (1.0, 1 / margin, -1 / margin), strict=True))


def _closed_values(conditions: Conditions) -> dict[str, tuple[float, str]]:
    values = conditions.friction, conditions.bulk_temperature, conditions.critical_temperature
    pairs = (
        (value or math.nan, unit) for value, unit in zip(values, ("", "°C", "°C"), strict=True)
    )
    return dict(zip(CLOSED_FORM, pairs, strict=True))


@dataclass(frozen=True, eq=False)
class InputErrors:
    """Standard deviations of y by the uncertain inputs of a case, at the point of the largest."""

    uncertainties: tuple[Uncertainty, ...]
    parts: Array  # by uncertainty

    @functools.cached_property
    def deviation(self) -> float:
        """Standard deviation of y by all of them."""
        return float(np.sqrt(np.square(self.parts).sum()))

    @property
    def without_largest(self) -> InputErrors:
        """The errors once the input that contributes most is known."""
        parts = np.where(np.arange(len(self.parts)) == np.argmax(self.parts), 0.0, self.parts)
        return replace(self, parts=parts)

    @property
    def largest(self) -> tuple[str, float]:
        """Name of the input that contributes most, and its part of the deviation."""
        first = int(np.argmax(self.parts))
        return uncertainty_name(self.uncertainties[first]), float(self.parts[first])


def input_errors(case: CaseResults, conditions: Conditions) -> InputErrors | None:
    """Errors by uncertain inputs; None without any, or while their variants are not simulated."""
    uncertainties = case.sweep.base.uncertainty
    if not uncertainties:
        return None
    # The same for all answers under one oil, whatever bulk temperature they are asked for.
    own = case.conditions
    conditions = replace(conditions, friction=own.friction, bulk_temperature=own.bulk_temperature)
    closed = closed_sensitivities(conditions)
    sensitivities = {path: np.full(1, slope) for path, slope in closed.items()}
    if case.variants:
        table = sensitivity_dataset(case, conditions)
        rows = zip(table["input"].values.tolist(), table["sensitivity"].values, strict=True)
        sensitivities = dict(rows)
    if not {path for each in uncertainties for path in each.entries} <= sensitivities.keys():
        return None
    parts = np.array([
        np.abs(sum(sensitivities[path] for path in each.entries)) * each.deviation
        for each in uncertainties
    ])  # fmt: skip
    if not np.isfinite(parts).all():
        return None
    return InputErrors(uncertainties, parts[:, np.argmax(np.square(parts).sum(axis=0))])


def uncertainty_name(uncertainty: Uncertainty) -> str:
    """Name of the inputs of an uncertainty, such as "Ra with correlation length"."""
    return " with ".join(map(input_name, uncertainty.entries))


def input_name(path: str) -> str:
    """Name of an input for people, such as "thermal conductivity of steel"."""
    table, _, name = path.rpartition(".")
    words = name.replace("_", " ")
    if table.startswith("materials."):
        return f"{words} of {table.removeprefix('materials.')}"
    special = {"pin": f"pin {words}", "friction": "friction"}
    special |= {"oil": "viscosity of the oil"}
    special |= {"loading": f"loading {words}" if name == "rate" else words}
    special |= {"loading.stages": "hold of the stages", "motion": "slide–roll ratio"}
    special |= {"temperature": f"{words} temperature"}
    special |= {
        "disk.roughness": {
            "ra": "Ra",
            "rsm": "RSm",
            "height_unit": "height scale of the scan",
        }.get(name, words)
    }
    return special.get(table, words)

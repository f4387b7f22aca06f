"""Sensitivities of ln(rise ratio) to the inputs of a scene, and its error by their uncertainties.

With y = ln(rise/allowable rise), the sensitivity to an input p is s = dy/d ln(p), from variants of
the scene on both sides, or on one side and the point itself; friction and temperatures act in
closed form, the latter by dy/dT. For independent uncertainties, sd(y)² = Σ (s σ)². Inputs with one
uncertainty in common add before they are squared.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from pipeline.answers.case_results import CaseResults, TestPoint
from pipeline.store.schema import PENDING
from pipeline.sweep.case import (
    CLOSED_FORM,
    INPUT_STEP,
    VELOCITY_INPUT,
    Conditions,
    OperatingPoint,
    Uncertainty,
    Variant,
)
from tribo.types import Array

STEP = math.log(INPUT_STEP)
"""Change of ln(input) on either side."""
FACTORS = INPUT_STEP, 1 / INPUT_STEP
_NAMES = {
    "pin": "pin {}", "friction": "friction", "oil": "viscosity of the oil",
    "loading.rate": "loading rate", "loading.stages": "hold of the stages",
    "motion": "slide–roll ratio", "temperature": "{} temperature", "disk.roughness.ra": "Ra",
    "disk.roughness.rsm": "RSm", "disk.roughness.height_unit": "height scale of the scan",
}  # fmt: skip
"""Names of inputs for people, by path or by table, whose entries are in place of the braces."""
Variants = Sequence[tuple[Variant, TestPoint]]
"""Variants of a case, each with its point."""
_LogRises = dict[tuple[str, OperatingPoint, float], float]


def sensitivity_dataset(variants: Variants, conditions: Conditions) -> xr.Dataset:
    """Sensitivities of a case along (input, point), from the points of its variants.

    ``sensitivity`` is dy/d ln(input), or dy/dT [1/K] of a temperature; ``curvature`` is the sum of
    the changes of y on both sides, NaN in closed form or if one side has no result; ``sides`` has
    the signs of the changes that have a result. ``velocity_exponent`` is that of the rise.
    """
    logs, points = _log_rises(variants, conditions), [*dict.fromkeys(v.point for v, _ in variants)]
    values = {variant.entry: (variant.value, variant.unit) for variant, _ in variants}
    names, closed = [name for name in values if name != VELOCITY_INPUT], _closed(conditions)
    sensitivity, curvature = _slopes(logs, names, points)
    slopes = np.broadcast_to([[slope] for slope, *_ in closed.values()], (len(closed), len(points)))
    values |= {path: (value, unit) for path, (_, value, unit) in closed.items()}
    rows = [*names, *closed]
    return xr.Dataset(
        {
            "sensitivity": (("input", "point"), np.concatenate([sensitivity, slopes])),
            "curvature": (("input", "point"), np.concatenate([curvature, slopes * np.nan])),
            "velocity_exponent": ("point", _slopes(logs, [VELOCITY_INPUT], points)[0][0]),
        },
        {
            "input": rows,
            "load": ("point", [load for load, _ in points]),
            "velocity": ("point", [velocity for _, velocity in points]),
            "value": ("input", [values[name][0] for name in rows]),
            "unit": ("input", [values[name][1] for name in rows]),
            "sides": ("input", [*_sides(logs, names, points), *["+ and −"] * len(closed)]),
        },
    )


def _log_rises(variants: Variants, conditions: Conditions) -> _LogRises:
    """ln(rise) by input, point and factor; NaN if it is pending, missing if it has failed."""
    logs = _LogRises()
    for variant, point in variants:
        changed = replace(conditions, corrections=variant.case.conditions.corrections)
        rise = math.nan if point.missing_reason else point.rise(changed)
        if rise > 0 or point.status == PENDING:
            log_rise = math.log(rise) if rise > 0 else math.nan
            logs[variant.entry, variant.point, variant.factor] = log_rise
    return logs


def _slopes(
    logs: _LogRises, entries: Sequence[str], points: Sequence[OperatingPoint]
) -> tuple[Array, Array]:
    """Sensitivities and curvatures (entry, point), by one side where the other has no result."""
    base = np.array([logs.get((VELOCITY_INPUT, point, 1.0), math.nan) for point in points])
    up, down = (
        np.array([[logs.get((e, p, factor), math.inf) for p in points] for e in entries])
        for factor in FACTORS
    )
    shape = len(entries), len(points)
    up, down = up.reshape(shape) - base, down.reshape(shape) - base
    is_up, is_down = ~np.isinf(up), ~np.isinf(down)
    with np.errstate(invalid="ignore"):
        both, curvature = (up - down) / (2 * STEP), up + down
    slopes = np.select((is_up & is_down, is_up, is_down), (both, up / STEP, -down / STEP), np.nan)
    return slopes, np.where(is_up & is_down, curvature, np.nan)


def _sides(
    logs: _LogRises, names: Iterable[str], points: Sequence[OperatingPoint]
) -> Iterator[str]:
    """Yield the signs of the changes of each input that have a result, such as "+ and −"."""
    for name in names:
        has_result = [all((name, point, factor) in logs for point in points) for factor in FACTORS]
        yield " and ".join(itertools.compress("+−", has_result))


def _closed(conditions: Conditions) -> dict[str, tuple[float, float, str]]:
    """Sensitivity, value and unit of friction and temperatures, by path."""
    slopes, c = closed_sensitivities(conditions), conditions
    values = c.friction, c.bulk_temperature, c.critical_temperature
    columns = zip(CLOSED_FORM, values, ("", "°C", "°C"), strict=True)
    return {path: (slopes[path], v, unit) for path, v, unit in columns if v and path in slopes}


def closed_sensitivities(conditions: Conditions) -> dict[str, float]:
    """Sensitivities of y to friction, and to temperatures [1/K], by path."""
    critical, bulk = conditions.critical_temperature, conditions.bulk_temperature
    if critical is None:
        return {CLOSED_FORM[0]: 1.0}
    margin = critical - bulk
    return dict(zip(CLOSED_FORM, (1.0, 1 / margin, -1 / margin), strict=True))


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
        """Name of the input that contributes most, and its part of the deviation.

        It is such as "Ra with correlation length" if inputs have their uncertainty in common.
        """
        first = int(np.argmax(self.parts))
        name = " with ".join(map(input_name, self.uncertainties[first].entries))
        return name, float(self.parts[first])


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
        table = sensitivity_dataset(case.variants, conditions)
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


def input_name(path: str) -> str:
    """Name of an input for people, such as "thermal conductivity of steel"."""
    table, _, name = path.rpartition(".")
    words = name.replace("_", " ")
    if table.startswith("materials."):
        return f"{words} of {table.removeprefix('materials.')}"
    return _NAMES.get(path) or _NAMES.get(table, "{}").format(words)

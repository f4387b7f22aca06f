"""Sensitivities of ln(rise ratio) to the inputs of a scene, and its error by their uncertainties.

With y = ln(rise/allowable rise), the sensitivity to an input p is s = dy/d ln(p), from a variant of
the scene on either side; friction and temperatures act in closed form, the latter by dy/dT. For
independent uncertainties, sd(y)² = Σ (s σ)². Inputs with one uncertainty in common add before they
are squared.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from pipeline.answers.case_results import CaseResults
from pipeline.sweep.case import (
    CLOSED_FORM,
    INPUT_STEP,
    TEMPERATURES,
    VELOCITY_INPUT,
    Conditions,
    Uncertainty,
)
from tribo.types import Array

TEMPERATURE_STEP = 10.0
"""Change of a temperature that answers print [K]."""
_STEP = math.log(INPUT_STEP)


def sensitivity_dataset(case: CaseResults, conditions: Conditions) -> xr.Dataset:
    """Sensitivities of a case to its inputs along (input, load), from the variants of its scene.

    ``sensitivity`` is dy/d ln(input), or dy/dT [1/K] of a temperature; ``curvature`` the sum of the
    changes of y on both sides; NaN in closed form. ``velocity_exponent`` is that of the rise.
    """
    variants, rises = case.sweep.variants, dict[tuple[str, float, float], float]()
    velocities = {variant.load: variant.velocity for variant in variants}
    for variant, points in zip(variants, case.variants, strict=True):
        changed = replace(conditions, corrections=variant.case.conditions.corrections)
        rise = math.nan if points[0].missing_reason else points[0].rise(changed)
        rises[variant.entry, variant.load, variant.factor] = (
            math.log(rise) if rise > 0 else math.nan
        )
    loads, names = sorted(velocities), [*dict.fromkeys(variant.entry for variant in variants)]
    y = np.array([
        [[rises.get((name, load, factor), math.nan) for load in loads] for name in names]
        for factor in (INPUT_STEP, 1 / INPUT_STEP)
    ])  # fmt: skip
    sensitivity = (y[0] - y[1]) / (2 * _STEP)
    closed = closed_sensitivities(conditions)
    values = {variant.entry: (variant.value, variant.unit) for variant in variants}
    values |= _closed_values(conditions)
    rows = [*names, *closed]
    both = np.concatenate([
        sensitivity, np.broadcast_to([[s] for s in closed.values()], (len(closed), len(loads)))
    ])  # fmt: skip
    return xr.Dataset(
        {
            "sensitivity": (("input", "load"), both),
            "velocity_exponent": ("load", sensitivity[names.index(VELOCITY_INPUT)]),
        },
        {
            "input": rows,
            "load": loads,
            "velocity": ("load", [velocities[load] for load in loads]),
            "value": ("input", [values[name][0] for name in rows]),
            "unit": ("input", [values[name][1] for name in rows]),
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


def change_of_step(ds: xr.Dataset) -> xr.DataArray:
    """Change of y for +10 % of each input, or +10 K of a temperature."""
    steps = [TEMPERATURE_STEP if path in TEMPERATURES else _STEP for path in ds["input"].values]
    changes: xr.DataArray = ds["sensitivity"] * xr.DataArray(steps, dims="input")
    return changes


@dataclass(frozen=True, eq=False)
class InputErrors:
    """Standard deviations of y by the uncertain inputs of a case, at some loads."""

    loads: Array  # ascending (n,) [N]
    parts: Array  # by uncertainty (m, n)
    uncertainties: tuple[Uncertainty, ...]

    def deviation(self, loads: Array) -> Array:
        """Standard deviation (k,) of y at loads [N], interpolated in ln(load)."""
        total = np.sqrt(np.square(self.parts).sum(axis=0))
        return np.asarray(np.interp(np.log(loads), np.log(self.loads), total))

    @property
    def text(self) -> str:
        """The deviation as text, with the input that contributes most at the middle load."""
        total = 100 * np.sqrt(np.square(self.parts).sum(axis=0))
        ends = dict.fromkeys(f"{end:.2g}" for end in (total.min(), total.max()))
        middle = 100 * self.parts[:, len(self.loads) // 2]
        first = int(np.argmax(middle))
        names = " with ".join(input_name(path) for path in self.uncertainties[first].entries)
        return (
            f"uncertain inputs ± {' to '.join(ends)} % of the rise, most by {names} "
            f"(± {middle[first]:.2g} %)"
        )


def input_errors(case: CaseResults, conditions: Conditions) -> InputErrors | None:
    """Errors by uncertain inputs; None without any, or while their variants are not simulated."""
    uncertainties = case.sweep.base.uncertainty
    if not uncertainties:
        return None
    # The same for all answers under one oil, whatever bulk temperature they ask for.
    own = case.conditions
    conditions = replace(conditions, friction=own.friction, bulk_temperature=own.bulk_temperature)
    if case.sweep.variants:
        table = sensitivity_dataset(case, conditions)
        loads = table["load"].values
        sensitivities = dict(zip(table["input"].values, table["sensitivity"].values, strict=True))
    else:
        loads, closed = case.loads[:1], closed_sensitivities(conditions)
        sensitivities = {path: np.full(1, value) for path, value in closed.items()}
    if not {path for each in uncertainties for path in each.entries} <= sensitivities.keys():
        return None
    parts = np.array([
        np.abs(sum(sensitivities[path] for path in each.entries)) * each.deviation
        for each in uncertainties
    ])  # fmt: skip
    return InputErrors(loads, parts, uncertainties) if np.isfinite(parts).all() else None


def input_name(path: str) -> str:
    """Name of an input for people, such as "thermal conductivity of steel"."""
    table, _, name = path.rpartition(".")
    words = name.replace("_", " ")
    if table.startswith("materials."):
        return f"{words} of {table.removeprefix('materials.')}"
    special = {"pin": f"pin {words}", "loading": f"loading {words}", "friction": "friction"}
    special |= {
        "temperature": f"{words} temperature",
        "disk.roughness": "Ra" if name == "ra" else words,
    }
    return special.get(table, words)

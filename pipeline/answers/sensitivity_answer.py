"""Sensitivities to inputs at one point as an answer: a dataset, a table, and lines of text."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.optimize import brentq

from pipeline.answers.case_results import CaseResults, TestPoint
from pipeline.answers.input_errors import STEP, input_name, sensitivity_dataset
from pipeline.answers.verdict_model import conditions_of
from pipeline.frames import frame_of, lines_of
from pipeline.quantities import in_unit
from pipeline.sweep.case import TEMPERATURES, VELOCITY_INPUT, Uncertainty
from pipeline.units import typeset
from tribo import Oil
from tribo.simulation.film import film_excess

TEMPERATURE_STEP = 10.0
"""Change of a temperature that answers print [K]."""
VISCOSITY = "oil.kinematic_viscosity"
_CHOICES = {
    "pin.radius": "geometry", "pin.length": "geometry", "pin.crown_radius": "geometry",
    "disk.roughness.ra": "finish", "disk.roughness.height_unit": "finish",
    "temperature.critical": "oil", VISCOSITY: "oil",
}  # fmt: skip
"""What a designer chooses by an input; by those of materials, the material."""
_MAX_LOG_FACTOR = 4.0  # of the viscosity
_ROUNDING = 2e-5  # changes below it, in ln and in percent, come from rounding
_LONG_NAMES = {
    "sensitivity": "d ln(rise ratio) / d ln(input), or its change per K of a temperature",
    "curvature": "sum of the changes of ln(rise ratio) on both sides",
    "log_rise_change": "change of ln(rise ratio) for +10 % of the input, or +10 K",
    "velocity_change": "relative change of the critical velocity for +10 % of the input, or +10 K",
    "uncertainty": "standard deviation of the input, relative or in K",
    "log_rise_deviation": "standard deviation of ln(rise ratio) by that of the input",
    "velocity_exponent": "exponent of the velocity in the temperature rise",
    "value": "value of the input in SI",
    "sides": "signs of the changes of the input that were simulated",
    "choice": "what a designer chooses by the input",
}


def sensitivity_answer(
    case: CaseResults, load: float, velocity: float, uncertainties: Sequence[Uncertainty]
) -> xr.Dataset:
    """Sensitivities of a case at a load [N] and a velocity [m/s], the strongest input first."""
    conditions = conditions_of(case, {})
    variants = [
        (variant, point)
        for variant, point in case.variants
        if variant.point == (load, velocity) and variant.of_case == case.name
    ]
    ds = sensitivity_dataset(variants, conditions).isel(point=0)
    film = ""
    if (oil := case.sweep.lubricant) and case.sweep.base.has_film:
        row = _viscosity_row(oil, conditions.bulk_temperature)
        options: Any = {"data_vars": "minimal", "coords": "minimal", "compat": "override"}
        ds = xr.concat([ds, row], "input", **options)
        (base,) = (p for v, p in variants if (v.entry, v.factor) == (VELOCITY_INPUT, 1))
        film = _film_text(case, oil, base)
    paths = ds["input"].values.tolist()
    steps = xr.DataArray(
        [TEMPERATURE_STEP if p in TEMPERATURES else STEP for p in paths], dims="input"
    )
    deviations = {path: each.deviation for each in uncertainties for path in each.entries}
    ds["log_rise_change"] = ds["sensitivity"] * steps
    ds["velocity_change"] = np.expm1(-ds["log_rise_change"] / ds["velocity_exponent"])
    ds["uncertainty"] = ("input", [deviations.get(path, math.nan) for path in paths])
    ds["log_rise_deviation"] = abs(ds["sensitivity"]) * ds["uncertainty"]
    choices = [_CHOICES.get(p, "material" if p.startswith("materials.") else "") for p in paths]
    ds = ds.assign_coords(choice=("input", choices))
    ds = ds.sortby(-ds["log_rise_deviation"].fillna(abs(ds["log_rise_change"])))
    for name, text in _LONG_NAMES.items():
        ds[name].attrs["long_name"] = text
    ds["load"].attrs["units"], ds["velocity"].attrs["units"] = "N", "m/s"
    return ds.assign_attrs(title=case.sweep.title, film=film)


def _viscosity_row(oil: Oil, bulk: float) -> xr.Dataset:
    """The row of the oil's viscosity, which changes no rise."""
    return xr.Dataset(
        {"sensitivity": ("input", [0.0]), "curvature": ("input", [math.nan])},
        {
            "input": [VISCOSITY],
            "value": ("input", [oil.viscosity(bulk)]),
            "unit": ("input", ["mPa s"]),
            "sides": ("input", ["+ and −"]),
        },
    )


def _film_text(case: CaseResults, oil: Oil, point: TestPoint) -> str:
    """From which viscosity on the film carries too much load for the model; empty if unknown."""
    inlet, pressure = (float(point.columns.get(k, -1)) for k in ("film_inlet", "film_pressure"))
    if not (inlet > 0 and pressure > 0):
        return ""
    scene, bulk = case.sweep.scene, case.conditions.bulk_temperature

    def excess(log_factor: float) -> float:
        thick, thin = (math.exp(log_factor) * viscosity for viscosity in oil.viscosities)
        scaled = replace(oil, viscosities=(thick, thin))
        return film_excess(scene, scaled, point.load, point.velocity, bulk, inlet, pressure)

    if excess(0.0) > 0:
        return "the oil film carries more than 20 % of the load here, which is outside the model"
    text = "the viscosity of the oil changes its film, and not the rise"
    if excess(_MAX_LOG_FACTOR) < 0:
        return text
    factor = math.exp(brentq(excess, 0.0, _MAX_LOG_FACTOR))
    return (
        f"{text}; from {factor:.2g} times this viscosity on, the film carries 20 % of the load, "
        "and the point is outside the model"
    )


def sensitivity_frame(ds: xr.Dataset) -> pd.DataFrame:
    """Table of sensitivities, a row for each input in the order of the dataset."""
    rows = [
        (
            input_name(path), value_text(ds, path), step_text(path), ds["choice"].values[k],
            *(_rounded(ds[n].values[k], 3) for n in ("log_rise_change", "velocity_change")),
            deviation_text(path, ds["uncertainty"].values[k]),
            _rounded(ds["log_rise_deviation"].values[k], 2), path,
        )
        for k, path in enumerate(ds["input"].values.tolist())
    ]  # fmt: skip
    heads = (
        "input", "value", "change", "choice of", "ln(rise ratio)", "critical velocity [%]",
        "standard deviation", "rise by it ± [%]", "entry",
    )  # fmt: skip
    frame = frame_of(heads, rows)
    is_declared = ds["uncertainty"].notnull().any()
    return frame if is_declared else frame.drop(columns=["standard deviation", "rise by it ± [%]"])


def _rounded(value: float, digits: int) -> float:
    """The value with a number of significant digits; 0, without a sign, below `_ROUNDING`."""
    return 0.0 if abs(value) < _ROUNDING else float(f"{value:.{digits}g}") + 0.0


def value_text(ds: xr.Dataset, path: str) -> str:
    """Value of an input with its unit, as text."""
    row = ds.sel(input=path)
    unit = str(row["unit"].item())
    return f"{in_unit(row['value'].item(), typeset(unit)):.4g} {typeset(unit)}".strip()


def step_text(path: str) -> str:
    """The change of an input that answers print."""
    return "+10 K" if path in TEMPERATURES else "+10 %"


def deviation_text(path: str, deviation: float) -> str:
    """A declared standard deviation as text; empty without one."""
    if math.isnan(deviation):
        return ""
    return f"{deviation:.3g} K" if path in TEMPERATURES else f"{100 * deviation:.3g} %"


def sensitivity_lines(ds: xr.Dataset) -> Iterator[str]:
    """The point, the table, and what it does not show, as lines of text."""
    point = f"{ds['load'].item():.4g} N and {ds['velocity'].item():.3g} m/s"
    exponent = ds["velocity_exponent"].item()
    yield f"{ds.attrs['title']}: inputs at {point}, where the rise grows as velocity^{exponent:.2f}"
    yield ""
    yield from lines_of(sensitivity_frame(ds).drop(columns="entry"))
    yield ""
    yield (
        "From changes of ± 10 % on one surface. A higher ln(rise ratio) is a hotter contact, and a "
        "lower critical velocity."
    )
    for path, sides in zip(ds["input"].values.tolist(), ds["sides"].values.tolist(), strict=True):
        if sides in ("+", "−"):
            refused = "−" if sides == "+" else "+"
            yield f"{input_name(path)}: by {sides}10 % alone, as {refused}10 % has no result"
    if ds.attrs["film"]:
        yield ds.attrs["film"]

"""Datasets of answers: units and names of variables, attributes, and the cases of a sweep.

Whatever a command, a figure or a file states is a variable or an attribute of these datasets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.attributes import answer_attributes
from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import NAMES
from pipeline.answers.error import PARTS
from pipeline.answers.field import Outcome
from pipeline.answers.results import case_dims, sweep_of
from pipeline.answers.verdict_model import ORIGINS, VERDICTS, Flag, VerdictModel
from pipeline.store.schema import PLANE

_VARIABLES = {
    "verdict": ("", "verdict on the next specimen at this point"),
    "probability": ("1", "probability of severe wear"),
    "probability_low": ("1", "probability of severe wear; its lower bound by the numerical error"),
    "probability_high": ("1", "probability of severe wear; its upper bound by the numerical error"),
    "log_rise_ratio": ("1", "ln(temperature rise over allowable rise)"),
    "log_rise_ratio_mild": ("1", "log_rise_ratio at which the specimen stayed mild"),
    "log_rise_ratio_severe": ("1", "log_rise_ratio at which the specimen was severe"),
    "governing_temperature": ("K", "contact temperature compared with the critical temperature"),
    "temperature_error": ("K", "numerical error of the governing temperature (95 % bound)"),
    "temperature_margin": ("K", "critical minus governing temperature"),
    **{
        f"temperature_error_{part}": ("K", f"part of the numerical error: {meaning}")
        for part, meaning in PARTS.items()
    },
    "critical_velocity": ("m/s", "lowest velocity at which severe wear is computed"),
    "critical_load": ("N", "lowest load at which severe wear is computed"),
    "critical_friction": ("1", "lowest coefficient of friction at which severe wear is computed"),
    **{
        f"{name}_safety_factor": ("1", f"critical over operating {meaning}")
        for name, meaning in {
            "friction": "coefficient of friction",
            "velocity": "velocity",
            "load": "load",
        }.items()
    },
    "critical_velocity_p50": ("m/s", "critical velocity with tests: severe wear is 50 % probable"),
    "critical_velocity_p05": (
        "m/s",
        "velocity at which severe wear is 5 % probable, or from which tests rule out mild",
    ),
    "critical_velocity_p95": (
        "m/s",
        "velocity at which severe wear is 95 % probable, or up to which tests rule it out",
    ),
    "ruled_out_by": ("", "tests that lower critical_velocity_p05, or raise critical_velocity_p95"),
    "velocity_error": ("1", "relative numerical error of the critical velocity (95 % bound)"),
    **{
        f"velocity_error_{part}": ("1", f"part of the relative numerical error: {meaning}")
        for part, meaning in PARTS.items()
    },
    "outcome_along_velocity": ("", "outcome along the line of rising velocity"),
    "outcome_along_load": ("", "outcome along the line of rising load"),
    "film_parameter_at_load": ("1", "film parameter on the boundary"),
    "film_parameter_at_velocity": ("1", "film parameter on the boundary"),
    "origin": ("", "origin of the result"),
    "warning_flags": ("", "what limits this answer"),
    "reason": ("", "why the verdict is withheld or unknown"),
    "nearby_tests": ("", "tests within 10 % in load and velocity"),
    "outcome": ("", "outcome of the test"),
    "loo_probability": ("1", "probability of this outcome, predicted from the other tests"),
    "friction": ("1", "coefficient of friction"),
    "bulk_temperature": ("K", "temperature of the bodies far from the contact"),
    "critical_temperature": ("K", "contact temperature at which the lubricant fails"),
    "critical_area_fraction": ("1", "share of the contact above it beyond which wear is severe"),
    "added_rise_fraction": ("1", "relative rise that is added for what is not modelled"),
    "load": ("N", "normal load on the pin"),
    "velocity": ("m/s", "sliding velocity"),
}
"""Unit and long name of each variable of an answer."""
_CODES = {
    "verdict": VERDICTS,
    "origin": ORIGINS,
    "outcome_along_velocity": tuple(outcome.name.lower() for outcome in Outcome),
    "outcome_along_load": tuple(outcome.name.lower() for outcome in Outcome),
}
"""Names of the codes 0, 1, 2 … of a variable."""


def answer_dataset(
    model: VerdictModel, variables: dict[str, Any], coordinates: Mapping[Any, Any]
) -> xr.Dataset:
    """Dataset of an answer with units, long names, conditions and attributes.

    `coordinates` replace conditions of the model.
    """
    axes = {name: getattr(model.conditions, name) for name in NAMES} | {**coordinates}
    axes |= {name: variables[name] for name in PLANE}
    data = {name: variable for name, variable in variables.items() if name not in axes}
    return with_attributes(xr.Dataset(data, axes)).assign_attrs(answer_attributes(model))


def with_attributes(ds: xr.Dataset) -> xr.Dataset:
    """The dataset with unit and long name of each variable, and the names of codes and flags."""
    for variable in ds.variables:
        name = str(variable)
        unit, meaning = _VARIABLES.get(name, ("", ""))
        attributes: dict[str, Any] = {"units": unit} if unit else {}
        attributes |= {"long_name": meaning} if meaning else {}
        if codes := _CODES.get(name):
            attributes["flag_values"] = np.arange(len(codes), dtype=np.int8)
            attributes["flag_meanings"] = " ".join(codes)
        if name == "warning_flags":
            attributes["flag_masks"] = np.array([*map(int, Flag)], np.int16)
            attributes["flag_meanings"] = " ".join(str(flag.name).lower() for flag in Flag)
        ds.variables[name].attrs.update(attributes)
    return ds


def join_cases(
    ds: xr.Dataset, cases: Sequence[CaseResults], answers: Sequence[xr.Dataset]
) -> xr.Dataset:
    """Join the answers for all cases of a sweep along the dimensions of its varied entries."""
    dims = case_dims(ds)
    joined = concatenate(answers, [ds[dim] for dim in dims])
    labels = [
        column.name
        for column in sweep_of(ds).case_table.columns
        if column.along in dims and not column.entry and column.name not in joined.coords
    ]
    joined = joined.assign_coords({name: ds[name].variable for name in labels})
    return joined.assign_attrs(missing_points=sum(case.missing for case in cases))


def concatenate(answers: Sequence[xr.Dataset], axes: Sequence[xr.DataArray]) -> xr.Dataset:
    """Join answers along `axes`; attributes that differ become coordinates."""
    common = {
        k: v for k, v in answers[0].attrs.items() if all(v == answer.attrs[k] for answer in answers)
    }
    parts = [
        answer.assign_coords({k: v for k, v in answer.attrs.items() if k not in common})
        for answer in answers
    ]
    for axis in reversed(axes):
        parts = [part.drop_vars(str(axis.name), errors="ignore") for part in parts]
        parts = [
            xr.concat(
                parts[start : start + axis.size], axis, data_vars="all", coords="different",
                compat="equals", combine_attrs="override",
            )
            for start in range(0, len(parts), axis.size)
        ]  # fmt: skip
    joined = parts[0]
    joined.attrs = common
    return joined

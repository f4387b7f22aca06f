"""The answers of a sweep as datasets: `boundary`, `margin` and `compare_tests`.

Whatever a command, a figure or a file states is a variable or an attribute of these datasets.
"""

from __future__ import annotations

import functools
import math
import os
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.attributes import POINT_CONDITIONS, answer_attributes
from pipeline.answers.condition_values import (
    NAMES,
    ConditionValues,
    Operation,
    in_array,
    in_arrays,
    override_conditions,
    replace_conditions,
)
from pipeline.answers.error import PARTS, total
from pipeline.answers.field import Outcome
from pipeline.answers.results import CaseResults, case_dims, cases_of, dataset_of, sweep_of
from pipeline.answers.verdict_model import (
    MILD,
    ORIGINS,
    OUTSIDE,
    VERDICTS,
    Flag,
    JudgedCase,
    VerdictModel,
)
from pipeline.arguments import in_si
from pipeline.constants import DECIDED, SHARP_ENDS
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.sweep import has_sharp_ends
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication

_BATCH_SIZE = 4000  # operating points evaluated at once, with about 100 MB of memory
_TABLES = (OperatingPoints, str, os.PathLike, Mapping, pd.DataFrame)
_PART_NAMES = {
    "interpolation": "interpolation between points",
    "discretization": "discretization (preset)",
    "warnings": "allowance for warnings",
    "surface": "surface sampling",
}
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
        f"temperature_error_{part}": ("K", f"part of the numerical error: {name}")
        for part, name in _PART_NAMES.items()
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
        f"velocity_error_{part}": ("1", f"part of the relative numerical error: {name}")
        for part, name in _PART_NAMES.items()
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


@np.errstate(under="ignore")
def margin(
    ds: xr.Dataset | PathLike,
    load: Any = None,
    velocity: Any = None,
    **conditions: Unpack[ConditionValues],
) -> xr.Dataset:
    """Judge operating points without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    load, velocity : float, str, array or DataArray
        Loads on the whole pin [N] and sliding velocities [m/s], or text with a unit; they and
        conditions are broadcast against each other. Lists of equal length are pairs, along
        ``place``. Leave both out for a sweep whose cases have one point each. In place of both, a
        table with the columns ``load [N]`` and ``velocity [m/s]``: its path, or its columns by
        heading, such as a data frame. It may set conditions row by row; its other columns become
        coordinates.
    **conditions
        Conditions to use instead of the scene's: ``friction``, ``bulk_temperature``,
        ``critical_temperature``, ``critical_area_fraction`` and ``added_rise_fraction``. A list
        makes a dimension.

    Returns
    -------
    Dataset
        The verdict on the next specimen, its probability, temperatures, numerical errors and their
        parts, critical velocity, load and friction with their safety factors, and flags; each with
        ``units`` and ``long_name``, and codes with ``flag_meanings``. Attributes state what applies
        to all points.

    Examples
    --------
    >>> import pipeline
    >>> answer = pipeline.margin("results/first_try.zarr", "400 N", "1.5 m/s")
    >>> answer["verdict"].attrs["flag_meanings"].split()[answer["verdict"].item()]
    'mild'
    >>> answer["governing_temperature"].round(1).item()
    391.6
    """
    ds = dataset_of(ds)
    if velocity is None and isinstance(load, _TABLES):
        points = load if isinstance(load, OperatingPoints) else OperatingPoints.read(load)
        return _judge_rows(ds, points, conditions)
    if (load is None) != (velocity is None):
        raise InputError("give both a load and a velocity")
    coordinates = {
        name: in_array(name, values, functools.partial(in_si, name, like=like), "place")
        for name, values, like in (("load", load, "500 N"), ("velocity", velocity, "2 m/s"))
        if values is not None
    }
    overrides = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        case_overrides = _arguments_of_case(overrides, case)
        case_coordinates = _arguments_of_case(coordinates, case) or _single_point(case)
        try:
            arrays = xr.broadcast(*case_coordinates.values(), *case_overrides.values())
        except ValueError as error:
            message = f"load, velocity and conditions do not fit together: {error}"
            raise InputError(message) from None
        template = arrays[0]
        loads, velocities, *columns = (array.values.ravel() for array in arrays)
        rows = [*zip(*(column.tolist() for column in columns), strict=True)] or [()] * template.size
        conditions_by_row = {
            row: replace_conditions(case.conditions, dict(zip(case_overrides, row, strict=True)))
            for row in dict.fromkeys(rows)
        }
        point_conditions = [conditions_by_row[row] for row in rows]
        heating = np.array([[c.friction, c.bulk_temperature] for c in point_conditions])
        operation = Operation(loads.astype(float), velocities.astype(float), *heating.T)
        groups = defaultdict[Any, list[int]](list)  # indices of points with the same oil
        for k, c in enumerate(point_conditions):
            oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
            groups[oil].append(k)
        judged_case, values = JudgedCase(case), dict[str, Any]()
        for indices in groups.values():
            model = judged_case.under(point_conditions[indices[0]])
            for chunk in np.array_split(indices, -(-len(indices) // _BATCH_SIZE)):
                for name, batch in _judge_points(model, operation.take(chunk)).items():
                    values.setdefault(name, np.empty(template.size, batch.dtype))[chunk] = batch
        variables = {
            name: (template.dims, column.reshape(template.shape)) for name, column in values.items()
        }
        varied = {name: array for name, array in case_overrides.items() if array.ndim}
        dataset = _to_dataset(variables, model, varied, template.drop_attrs().coords)
        attributes = {"conditions": POINT_CONDITIONS} if len(conditions_by_row) > 1 else {}
        return dataset.assign_attrs(attributes)

    return _join_cases(ds, answer)


def _arguments_of_case(
    arguments: Mapping[str, xr.DataArray], case: CaseResults
) -> dict[str, xr.DataArray]:
    """Arguments of a case; those that vary along the dimensions of cases, at its labels."""
    selected = {**arguments}
    for name, argument in arguments.items():
        labels = {dim: case.labels[str(dim)] for dim in argument.dims if dim in case.labels}
        try:
            selected[name] = argument.sel(labels, drop=True) if labels else argument
        except (IndexError, KeyError, TypeError):
            raise InputError(f"{name} has not all {min(map(str, labels))} of the sweep") from None
    return selected


def _single_point(case: CaseResults) -> dict[str, xr.DataArray]:
    """Load and velocity of a case that has a single point."""
    if max(len(case.loads), len(case.velocities)) > 1:
        raise InputError("no operating point is given; give a load and a velocity")
    return {"load": xr.DataArray(case.loads[0]), "velocity": xr.DataArray(case.velocities[0])}


def _judge_rows(
    ds: xr.Dataset, points: OperatingPoints, conditions: Mapping[str, Any]
) -> xr.Dataset:
    """Judge the rows of a table, whose conditions, if it has any, replace the others."""
    columns = dict[str, Any]()
    for name, cells in points.columns.items():
        columns[name] = xr.DataArray(np.array(cells, object), dims="place")
    answer = margin(ds, **{**conditions, **columns})
    labels = {f"{k} (given)" if k in answer.variables else k: x for k, x in points.labels.items()}
    return answer.assign_coords({name: ("place", [*cells]) for name, cells in labels.items()})


def _judge_points(model: VerdictModel, points: Operation) -> dict[str, Any]:
    """Variables of `margin` at k points."""
    for values, axis in ((points.load, "load"), (points.velocity, "velocity")):
        limits = model.ranges[axis]
        values[:] = [snap(value, *limits) for value in values.tolist()]
    columns = model.points(points)
    is_known = ~np.isnan(columns["log_rise_ratio"])
    for axis in ("velocity", "load"):
        columns[f"critical_{axis}"] = np.full(is_known.shape, np.nan)
        columns[f"outcome_along_{axis}"] = np.full(is_known.shape, int(Outcome.UNKNOWN), np.int8)
    columns["critical_velocity_p50"] = np.full(is_known.shape, np.nan)
    if is_known.any():
        known_points = points.take(is_known)
        for axis in ("velocity", "load"):
            line = model.critical(axis, known_points)
            for name, values in line.items():
                columns[name][is_known] = values
        if model.evidence.specimens:
            columns["critical_velocity_p50"][is_known] = model.velocity_of_probability(known_points)
    for axis in ("velocity", "load"):
        factor = columns[f"critical_{axis}"] / getattr(points, axis)
        is_outside = columns["verdict"] == OUTSIDE
        columns[f"{axis}_safety_factor"] = np.where(is_outside, np.nan, factor)
    if has_sharp_ends(model.case.sweep):
        with np.errstate(invalid="ignore"):
            is_near = columns["velocity_safety_factor"] * (1 - SHARP_ENDS[-1]) <= 1
        columns["warning_flags"] += ((columns["verdict"] == MILD) & is_near) * Flag.SHARP_ENDS
    nearby = [
        ", ".join(model.evidence.nearby(*pair))
        for pair in zip(points.load.tolist(), points.velocity.tolist(), strict=True)
    ]
    return columns | {"nearby_tests": np.array(nearby, object), **points._asdict()}


@np.errstate(under="ignore")
def boundary(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Find the critical velocity at each load, and the critical load at each velocity.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    **conditions
        As in `margin`.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` and ``critical_load(velocity)``, computed without tests;
        ``velocity_error(load)`` and its parts; ``critical_velocity_p05``, ``_p50`` and ``_p95``
        with tests, NaN outside the velocities of the sweep; ``ruled_out_by(load)``, the tests that
        lower the first of these or raise the last; the outcomes ``outcome_along_velocity(load)``
        and ``outcome_along_load(velocity)``. Varied entries, and conditions given as lists, are
        further dimensions.

    Examples
    --------
    >>> import pipeline
    >>> boundary = pipeline.boundary("results/first_try.zarr", friction=[0.1, 0.12])
    >>> boundary["critical_velocity"].sel(load=400).round(2).values.tolist()
    [2.28, 1.68]
    """
    ds = dataset_of(ds)
    overrides = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        for name in PLANE:
            if name not in ds["status"].dims and case.is_row:
                raise InputError(f"each case has its own {name}, so there is no boundary")
            if name not in ds["status"].dims:
                value = f"{ds[name].item():g}"
                raise InputError(
                    f"{name} is a single value; select a list instead: ds.sel({name}=[{value}])"
                )
        judged_case = JudgedCase(case)
        case_overrides = _arguments_of_case(overrides, case)
        template = xr.broadcast(*case_overrides.values())[0] if case_overrides else xr.DataArray(0)
        arrays = [array.broadcast_like(template) for array in case_overrides.values()]
        boundaries = []
        for index in np.ndindex(template.shape):
            values = {
                name: array.values[index]
                for name, array in zip(case_overrides, arrays, strict=True)
            }
            varied = {
                name: xr.DataArray(value)
                for name, value in values.items()
                if case_overrides[name].ndim
            }
            boundaries.append(
                _boundary(judged_case.under(replace_conditions(case.conditions, values)), varied)
            )
        return _concatenate(boundaries, [template[dim] for dim in template.dims])

    return _join_cases(ds, answer)


def _boundary(model: VerdictModel, varied: dict[str, xr.DataArray]) -> xr.Dataset:
    loads, velocities = model.field.loads, model.field.velocities
    variables: dict[str, Any] = {}
    for axis, dim, values in (("velocity", "load", loads), ("load", "velocity", velocities)):
        points = Operation.under(model.conditions, values, values)
        critical = model.critical(axis, points)
        variables |= {name: (dim, values) for name, values in critical.items()}
        if oil := find_lubrication(model.case.sweep.scene, model.case.sweep.lubricant):
            coordinates = {dim: values, axis: critical[f"critical_{axis}"]}
            bulk = model.conditions.bulk_temperature
            film = oil.film_parameter(coordinates["load"], coordinates["velocity"], bulk)
            variables[f"film_parameter_at_{dim}"] = (dim, film)
    parts = model.velocity_errors(loads, variables["critical_velocity"][1])
    variables["velocity_error"] = ("load", total(parts))
    for part, error in zip(PARTS, parts, strict=True):
        variables[f"velocity_error_{part}"] = ("load", error)
    points = Operation.under(model.conditions, loads, loads)
    decided = model.decided_velocities(points)
    variables["critical_velocity_p05"] = ("load", decided.pop("critical_velocity_p05"))
    variables["critical_velocity_p50"] = ("load", model.velocity_of_probability(points))
    variables |= {name: ("load", values) for name, values in decided.items()}
    return _to_dataset(variables | {"load": loads, "velocity": velocities}, model, varied, {})


def _to_dataset(
    variables: dict[str, Any], model: VerdictModel, varied: dict[str, xr.DataArray],
    coordinates: Mapping[Any, Any],
) -> xr.Dataset:  # fmt: skip
    """Dataset of an answer with units, long names, conditions and attributes."""
    axes = {**coordinates} | {name: variables.pop(name) for name in PLANE}
    point_conditions = {
        name: variables.pop(name, None) for name in ("friction", "bulk_temperature")
    }
    axes |= {name: getattr(model.conditions, name) for name in NAMES}
    for name, array in varied.items():
        axes[name] = (
            array
            if name in array.dims or point_conditions.get(name) is None
            else point_conditions[name]
        )
    return with_attributes(xr.Dataset(variables, axes)).assign_attrs(answer_attributes(model))


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


def _join_cases(ds: xr.Dataset, answer: Callable[[CaseResults], xr.Dataset]) -> xr.Dataset:
    """Join the answers for all cases of a sweep along the dimensions of its varied entries."""
    cases = cases_of(ds)
    missing = sum(case.missing for case in cases)
    dims = case_dims(ds)
    joined = _concatenate([answer(case) for case in cases], [ds[dim] for dim in dims])
    labels = [
        column.name
        for column in sweep_of(ds).case_table.columns
        if column.along in dims and not column.entry and column.name not in joined.coords
    ]
    joined = joined.assign_coords({name: ds[name].variable for name in labels})
    return joined.assign_attrs(missing_points=missing)


def _concatenate(answers: list[xr.Dataset], axes: list[xr.DataArray]) -> xr.Dataset:
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


def compare_tests(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Compare the tests of a scene with the model, each at its own conditions, along ``test``.

    ``log_rise_ratio_mild`` and ``log_rise_ratio_severe`` belong to the ends of a transition, and
    ``loo_probability`` is the probability of the outcome by the other tests. The attribute
    ``levels`` has the values of ln(rise ratio) at which severe wear is 5, 50 and 95 % probable.

    Examples
    --------
    >>> import pipeline
    >>> tests = pipeline.compare_tests("results/first_try.zarr")
    >>> tests["load"].values.tolist(), tests["log_rise_ratio"].round(2).values.tolist()
    ([750.0, 600.0, 400.0, 200.0], [0.03, -0.02, -0.1, -0.03])
    """
    case = cases_of(ds)[0]
    model = JudgedCase(case).under(override_conditions(case.conditions, conditions))
    evidence = model.evidence
    pairs = zip(evidence.specimens, evidence.posterior.loo_probabilities, strict=True)
    loo_probabilities = {id(row): probability for rows, probability in pairs for row in rows}
    columns: dict[str, list[Any]] = {}
    for row in evidence.rows:
        test, test_conditions = row.test, row.conditions
        for name, value in {
            "test": test.number, "outcome": test.outcome,
            "load": test.normal_load, "velocity": test.velocity,
            "friction": test_conditions.friction if test_conditions else math.nan,
            "bulk_temperature": test_conditions.bulk_temperature if test_conditions else math.nan,
            "governing_temperature": row.temperature,
            "log_rise_ratio": row.mild if math.isnan(row.severe) else row.severe,
            "log_rise_ratio_mild": row.mild, "log_rise_ratio_severe": row.severe,
            "loo_probability": loo_probabilities.get(id(row), math.nan), "reason": row.reason,
        }.items():  # fmt: skip
            columns.setdefault(name, []).append(value)
    comparison = xr.Dataset({name: ("test", values) for name, values in columns.items()})
    comparison = comparison if columns else xr.Dataset(coords={"test": np.array([], object)})
    bulk = np.full(1, model.conditions.bulk_temperature)
    levels = [
        float(evidence.log_rise_ratio_quantiles(probability, bulk)[0]) for probability in DECIDED
    ]
    return with_attributes(comparison).assign_attrs(
        answer_attributes(model), missing_points=0, levels=levels
    )

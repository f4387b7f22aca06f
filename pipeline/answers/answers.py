"""`margin` and `boundary`: verdicts on operating points, critical velocities and loads."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.answer_dataset import answer_dataset, join_cases
from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import (
    ConditionValues,
    QueryPoints,
    argument_array,
    arguments_of_case,
    condition_arrays,
    replace_conditions,
)
from pipeline.answers.error import PARTS, total
from pipeline.answers.field import Outcome
from pipeline.answers.results import cases_of, dataset_of
from pipeline.answers.verdict_model import OUTSIDE, VerdictModel, verdict_model
from pipeline.arguments import in_si, typed_arguments
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from tribo import InputError

_BATCH_SIZE = 4000  # operating points evaluated at once, with about 100 MB of memory


@typed_arguments
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
    tables = OperatingPoints, str, os.PathLike, Mapping, pd.DataFrame
    if velocity is None and isinstance(load, tables):
        table = load if isinstance(load, OperatingPoints) else OperatingPoints.read(load)
        columns: dict[str, Any] = {
            name: xr.DataArray(cells, dims="place") for name, cells in table.columns.items()
        }
        answer = margin(ds, **{**conditions, **columns})
        return answer.assign_coords(
            {
                f"{name} (given)" if name in answer.variables else name: ("place", [*cells])
                for name, cells in table.labels.items()
            }
        )
    if (load is None) != (velocity is None):
        raise InputError("give both a load and a velocity")
    points = {
        name: argument_array(name, values, functools.partial(in_si, name, like=like), "place")
        for name, values, like in (("load", load, "500 N"), ("velocity", velocity, "2 m/s"))
        if values is not None
    }
    overrides = condition_arrays(conditions)
    cases = cases_of(ds)
    return join_cases(ds, cases, [_margin_of_case(case, points, overrides) for case in cases])


def _margin_of_case(
    case: CaseResults, points: Mapping[str, xr.DataArray], overrides: Mapping[str, xr.DataArray]
) -> xr.Dataset:
    """Judge operating points of one case; `points` has their loads and velocities."""
    points = arguments_of_case(points, case.labels)
    overrides = arguments_of_case(overrides, case.labels)
    if not points:
        if max(len(case.loads), len(case.velocities)) > 1:
            raise InputError("no operating point is given; give a load and a velocity")
        points = {
            "load": xr.DataArray(case.loads[0]),
            "velocity": xr.DataArray(case.velocities[0]),
        }
    models, variables = _evaluate(case, points["load"], points["velocity"], overrides, _judge)
    # A condition that varies has its dimension, or a value at each point.
    varied = {
        name: variables.get(name, array) if name not in array.dims else array
        for name, array in overrides.items()
        if array.ndim
    }
    return answer_dataset(models, variables, varied)


def _evaluate(
    case: CaseResults,
    load: xr.DataArray,
    velocity: xr.DataArray,
    overrides: Mapping[str, xr.DataArray],
    compute: Callable[[VerdictModel, QueryPoints], dict[str, Any]],
) -> tuple[list[VerdictModel], dict[str, xr.DataArray]]:
    """Models of all oils, and variables by `compute` at points, broadcast against conditions.

    Points under the same oil are computed together.
    """
    try:
        template, *arrays = xr.broadcast(load, velocity, *overrides.values())
    except ValueError as error:
        message = f"load, velocity and conditions do not fit together: {error}"
        raise InputError(message) from None
    loads, velocities, *columns = (array.values.ravel() for array in (template, *arrays))
    rows = [*zip(*(c.tolist() for c in columns), strict=True)] or [()] * template.size
    of_row = {
        row: replace_conditions(case.conditions, dict(zip(overrides, row, strict=True)))
        for row in dict.fromkeys(rows)
    }
    conditions = [of_row[row] for row in rows]
    points = QueryPoints(
        loads,
        velocities,
        np.array([c.friction for c in conditions]),
        np.array([c.bulk_temperature for c in conditions]),
    )
    indices_of_oil, computed = dict[Any, list[int]](), dict[str, Any]()
    for k, c in enumerate(conditions):
        oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
        indices_of_oil.setdefault(oil, []).append(k)
    models = [verdict_model(case, conditions[k]) for k, *_ in indices_of_oil.values()]
    for model, indices in zip(models, indices_of_oil.values(), strict=True):
        for batch in np.array_split(indices, -(-len(indices) // _BATCH_SIZE)):
            for name, values in compute(model, points.take(batch)).items():
                computed.setdefault(name, np.empty(template.size, values.dtype))[batch] = values
    template = template.drop_attrs()
    return models, {
        name: template.copy(data=values.reshape(template.shape))
        for name, values in computed.items()
    }


def _judge(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Variables of `margin` at k points."""
    load_range, velocity_range = model.ranges["load"], model.ranges["velocity"]
    points = points._replace(
        load=np.array([snap(load, *load_range) for load in points.load.tolist()]),
        velocity=np.array([snap(speed, *velocity_range) for speed in points.velocity.tolist()]),
    )
    columns = model.points(points)
    is_known = ~np.isnan(columns["log_rise_ratio"])
    known_points = points.take(is_known)
    for axis in ("velocity", "load"):
        columns[f"critical_{axis}"] = np.full(is_known.shape, np.nan)
        columns[f"outcome_along_{axis}"] = np.full(is_known.shape, Outcome.UNKNOWN, np.int8)
        if is_known.any():
            for name, values in model.critical(axis, known_points).items():
                columns[name][is_known] = values
    columns["critical_velocity_p50"] = np.full(is_known.shape, np.nan)
    if model.evidence.specimens and is_known.any():
        columns["critical_velocity_p50"][is_known] = model.velocity_of_probability(known_points)
    for axis in ("velocity", "load"):
        factor = columns[f"critical_{axis}"] / getattr(points, axis)
        is_outside = columns["verdict"] == OUTSIDE
        columns[f"{axis}_safety_factor"] = np.where(is_outside, np.nan, factor)
    return columns | points._asdict()


@typed_arguments
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
    overrides, cases = condition_arrays(conditions), cases_of(ds)
    for name in PLANE:
        if name not in ds["status"].dims and cases[0].is_row:
            raise InputError(f"each case has its own {name}, so there is no boundary")
        if name not in ds["status"].dims:
            value = f"{ds[name].item():g}"
            raise InputError(
                f"{name} is a single value; select a list instead: ds.sel({name}=[{value}])"
            )
    return join_cases(ds, cases, [_boundary_of_case(case, overrides) for case in cases])


def _boundary_of_case(case: CaseResults, overrides: Mapping[str, xr.DataArray]) -> xr.Dataset:
    """Boundary of one case under each combination of conditions."""
    overrides = arguments_of_case(overrides, case.labels)
    variables: dict[str, Any] = {"load": case.loads, "velocity": case.velocities}
    for dim, compute in (("load", _along_velocity), ("velocity", _along_load)):
        line = xr.DataArray(variables[dim], {dim: variables[dim]}, dim)
        models, computed = _evaluate(case, line, line, overrides, compute)
        variables |= {name: array.transpose(..., dim) for name, array in computed.items()}
    return answer_dataset(models, variables, {k: a for k, a in overrides.items() if a.ndim})


def _along_velocity(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Critical velocities at the loads of points, their errors, and those with tests."""
    columns = model.critical("velocity", points)
    parts = model.velocity_errors(points.load, columns["critical_velocity"])
    decided = model.decided_velocities(points)
    return {
        **columns,
        "velocity_error": total(parts),
        **{f"velocity_error_{part}": error for part, error in zip(PARTS, parts, strict=True)},
        "critical_velocity_p05": decided.pop("critical_velocity_p05"),
        "critical_velocity_p50": model.velocity_of_probability(points),
        **decided,
    }


def _along_load(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Critical loads at the velocities of points."""
    return model.critical("load", points)

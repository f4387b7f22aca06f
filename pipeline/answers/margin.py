"""`margin`: verdicts on operating points."""

from __future__ import annotations

import functools
import os
from collections import defaultdict
from collections.abc import Mapping
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
from pipeline.answers.field import Outcome
from pipeline.answers.results import cases_of, dataset_of
from pipeline.answers.verdict_model import MILD, OUTSIDE, Flag, JudgedCase, VerdictModel
from pipeline.arguments import in_si, typed_arguments
from pipeline.constants import SHARP_ENDS
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.location import PathLike
from pipeline.sweep.sweep import has_sharp_ends
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
    overrides = arguments_of_case(overrides, case.labels)
    points = arguments_of_case(points, case.labels) or _single_point(case)
    try:
        template, *arrays = xr.broadcast(*points.values(), *overrides.values())
    except ValueError as error:
        message = f"load, velocity and conditions do not fit together: {error}"
        raise InputError(message) from None
    loads, velocities, *columns = (array.values.ravel() for array in (template, *arrays))
    rows = [*zip(*columns, strict=True)] or [()] * template.size
    conditions_of_row = {
        row: replace_conditions(case.conditions, dict(zip(overrides, row, strict=True)))
        for row in dict.fromkeys(rows)
    }
    conditions = [conditions_of_row[row] for row in rows]
    query_points = QueryPoints(
        loads.astype(float),
        velocities.astype(float),
        np.array([c.friction for c in conditions]),
        np.array([c.bulk_temperature for c in conditions]),
    )
    indices_of_oil = defaultdict[Any, list[int]](list)
    for k, c in enumerate(conditions):
        oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
        indices_of_oil[oil].append(k)
    judged_case, answers = JudgedCase(case), dict[str, Any]()
    for indices in indices_of_oil.values():
        model = judged_case.under(conditions[indices[0]])
        for batch in np.array_split(indices, -(-len(indices) // _BATCH_SIZE)):
            for name, values in _judge(model, query_points.take(batch)).items():
                answers.setdefault(name, np.empty(template.size, values.dtype))[batch] = values
    variables = {
        name: (template.dims, values.reshape(template.shape)) for name, values in answers.items()
    }
    # A condition that varies has its dimension, or a value at each point.
    varied = {
        name: variables.get(name, array) if name not in array.dims else array
        for name, array in overrides.items()
        if array.ndim
    }
    dataset = answer_dataset(model, variables, template.drop_attrs().coords | varied)
    if len(conditions_of_row) > 1:
        dataset.attrs["conditions"] = "given for each point"
    return dataset


def _single_point(case: CaseResults) -> dict[str, xr.DataArray]:
    """Load and velocity of a case that has a single point."""
    if max(len(case.loads), len(case.velocities)) > 1:
        raise InputError("no operating point is given; give a load and a velocity")
    return {"load": xr.DataArray(case.loads[0]), "velocity": xr.DataArray(case.velocities[0])}


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
    if has_sharp_ends(model.case.sweep):
        is_near = columns["velocity_safety_factor"] * (1 - SHARP_ENDS[-1]) <= 1
        columns["warning_flags"] += ((columns["verdict"] == MILD) & is_near) * Flag.SHARP_ENDS
    pairs = zip(points.load.tolist(), points.velocity.tolist(), strict=True)
    nearby = [", ".join(model.evidence.nearby(*pair)) for pair in pairs]
    return columns | {"nearby_tests": np.array(nearby, object), **points._asdict()}

"""`boundary`: critical velocities and loads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
import xarray as xr

from pipeline.answers.answer_dataset import answer_dataset, concatenate, join_cases
from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import (
    ConditionValues,
    QueryPoints,
    arguments_of_case,
    condition_arrays,
    replace_conditions,
)
from pipeline.answers.error import PARTS, total
from pipeline.answers.results import cases_of, dataset_of
from pipeline.answers.verdict_model import JudgedCase, VerdictModel
from pipeline.arguments import typed_arguments
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication


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
    varied = [name for name, array in overrides.items() if array.ndim]
    template, *arrays = xr.broadcast(xr.DataArray(0), *overrides.values())
    judged_case, boundaries = JudgedCase(case), list[xr.Dataset]()
    for index in np.ndindex(template.shape):
        values = {name: array.values[index] for name, array in zip(overrides, arrays, strict=True)}
        model = judged_case.under(replace_conditions(case.conditions, values))
        boundaries.append(_boundary(model, {name: values[name] for name in varied}))
    return concatenate(boundaries, [template[dim] for dim in template.dims])


def _boundary(model: VerdictModel, varied: Mapping[str, Any]) -> xr.Dataset:
    """Boundary under the conditions of a model; `varied` has those that other models replace."""
    loads, velocities = model.field.loads, model.field.velocities
    variables: dict[str, Any] = {"load": loads, "velocity": velocities}
    for axis, dim, values in (("velocity", "load", loads), ("load", "velocity", velocities)):
        points = QueryPoints.under(model.conditions, values, values)
        critical = model.critical(axis, points)
        variables |= {name: (dim, column) for name, column in critical.items()}
        if oil := find_lubrication(model.case.sweep.scene, model.case.sweep.lubricant):
            coordinates = {dim: values, axis: critical[f"critical_{axis}"]}
            bulk = model.conditions.bulk_temperature
            film = oil.film_parameter(coordinates["load"], coordinates["velocity"], bulk)
            variables[f"film_parameter_at_{dim}"] = (dim, film)
    parts = model.velocity_errors(loads, variables["critical_velocity"][1])
    points = QueryPoints.under(model.conditions, loads, loads)
    decided = model.decided_velocities(points)
    columns = {
        "velocity_error": total(parts),
        **{f"velocity_error_{part}": error for part, error in zip(PARTS, parts, strict=True)},
        "critical_velocity_p05": decided.pop("critical_velocity_p05"),
        "critical_velocity_p50": model.velocity_of_probability(points),
        **decided,
    }
    variables |= {name: ("load", column) for name, column in columns.items()}
    return answer_dataset(model, variables, varied)

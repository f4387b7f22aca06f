"""`margin` and `boundary`: verdicts on operating points, critical velocities and loads."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.answer_dataset import (
    answer_dataset,
    join_cases,
    with_governing_row,
    with_mild_load_factor,
)
from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import (
    PAIRS,
    QueryPoints,
    argument_array,
    arguments_of_case,
    condition_arrays,
    oil_of,
    replace_conditions,
)
from pipeline.answers.error import PARTS, total
from pipeline.answers.field import LineOutcome
from pipeline.answers.remedies import remedies
from pipeline.answers.results import cases_of, dataset_of
from pipeline.answers.verdict_limits import Side, friction_limits, line_limits
from pipeline.answers.verdict_model import (
    MILD,
    OUTSIDE,
    SEVERE,
    UNDECIDED,
    UNKNOWN,
    VerdictModel,
    verdict_model,
)
from pipeline.condition_kinds import ConditionValues, OperatingPoints
from pipeline.kinds import LOAD, VELOCITY
from pipeline.quantities import snap
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from pipeline.units import UnitError, to_si
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array, Mask

_BATCH_SIZE = 4000  # operating points evaluated at once, with about 100 MB of memory


@np.errstate(under="ignore")
def margin(
    ds: xr.Dataset | PathLike,
    load: Any = None,
    velocity: Any = None,
    without_tests: bool = False,
    **conditions: Unpack[ConditionValues],
) -> xr.Dataset:
    """Judge operating points without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    load, velocity : float, str, array or DataArray
        Loads on the whole pin [N] and sliding velocities [m/s], or text with a unit. Two lists of
        equal length are taken pairwise, along ``place``; DataArrays are broadcast by dimension,
        against conditions, too. Leave both out for a sweep whose cases have one point each. In
        place of both, a table with the columns ``load [N]`` and ``velocity [m/s]``: its path, or
        its columns by heading, such as a data frame. It may set conditions row by row; its other
        columns become coordinates.
    without_tests : bool, optional
        Leave out the tests of the scene.
    **conditions
        Conditions to use instead of the scene's: ``friction``, ``bulk_temperature``,
        ``critical_temperature``, ``critical_area_fraction`` and ``added_rise_fraction``. A list
        makes a dimension. Tests of the scene count at its critical temperature only.

    Returns
    -------
    Dataset
        ``verdict`` on the next specimen, a code: its word is ``flag_meanings.split()[code]``, as
        below; ``probability`` of severe wear, and ``probability_low`` and ``probability_high`` by
        the numerical error; ``governing_temperature``, ``temperature_margin`` and
        ``temperature_error``, a 95 % bound, with its parts; the limits ``mild_load``,
        ``mild_velocity`` and ``mild_friction``, and their safety factors, these limits over the
        values of the point; computed critical velocity, load and friction; flags, and
        ``decided_by``, what would decide an undecided verdict. Rows with load factors have a
        ``mild_load_factor``; the row with the smallest ``governs``.

        The verdict is mild up to a mild limit, and severe from a severe limit. A limit outside the
        sweep is NaN, and its code ``mild_…_side`` or ``severe_…_side`` says where it is. Variables
        have ``units`` and ``long_name``, codes ``flag_meanings``. Attributes state what applies to
        all points.

    Examples
    --------
    >>> import pipeline
    >>> answer = pipeline.margin("results/first_try.zarr", "400 N", "1.5 m/s")
    >>> answer["verdict"].attrs["flag_meanings"].split()[answer["verdict"].item()]
    'mild'
    >>> answer["governing_temperature"].round(1).item()
    391.5
    """
    ds = dataset_of(ds, without_tests)
    if hasattr(load, "to_pandas") and not isinstance(load, xr.DataArray | xr.Dataset):
        package = type(load).__module__.partition(".")[0]
        raise InputError(f"load is of {package}; give load.to_pandas()")
    tables = OperatingPoints, str, os.PathLike, Mapping, pd.DataFrame
    if velocity is None and isinstance(load, tables) and not _is_load(load):
        table = load if isinstance(load, OperatingPoints) else OperatingPoints.read(load)
        columns: dict[str, Any] = {
            name: xr.DataArray(cells, dims=PAIRS) for name, cells in table.columns.items()
        }
        answer = margin(ds, **{**conditions, **columns})
        return answer.assign_coords(
            {
                f"{name} (given)" if name in answer.variables else name: (PAIRS, [*cells])
                for name, cells in table.labels.items()
            }
        )
    if (load is None) != (velocity is None):
        missing = "load" if load is None else "velocity"
        raise InputError(f"{missing} is missing; give both a load and a velocity, or a table")
    points = {
        name: argument_array(name, values, kind.in_si, PAIRS)
        for name, values, kind in (("load", load, LOAD), ("velocity", velocity, VELOCITY))
        if values is not None
    }
    return _margins(ds, points, conditions, _judge_with_limits)


@np.errstate(under="ignore")
def plane_margins(
    ds: xr.Dataset, loads: Array, velocities: Array, conditions: Mapping[str, Any]
) -> xr.Dataset:
    """Margins (..., load, velocity) without limits, which would take most of the time."""
    axes = {"load": xr.DataArray(loads, dims="load")}
    axes["velocity"] = xr.DataArray(velocities, dims="velocity")
    margins = _margins(dataset_of(ds, False), axes, conditions, _judge)
    return margins.transpose(..., *PLANE).assign_coords(axes)


_Judge = Callable[[VerdictModel, QueryPoints], dict[str, Any]]


def _margins(
    ds: xr.Dataset,
    points: Mapping[str, xr.DataArray],
    conditions: Mapping[str, Any],
    judge: _Judge,
) -> xr.Dataset:
    """Judge operating points of all cases; `points` has their loads and velocities."""
    arrays, cases, answers = condition_arrays(conditions), cases_of(ds), list[xr.Dataset]()
    for case in cases:
        plane = arguments_of_case(points, case.labels) or _point_of(case)
        overrides = arguments_of_case(arrays, case.labels)
        models, variables = _evaluate(case, plane["load"], plane["velocity"], overrides, judge)
        answer = answer_dataset(models, variables, overrides)
        answers.append(with_mild_load_factor(answer, case))
    return with_governing_row(join_cases(ds, cases, answers))


def _point_of(case: CaseResults) -> dict[str, xr.DataArray]:
    """Load and velocity of a case that has a single one of both."""
    if case.own_load is None and max(len(case.loads), len(case.velocities)) > 1:
        raise InputError("no operating point is given; give a load and a velocity")
    load, velocity = case.own_load or case.loads[0], case.velocities[0]
    return {"load": xr.DataArray(load), "velocity": xr.DataArray(velocity)}


def _is_load(value: Any) -> bool:
    """True for text such as "400 N", which is no path of a table."""
    with suppress(UnitError):
        return isinstance(value, str) and to_si(value, "1 N") > 0
    return False


def _evaluate(
    case: CaseResults,
    load: xr.DataArray,
    velocity: xr.DataArray,
    overrides: Mapping[str, xr.DataArray],
    compute: _Judge,
) -> tuple[list[VerdictModel], dict[str, xr.DataArray]]:
    """Models of all oils, and variables by `compute` at points, broadcast against conditions.

    Points under the same oil are computed together.
    """
    try:
        template, *arrays = xr.broadcast(load, velocity, *overrides.values())
    except ValueError:
        arrays_by_name = {"load": load, "velocity": velocity, **overrides}
        sizes = (f"{name} has {array.size}" for name, array in arrays_by_name.items() if array.ndim)
        raise InputError(
            f"values cannot be paired: {', '.join(sizes)}; give equal numbers of each"
        ) from None
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
        indices_of_oil.setdefault(oil_of(c), []).append(k)
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
    """Variables of `margin` at k points, without limits."""
    load_range, velocity_range = model.ranges["load"], model.ranges["velocity"]
    points = points._replace(
        load=np.array([snap(load, *load_range) for load in points.load.tolist()]),
        velocity=np.array([snap(speed, *velocity_range) for speed in points.velocity.tolist()]),
    )
    columns = model.points(points)
    columns |= model.end_temperatures(points, columns["governing_temperature"])
    is_known = ~np.isnan(columns["log_rise_ratio"])
    known = points.take(is_known)
    for axis in ("velocity", "load"):
        critical, outcomes = model.critical(axis, known).values()
        columns[f"critical_{axis}"] = _spread(is_known, critical)
        columns[f"outcome_along_{axis}"] = _spread(is_known, outcomes, LineOutcome.UNKNOWN)
    has_tests = bool(model.evidence.specimens)
    p50 = model.velocity_of_probability(known) if has_tests else np.full(known.load.shape, np.nan)
    columns["critical_velocity_p50"] = _spread(is_known, p50)
    is_open = (columns["verdict"] == UNDECIDED) & (columns["reason"] == "")
    columns["decided_by"] = _spread(is_open, remedies(model, points.take(is_open)), 0)
    return columns | points._asdict()


def _judge_with_limits(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Variables of `margin` at k points: those of `_judge`, mild limits and safety factors."""
    columns = _judge(model, points)
    points = points._replace(**{axis: columns[axis] for axis in PLANE})
    verdicts = columns["verdict"]
    is_known = verdicts != UNKNOWN
    known = points.take(is_known), verdicts[is_known]
    limits = {axis: line_limits(model, axis, [MILD], *known)[0] for axis in ("velocity", "load")}
    limits["friction"] = friction_limits(model, known[0], columns["critical_friction"][is_known])
    for name, (values, sides) in limits.items():
        columns[f"mild_{name}"] = _spread(is_known, values)
        columns[f"mild_{name}_side"] = _spread(is_known, sides, Side.UNKNOWN)
        with np.errstate(divide="ignore"):
            factor = columns[f"mild_{name}"] / getattr(points, name)
        columns[f"{name}_safety_factor"] = np.where(verdicts == OUTSIDE, np.nan, factor)
    return columns


def _spread(mask: Mask, values: Any, elsewhere: float = np.nan) -> Any:
    """Column with `values` where a mask is true."""
    column = np.full(mask.shape, elsewhere, values.dtype)
    column[mask] = values
    return column


@np.errstate(under="ignore")
def boundary(
    ds: xr.Dataset | PathLike,
    without_tests: bool = False,
    **conditions: Unpack[ConditionValues],
) -> xr.Dataset:
    """Find the critical velocity at each load, and the critical load at each velocity.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    without_tests : bool, optional
        Leave out the tests of the scene.
    **conditions
        As in `margin`.

    Returns
    -------
    Dataset
        ``mild_velocity(load)`` and ``severe_velocity(load)``, ``mild_load(velocity)`` and
        ``severe_load(velocity)``, limits as in `margin`; ``ruled_out_by(load)``, the tests that
        decide a limit. Furthermore ``critical_velocity(load)`` and ``critical_load(velocity)``,
        computed without tests; ``velocity_error(load)`` and its parts; ``critical_velocity_p50``
        with tests; ``film_parameter_at_load`` and ``film_parameter_at_velocity``, those of the
        smooth bodies on the boundary, if the scene has an oil and a rough disk; the outcomes
        ``outcome_along_velocity(load)`` and ``outcome_along_load(velocity)``. Varied entries, and
        conditions given as lists, are further dimensions.

    Examples
    --------
    >>> import pipeline
    >>> boundary = pipeline.boundary("results/first_try.zarr", friction=[0.1, 0.12])
    >>> boundary["critical_velocity"].sel(load=400).round(2).values.tolist()
    [2.28, 1.68]
    """
    ds = dataset_of(ds, without_tests)
    overrides, cases = condition_arrays(conditions), cases_of(ds)
    for name in PLANE:
        if name not in ds["status"].dims and cases[0].is_row:
            raise InputError(
                f"each case has its own {name}, so there is no boundary; pipeline.margin (irg "
                "margin) judges each row"
            )
        if name not in ds["status"].dims:
            value = f"{ds[name].item():g}"
            raise InputError(
                f"{name} is a single value; select a list instead: ds.sel({name}=[{value}])"
            )
    answers = list[xr.Dataset]()
    for case in cases:
        case_overrides = arguments_of_case(overrides, case.labels)
        variables: dict[str, Any] = {"load": case.loads, "velocity": case.velocities}
        for dim, compute in (("load", _along_velocity), ("velocity", _along_load)):
            line = xr.DataArray(variables[dim], {dim: variables[dim]}, dim)
            models, computed = _evaluate(case, line, line, case_overrides, compute)
            variables |= {name: array.transpose(..., dim) for name, array in computed.items()}
        answers.append(answer_dataset(models, variables, case_overrides))
    return join_cases(ds, cases, answers)


def _along_velocity(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Limits by the verdict at the loads of points, critical velocities, and their errors."""
    columns = model.critical("velocity", points)
    critical = points._replace(velocity=columns["critical_velocity"])
    parts = model.velocity_errors(critical.load, critical.velocity)
    mild, severe = line_limits(model, "velocity", (MILD, SEVERE), points, None)
    return {
        "mild_velocity": mild.values,
        "mild_velocity_side": mild.sides,
        **columns,
        "critical_velocity_p50": model.velocity_of_probability(points),
        "severe_velocity": severe.values,
        "severe_velocity_side": severe.sides,
        "velocity_error": total(parts),
        **{f"velocity_error_{part}": error for part, error in zip(PARTS, parts, strict=True)},
        "ruled_out_by": model.evidence.texts_on_limits(points, mild.values, severe.values),
        **_film_parameters(model, "load", critical),
        **model.end_temperatures(critical),
    }


def _along_load(model: VerdictModel, points: QueryPoints) -> dict[str, Any]:
    """Critical loads at the velocities of points, and limits by the verdict."""
    columns = model.critical("load", points)
    mild, severe = line_limits(model, "load", (MILD, SEVERE), points, None)
    return {
        "mild_load": mild.values,
        "mild_load_side": mild.sides,
        **columns,
        "severe_load": severe.values,
        "severe_load_side": severe.sides,
        **_film_parameters(model, "velocity", points._replace(load=columns["critical_load"])),
    }


def _film_parameters(model: VerdictModel, dim: str, points: QueryPoints) -> dict[str, Any]:
    """Film parameters at points (k,) on the boundary; none without an oil or a roughness."""
    sweep = model.case.sweep
    oil = find_lubrication(sweep.scene, sweep.lubricant)
    if oil is None:
        return {}
    columns = zip(*(column.tolist() for column in points), strict=True)
    films = [oil.film_parameter(load, velocity, bulk) for load, velocity, _, bulk in columns]
    return {f"film_parameter_at_{dim}": np.array(films, float)}

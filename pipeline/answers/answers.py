"""The answers of a sweep as datasets: `boundary`, `margin`, `compare_tests` and `points`.

Everything that a command, a figure or a file states is a variable or an attribute of one of them.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable, Mapping
from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers import words
from pipeline.answers.conditions import (
    NAMES,
    ConditionValues,
    Operation,
    in_array,
    in_arrays,
    judged,
    replaced,
)
from pipeline.answers.error import PARTS, total
from pipeline.answers.field import Outcome
from pipeline.answers.results import CaseResults, case_dims, cases_of, dataset_of, sweep_of
from pipeline.answers.verdict import (
    ORIGINS,
    VERDICTS,
    Flag,
    JudgedCase,
    VerdictModel,
    passes_severe,
)
from pipeline.answers.warnings import warning_flags
from pipeline.constants import DECIDED
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.place import PathLike
from pipeline.store.schema import FAILED, PENDING, PLANE
from pipeline.sweep.conditions import Conditions
from pipeline.units import in_si
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array

_AT_ONCE = 4000  # operating points judged in one call, with some 100 MB of memory
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
    "critical_velocity_p50": ("m/s", "critical velocity with tests: severe wear is 50 % probable"),
    "critical_velocity_p05": ("m/s", "velocity at which severe wear is first 5 % probable"),
    "critical_velocity_p95": ("m/s", "velocity at which severe wear is last 95 % probable"),
    "velocity_error": ("1", "relative numerical error of the critical velocity (95 % bound)"),
    **{
        f"velocity_error_{part}": ("1", f"part of the relative numerical error: {name}")
        for part, name in _PART_NAMES.items()
    },
    "outcome_along_velocity": ("", "outcome along the line of rising velocity"),
    "outcome_along_load": ("", "outcome along the line of rising load"),
    "crossings_along_velocity": ("m/s", "velocity of each change between mild and severe wear"),
    "crossings_along_load": ("N", "load of each change between mild and severe wear"),
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
    "outcome_along_velocity": tuple(one.name.lower() for one in Outcome),
    "outcome_along_load": tuple(one.name.lower() for one in Outcome),
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
        parts, critical velocity, load and friction, and flags; each with ``units`` and
        ``long_name``, and codes with ``flag_meanings``. Attributes state what holds for all points.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.margin("results/first_try.zarr", "400 N", "1.5 m/s")
    >>> found["verdict"].attrs["flag_meanings"].split()[found["verdict"].item()]
    'mild'
    >>> found["governing_temperature"].round(1).item()
    391.7
    """
    ds = dataset_of(ds)
    if velocity is None and isinstance(load, _TABLES):
        points = load if isinstance(load, OperatingPoints) else OperatingPoints.read(load)
        return _rows(ds, points, conditions)
    if (load is None) != (velocity is None):
        raise InputError("give both a load and a velocity")
    places = {} if load is None else {
        "load": in_array("load", load, functools.partial(in_si, "load", like="500 N"), "place"),
        "velocity": in_array(
            "velocity", velocity, functools.partial(in_si, "velocity", like="2 m/s"), "place"
        ),
    }  # fmt: skip
    given = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        own = _of_case(given, case)
        asked = _of_case(places, case) or {
            name: xr.DataArray(_own_point(case, name)) for name in PLANE
        }
        try:
            arrays = xr.broadcast(*asked.values(), *own.values())
        except ValueError as error:
            raise InputError(
                f"load, velocity and conditions do not fit together: {error}"
            ) from None
        shape, flat = arrays[0], [one.values.ravel() for one in arrays]
        each = _each_conditions(case.conditions, [*own], flat[2:], shape.size)
        loads, velocities = (one.astype(float) for one in flat[:2])
        at = Operation(
            loads, velocities, *np.array([[c.friction, c.bulk_temperature] for c in each]).T
        )
        groups, models, whole = dict[Any, list[int]](), JudgedCase(case), dict[str, Any]()
        for k, c in enumerate(each):
            oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
            groups.setdefault(oil, []).append(k)
        for numbers in groups.values():
            model = models.under(each[numbers[0]])
            for begin in range(0, len(numbers), _AT_ONCE):
                part = np.array(numbers[begin : begin + _AT_ONCE])
                for name, one in _answers_at(model, at.take(part)).items():
                    whole.setdefault(name, np.empty(shape.size, one.dtype))[part] = one
        found = {name: (shape.dims, one.reshape(shape.shape)) for name, one in whole.items()}
        varied = {k: one for k, one in own.items() if one.ndim}
        described = _described(found, model, varied, shape.drop_attrs().coords)
        several = len(set(map(id, each))) > 1
        return described.assign_attrs({"conditions": words.OWN_CONDITIONS} if several else {})

    return _side_by_side(ds, answer)


def _of_case(given: Mapping[str, xr.DataArray], case: CaseResults) -> dict[str, xr.DataArray]:
    """Arguments for a case: where they vary with the entries that cases do, at its labels."""
    found = {**given}
    for name, one in given.items():
        labels = {dim: case.labels[str(dim)] for dim in one.dims if dim in case.labels}
        try:
            found[name] = one.sel(labels, drop=True) if labels else one
        except (IndexError, KeyError, TypeError):
            raise InputError(f"{name} has not all {min(map(str, labels))} of the sweep") from None
    return found


def _each_conditions(
    own: Conditions, names: list[str], columns: list[Array], count: int
) -> list[Conditions]:
    """Conditions of each point: those of a case, with some replaced; equal ones are one object."""
    if not names:
        return [own] * count
    held = dict[tuple[Any, ...], Conditions]()
    rows = zip(*(one.tolist() for one in columns), strict=True)
    return [
        held.get(row) or held.setdefault(row, replaced(own, dict(zip(names, row, strict=True))))
        for row in rows
    ]


def _rows(ds: xr.Dataset, points: OperatingPoints, conditions: Mapping[str, Any]) -> xr.Dataset:
    """Judge the rows of a table, each under its own conditions where it states some."""
    columns: dict[str, Any] = {"load": [load for load, _ in points.places]}
    columns["velocity"] = [velocity for _, velocity in points.places]
    for name in dict.fromkeys(name for row in points.conditions for name in row):
        cells = [row.get(name, conditions.get(name)) for row in points.conditions]
        columns[name] = xr.DataArray(np.array(cells, object), dims="place")
    found = margin(ds, **{**conditions, **columns})
    others = {f"{k} (given)" if k in found.variables else k: x for k, x in points.others.items()}
    return found.assign_coords({name: ("place", [*cells]) for name, cells in others.items()})


def _own_point(case: CaseResults, name: str) -> float:
    """The only load or velocity of a case."""
    values = case.loads if name == "load" else case.velocities
    if len(values) > 1:
        raise InputError("no operating point is given; give a load and a velocity")
    return float(values[0])


def _answers_at(model: VerdictModel, at: Operation) -> dict[str, Any]:
    """All variables of `margin` at k points."""
    for values, axis in ((at.load, "load"), (at.velocity, "velocity")):
        ends = model.ranges[axis]
        values[:] = [snap(value, *ends) for value in values.tolist()]
    found = model.points(at)
    known = ~np.isnan(found["log_rise_ratio"])
    for axis in ("velocity", "load"):
        found[f"critical_{axis}"] = np.full(known.shape, np.nan)
        found[f"outcome_along_{axis}"] = np.full(known.shape, int(Outcome.UNKNOWN), np.int8)
        if known.any():
            line = model.critical(axis, at.take(known))
            for name in (f"critical_{axis}", f"outcome_along_{axis}"):
                found[name][known] = line[name]
            if axis == "load":
                margins = found["temperature_margin"][known]
                passed = passes_severe(model, at.take(known), line, margins)
                found["warning_flags"][known] += (passed * Flag.RAMP_PASSES_SEVERE).astype(np.int16)
    found["critical_velocity_p50"] = np.full(known.shape, np.nan)
    if known.any() and model.evidence.specimens:
        found["critical_velocity_p50"][known] = model.velocity_of_probability(at.take(known))
    nearby = [
        ", ".join(model.evidence.nearby(*pair))
        for pair in zip(at.load.tolist(), at.velocity.tolist(), strict=True)
    ]
    return found | {"nearby_tests": np.array(nearby, object), **at._asdict()}


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
        with tests, NaN outside the velocities of the sweep; the outcomes
        ``outcome_along_velocity(load)`` and ``outcome_along_load(velocity)``, and all crossings.
        Varied entries, and conditions given as lists, are further dimensions.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.boundary("results/first_try.zarr", friction=[0.1, 0.12])
    >>> found["critical_velocity"].sel(load=400).round(2).values.tolist()
    [2.31, 1.68]
    """
    ds = dataset_of(ds)
    given = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        if not {*PLANE} <= {*ds["status"].dims}:
            raise InputError("each case has its own load and velocity, so there is no boundary")
        models = JudgedCase(case)
        own = _of_case(given, case)
        shape = xr.broadcast(*own.values())[0] if own else xr.DataArray(0)
        arrays = [one.broadcast_like(shape) for one in own.values()]
        rows = []
        for place in np.ndindex(shape.shape):
            values = {name: one.values[place] for name, one in zip(own, arrays, strict=True)}
            here = {name: xr.DataArray(one) for name, one in values.items() if own[name].ndim}
            rows.append(_boundary(models.under(replaced(case.conditions, values)), here))
        return _joined(rows, [shape[dim] for dim in shape.dims])

    return _side_by_side(ds, answer)


def _boundary(model: VerdictModel, varied: dict[str, xr.DataArray]) -> xr.Dataset:
    loads, velocities = model.field.loads, model.field.velocities
    found: dict[str, Any] = {}
    for axis, line, places in (("velocity", "load", loads), ("load", "velocity", velocities)):
        at = Operation.under(model.conditions, places, places)
        here = model.critical(axis, at)
        for name in (f"critical_{axis}", f"outcome_along_{axis}"):
            found[name] = (line, here[name])
        crossings = np.pad(here["crossings"], ((0, 0), (0, 8)), constant_values=np.nan)[:, :8]
        found[f"crossings_along_{axis}"] = ((line, "crossing"), crossings)
        if oil := find_lubrication(model.case.sweep.scene, model.case.sweep.lubricant):
            on = {line: places, axis: here[f"critical_{axis}"]}
            bulk = model.conditions.bulk_temperature
            film = oil.film_parameter(on["load"], on["velocity"], bulk)
            found[f"film_parameter_at_{line}"] = (line, film)
    parts = model.velocity_errors(loads, found["critical_velocity"][1])
    found["velocity_error"] = ("load", total(parts))
    for part, one in zip(PARTS, parts, strict=True):
        found[f"velocity_error_{part}"] = ("load", one)
    at = Operation.under(model.conditions, loads, loads)
    for probability in DECIDED:
        name = f"critical_velocity_p{100 * probability:02.0f}"
        found[name] = ("load", model.velocity_of_probability(at, probability))
    return _described(found | {"load": loads, "velocity": velocities}, model, varied, {})


def _described(
    variables: dict[str, Any], model: VerdictModel, varied: dict[str, xr.DataArray],
    coordinates: Mapping[Any, Any],
) -> xr.Dataset:  # fmt: skip
    """Dataset with units, long names and conditions; attributes say what holds for all of it."""
    axes = {**coordinates} | {name: variables.pop(name) for name in PLANE}
    own = {name: variables.pop(name, None) for name in ("friction", "bulk_temperature")}
    axes |= {name: getattr(model.conditions, name) for name in NAMES}
    for name, one in varied.items():
        axes[name] = one if name in one.dims or own.get(name) is None else own[name]
    return _with_attributes(xr.Dataset(variables, axes)).assign_attrs(words.about(model))


def _with_attributes(found: xr.Dataset) -> xr.Dataset:
    """The dataset with unit and long name of each variable, and the names of codes and flags."""
    for variable in found.variables:
        name = str(variable)
        unit, meaning = _VARIABLES.get(name, ("", ""))
        about: dict[str, Any] = {"units": unit} if unit else {}
        about |= {"long_name": meaning} if meaning else {}
        if codes := _CODES.get(name):
            about["flag_values"] = np.arange(len(codes), dtype=np.int8)
            about["flag_meanings"] = " ".join(codes)
        if name == "warning_flags":
            about["flag_masks"] = np.array([*map(int, Flag)], np.int16)
            about["flag_meanings"] = " ".join(str(one.name).lower() for one in Flag)
        found.variables[name].attrs.update(about)
    return found


def _side_by_side(ds: xr.Dataset, answer: Callable[[CaseResults], xr.Dataset]) -> xr.Dataset:
    """Join the answers for all cases of a sweep along the dimensions of its varied entries."""
    cases = cases_of(ds)
    missing = sum(case.missing for case in cases)
    dims = case_dims(ds)
    found = _joined([answer(case) for case in cases], [ds[dim] for dim in dims])
    labels = [
        one.name
        for one in sweep_of(ds).case_table.columns
        if one.along in dims and not one.entry and one.name not in found.coords
    ]
    found = found.assign_coords({name: ds[name].variable for name in labels})
    return found.assign_attrs(missing_points=missing)


def _joined(answers: list[xr.Dataset], axes: list[xr.DataArray]) -> xr.Dataset:
    """Join answers along `axes`; attributes that differ become coordinates."""
    alike = {k: v for k, v in answers[0].attrs.items() if all(v == one.attrs[k] for one in answers)}
    others = [name for name in answers[0].attrs if name not in alike]
    answers = [
        one.assign_coords({name: one.attrs[name] for name in others}).assign_attrs()
        for one in answers
    ]
    for axis in reversed(axes):
        parts = [one.drop_vars(str(axis.name), errors="ignore") for one in answers]
        answers = [
            xr.concat(
                parts[start : start + axis.size], axis, data_vars="all", coords="different",
                compat="equals", combine_attrs="drop_conflicts",
            )
            for start in range(0, len(parts), axis.size)
        ]  # fmt: skip
    found = answers[0]
    found.attrs = alike
    return found


def compare_tests(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Compare the tests of a scene with the model, each at its own conditions, along ``test``.

    ``log_rise_ratio_mild`` and ``log_rise_ratio_severe`` belong to the ends of a transition, and
    ``loo_probability`` is the probability of the outcome by the other tests. The attribute
    ``levels`` has the values of ln(rise ratio) at which severe wear is 5, 50 and 95 % probable.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.compare_tests("results/first_try.zarr")
    >>> found["load"].values.tolist(), found["log_rise_ratio"].round(2).values.tolist()
    ([750.0, 600.0, 400.0, 200.0], [0.03, -0.03, -0.11, -0.06])
    """
    case = cases_of(ds)[0]
    model = JudgedCase(case).under(judged(case.conditions, conditions))
    evidence = model.evidence
    pairs = zip(evidence.specimens, evidence.posterior.expected, strict=True)
    share = {id(row): one for rows, one in pairs for row in rows}
    columns: dict[str, list[Any]] = {}
    for row in evidence.rows:
        test, own = row.test, row.conditions
        for name, value in {
            "test": test.number, "outcome": test.outcome,
            "load": test.normal_load, "velocity": test.velocity,
            "friction": own.friction_at(test.velocity) if own else math.nan,
            "bulk_temperature": own.bulk_temperature if own else math.nan,
            "governing_temperature": row.temperature,
            "log_rise_ratio": row.mild if math.isnan(row.severe) else row.severe,
            "log_rise_ratio_mild": row.mild, "log_rise_ratio_severe": row.severe,
            "loo_probability": share.get(id(row), math.nan), "reason": row.reason,
        }.items():  # fmt: skip
            columns.setdefault(name, []).append(value)
    found = xr.Dataset({name: ("test", values) for name, values in columns.items()})
    found = found if columns else xr.Dataset(coords={"test": np.array([], object)})
    bulk = np.full(1, model.conditions.bulk_temperature)
    levels = [float(evidence.log_rise_ratio_quantiles(share, bulk)[0]) for share in DECIDED]
    return _with_attributes(found).assign_attrs(words.about(model), missing_points=0, levels=levels)


def points(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """State of each simulated point of a sweep's first case, on each surface realization.

    ``state`` is mild, severe, failed, pending, or empty where no run simulates the point;
    ``warned`` is true at points with a warning.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.points("results/first_try.zarr")["state"].sel(load=750)[0].values.tolist()
    ['mild', 'severe', 'severe', 'severe', 'severe', 'severe']
    """
    case = cases_of(ds)[0]
    own = judged(case.conditions, conditions)
    y = case.log_rises(own) + np.log(own.friction_factor(case.velocities))
    model = JudgedCase(case).under(own)
    failed, pending = (case.status == one for one in (FAILED, PENDING))
    kinds = case.done & (y > model.limit), case.done, failed, pending
    state = np.select(kinds, ("severe", "mild", "failed", "pending"), "")
    axes = {"load": case.loads, "velocity": case.velocities}
    dims = ("realization", *PLANE)
    found = xr.Dataset({"state": (dims, state), "warned": (dims, warning_flags(case) != 0)}, axes)
    return _with_attributes(found).assign_attrs(words.about(model), missing_points=case.missing)

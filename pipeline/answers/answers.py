"""The answers of a sweep as datasets: `boundary`, `margin` and `compare_tests`.

Everything that a command, a figure or a file states is a variable or an attribute of one of them.
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
)
from pipeline.constants import DECIDED
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.units import in_si
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication

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
    places = {
        name: in_array(name, one, functools.partial(in_si, name, like=like), "place")
        for name, one, like in (("load", load, "500 N"), ("velocity", velocity, "2 m/s"))
        if one is not None
    }
    given = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        own = _of_case(given, case)
        asked = _of_case(places, case) or _own_place(case)
        try:
            arrays = xr.broadcast(*asked.values(), *own.values())
        except ValueError as error:
            said = f"load, velocity and conditions do not fit together: {error}"
            raise InputError(said) from None
        shape = arrays[0]
        loads, velocities, *columns = (one.values.ravel() for one in arrays)
        rows = [*zip(*(one.tolist() for one in columns), strict=True)] or [()] * shape.size
        judged = {
            row: replaced(case.conditions, dict(zip(own, row, strict=True)))
            for row in dict.fromkeys(rows)
        }
        each = [judged[row] for row in rows]
        acting = np.array([[c.friction, c.bulk_temperature] for c in each])
        at = Operation(loads.astype(float), velocities.astype(float), *acting.T)
        groups = defaultdict[Any, list[int]](list)  # points of one oil
        for k, c in enumerate(each):
            oil = c.critical_temperature, c.added_rise_fraction, c.critical_area_fraction
            groups[oil].append(k)
        models, whole = JudgedCase(case), dict[str, Any]()
        for numbers in groups.values():
            model = models.under(each[numbers[0]])
            for part in np.array_split(numbers, -(-len(numbers) // _AT_ONCE)):
                for name, one in _answers_at(model, at.take(part)).items():
                    whole.setdefault(name, np.empty(shape.size, one.dtype))[part] = one
        found = {name: (shape.dims, one.reshape(shape.shape)) for name, one in whole.items()}
        varied = {k: one for k, one in own.items() if one.ndim}
        described = _described(found, model, varied, shape.drop_attrs().coords)
        differ = {"conditions": words.OWN_CONDITIONS} if len(judged) > 1 else {}
        return described.assign_attrs(differ)

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


def _own_place(case: CaseResults) -> dict[str, xr.DataArray]:
    """The only load and velocity of a case."""
    if max(len(case.loads), len(case.velocities)) > 1:
        raise InputError("no operating point is given; give a load and a velocity")
    return {"load": xr.DataArray(case.loads[0]), "velocity": xr.DataArray(case.velocities[0])}


def _rows(ds: xr.Dataset, points: OperatingPoints, conditions: Mapping[str, Any]) -> xr.Dataset:
    """Judge the rows of a table, each under its own conditions where it states some."""
    columns = dict[str, Any]()
    for name, cells in points.columns.items():
        own = [conditions.get(name) if cell is None else cell for cell in cells]
        columns[name] = xr.DataArray(np.array(own, object), dims="place")
    found = margin(ds, **{**conditions, **columns})
    labels = {f"{k} (given)" if k in found.variables else k: x for k, x in points.labels.items()}
    return found.assign_coords({name: ("place", [*cells]) for name, cells in labels.items()})


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
    found["critical_velocity_p50"] = np.full(known.shape, np.nan)
    if known.any():
        here = at.take(known)
        for axis in ("velocity", "load"):
            line = model.critical(axis, here)
            for name in (f"critical_{axis}", f"outcome_along_{axis}"):
                found[name][known] = line[name]
        # A load ramp passes through lower loads, at which wear may be severe.
        lowest = np.where(line["severe_at_start"], -math.inf, line["crossings"][:, 0])
        passed = (lowest < here.load) & (found["temperature_margin"][known] >= 0)
        found["warning_flags"][known] += (passed * Flag.RAMP_PASSES_SEVERE).astype(np.int16)
        if model.evidence.specimens:
            found["critical_velocity_p50"][known] = model.velocity_of_probability(here)
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
    return with_attributes(xr.Dataset(variables, axes)).assign_attrs(words.about(model))


def with_attributes(found: xr.Dataset) -> xr.Dataset:
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
    parts = [
        one.assign_coords({k: v for k, v in one.attrs.items() if k not in alike}) for one in answers
    ]
    for axis in reversed(axes):
        parts = [one.drop_vars(str(axis.name), errors="ignore") for one in parts]
        parts = [
            xr.concat(
                parts[start : start + axis.size], axis, data_vars="all", coords="different",
                compat="equals", combine_attrs="override",
            )
            for start in range(0, len(parts), axis.size)
        ]  # fmt: skip
    found = parts[0]
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
    return with_attributes(found).assign_attrs(words.about(model), missing_points=0, levels=levels)

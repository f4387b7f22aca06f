"""The answers of a sweep: `boundary`, `margin`, `tests` and `points`. Each is a dataset of xarray.

Everything that a command, a figure or a file states is a variable or an attribute of one of them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers import words
from pipeline.answers.conditions import ConditionValues, in_arrays, judged
from pipeline.answers.error import PARTS, total
from pipeline.answers.field import Outcome
from pipeline.answers.judge import Caveat, Judge, JudgedCase
from pipeline.answers.results import CaseResults, case_dims, cases_of, open_sweep, sweep_of
from pipeline.answers.warnings import warning_flags
from pipeline.constants import DECIDED
from pipeline.operating_points import OperatingPoints
from pipeline.quantities import snap
from pipeline.store.place import PathLike
from pipeline.store.schema import FAILED, PLANE
from pipeline.sweep.conditions import plain_values
from pipeline.units import in_si
from tribo import InputError
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array

_AT_ONCE = 4000  # places judged in one call, with some 100 MB of memory
_TABLES = (OperatingPoints, str, os.PathLike, Mapping, pd.DataFrame)
_STATED = {
    "verdict": ("", "verdict on a further run"),
    "probability": ("1", "probability that a further run is severe"),
    "probability_low": ("1", "this probability if the numerical error makes contacts colder"),
    "probability_high": ("1", "this probability if the numerical error makes contacts hotter"),
    "log_severity": ("1", "ln(rise/limit): computed wear is severe above 0"),
    "temperature": ("K", "contact temperature that is compared with the critical temperature"),
    "temperature_error": ("K", "numerical error of the temperature (95 %)"),
    "distance": ("K", "critical temperature minus temperature"),
    **{f"error_{part}": ("K", f"part of the numerical error: {part}") for part in PARTS},
    "critical_velocity": ("m/s", "lowest velocity at which computed wear turns severe"),
    "critical_load": ("N", "lowest load at which computed wear turns severe"),
    "critical_friction": ("1", "coefficient of friction at which computed wear turns severe"),
    "tested_velocity": ("m/s", "velocity at which severe wear is 50 % likely, with tests"),
    "tested_velocity_low": ("m/s", "velocity at which severe wear is first 5 % likely"),
    "tested_velocity_high": ("m/s", "velocity from which on severe wear is 95 % likely"),
    "velocity_error": ("1", "relative numerical error of the critical velocity (95 %)"),
    **{f"velocity_error_{part}": ("1", f"part of velocity_error: {part}") for part in PARTS},
    "velocity_outcome": ("", "what wear does along velocity, in words"),
    "load_outcome": ("", "what wear does along load, in words"),
    "caveats": ("", "what limits the answer"),
    "reason": ("", "why there is no verdict, in words"),
    "tests_beside": ("", "tests at or near the place, in words"),
    "friction": ("1", "coefficient of friction"),
    "bulk_temperature": ("K", "temperature of the bodies far from the contact"),
    "critical_temperature": ("K", "temperature above which the lubricant fails"),
    "failing_share": ("1", "wear is severe if more of the contact is above it"),
    "load": ("N", "normal load on the pin"),
    "velocity": ("m/s", "sliding velocity"),
}
"""Unit and meaning of each variable of an answer."""


@np.errstate(under="ignore")
def margin(
    ds: xr.Dataset | PathLike,
    load: Any = None,
    velocity: Any = None,
    **conditions: Unpack[ConditionValues],
) -> xr.Dataset:
    """Judge places of a sweep without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store.
    load, velocity : float, str, array or DataArray
        Loads on the whole pin [N] and sliding velocities [m/s], or text with a unit; they and
        conditions are broadcast against each other. Lists of equal length are pairs, along
        ``place``. Leave both out for a sweep whose rows have a place of their own. In place of
        both, a table with the columns ``load [N]`` and ``velocity [m/s]``: its path, or its columns
        by heading, such as a data frame. It may set conditions row by row; its other columns become
        coordinates.
    **conditions
        Conditions to judge by in place of the scene's: ``friction``, ``bulk_temperature``,
        ``critical_temperature`` and ``share``. A list makes a dimension.

    Returns
    -------
    Dataset
        The verdict on a further run, its probability, temperatures, numerical errors and their
        parts, critical velocity, load and friction, and `Caveat` flags; each with ``units`` and
        ``long_name``. Attributes state what holds for all places.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.margin("results/first_try.zarr", "400 N", "1.5 m/s")
    >>> found["verdict"].item()
    'mild'
    >>> bool(0.003 < found["probability"] < 0.004)
    True
    """
    ds = ds if isinstance(ds, xr.Dataset) else open_sweep(ds)
    if velocity is None and isinstance(load, _TABLES):
        points = load if isinstance(load, OperatingPoints) else OperatingPoints.read(load)
        return _rows(ds, points, conditions)
    if (load is None) != (velocity is None):
        raise InputError("load and velocity go together; give both")
    places = {} if load is None else {
        "load": _quantities("load", load, "500 N"),
        "velocity": _quantities("velocity", velocity, "2 m/s"),
    }  # fmt: skip
    given = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        asked = places or {name: xr.DataArray(_own_place(case, name)) for name in PLANE}
        arrays, own = xr.broadcast(*asked.values(), *given.values()), case.sweep.conditions
        shape, flat = arrays[0], [one.values.ravel() for one in arrays]
        groups, judges, whole = dict[Any, list[int]](), JudgedCase(case), dict[str, Any]()
        for k in range(shape.size):
            groups.setdefault(tuple(str(one[k]) for one in flat[2:]), []).append(k)
        for numbers in groups.values():
            values = (one[numbers[0]] for one in flat[2:])
            judge = judges.under(judged(own, dict(zip(given, values, strict=True))))
            for begin in range(0, len(numbers), _AT_ONCE):
                part = np.array(numbers[begin : begin + _AT_ONCE])
                at = [one[part].astype(float) for one in flat[:2]]
                for name, one in _answers_at(judge, *at).items():
                    whole.setdefault(name, np.empty(shape.size, one.dtype))[part] = one
        whole |= {name: one.astype(float) for name, one in zip(PLANE, flat, strict=False)}
        found = {
            name: shape.copy(data=one.reshape(shape.shape)).drop_attrs()
            for name, one in whole.items()
        }
        told = _told(found, judge, {name: one for name, one in given.items() if one.ndim})
        each = {"conditions": "its own conditions at each place"} if len(groups) > 1 else {}
        return told.assign_attrs(each)

    return _side_by_side(ds, answer)


def _rows(ds: xr.Dataset, points: OperatingPoints, conditions: Mapping[str, Any]) -> xr.Dataset:
    """Judge the rows of a table, each under its own conditions where it states some."""
    columns: dict[str, Any] = {"load": [load for load, _ in points.places]}
    columns["velocity"] = [velocity for _, velocity in points.places]
    stored = {} if case_dims(ds) else plain_values(sweep_of(ds).conditions)
    for name in dict.fromkeys(name for row in points.conditions for name in row):
        key = "share" if name == "failing_share" else name
        usual = conditions.get(key, stored.get(name))
        cells = [row.get(name, usual) for row in points.conditions]
        columns[key] = xr.DataArray(np.array(cells, object), dims="place")
    found = margin(ds, **{**conditions, **columns})
    others = {f"{k} (given)" if k in found.variables else k: x for k, x in points.others.items()}
    return found.assign_coords({name: ("place", [*cells]) for name, cells in others.items()})


def _own_place(case: CaseResults, name: str) -> float:
    """The only load or velocity of a case."""
    values = case.loads if name == "load" else case.velocities
    if len(values) > 1:
        raise InputError("no place is given, and rows of the sweep have none: give load, velocity")
    return float(values[0])


def _answers_at(judge: Judge, loads: Array, velocities: Array) -> dict[str, Any]:
    """All variables of `margin` at k places."""
    for values, axis in ((loads, "load"), (velocities, "velocity")):
        ends = judge.ranges[axis]
        values[:] = [snap(value, *ends) for value in values.tolist()]
    found = judge.places(loads, velocities)
    known = ~np.isnan(found["log_severity"])
    for axis, through in (("velocity", loads), ("load", velocities)):
        line = {
            f"critical_{axis}": np.full(len(loads), np.nan),
            "outcome_words": np.full(len(loads), "", object),
        }
        if known.any():
            there = judge.critical(axis, through[known])
            for name, one in line.items():
                one[known] = there[name]
            if axis == "load":  # a ramp passes lower loads
                lowest = np.where(there["begins_severe"], -np.inf, there["turns"][:, 0])
                passed = (lowest < loads[known]) & (found["distance"][known] >= 0)
                found["caveats"][known] += passed * Caveat.RAMP_PASSES_SEVERE
        found[f"critical_{axis}"] = line[f"critical_{axis}"]
        found[f"{axis}_outcome"] = line["outcome_words"]
    found["tested_velocity"] = np.full(len(loads), np.nan)
    if known.any() and judge.evidence.specimens:
        found["tested_velocity"][known] = judge.tested_velocity(loads[known])
    beside = [
        ", ".join(judge.evidence.beside(*pair))
        for pair in zip(loads.tolist(), velocities.tolist(), strict=True)
    ]
    found["tests_beside"] = np.array(beside, object)
    return found


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
        ``critical_velocity(load)`` and ``critical_load(velocity)``, computed, untouched by tests;
        ``velocity_error(load)`` and its parts; ``tested_velocity(load)`` with the ends of its band;
        the outcomes ``velocity_outcome(load)`` and ``load_outcome(velocity)``, and all ``turns``.
        Varied entries, and conditions given as lists, are further dimensions.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.boundary("results/first_try.zarr", friction=[0.1, 0.12])
    >>> found["critical_velocity"].sel(load=400).round(2).values.tolist()
    [2.31, 1.68]
    """
    ds = ds if isinstance(ds, xr.Dataset) else open_sweep(ds)
    given = in_arrays(conditions)

    def answer(case: CaseResults) -> xr.Dataset:
        if not {*PLANE} <= {*ds["status"].dims}:
            raise InputError("each row has its own load and velocity, so there is no boundary")
        judges = JudgedCase(case)
        shape = xr.broadcast(*given.values())[0] if given else xr.DataArray(0)
        arrays = [one.broadcast_like(shape) for one in given.values()]
        rows = []
        for place in np.ndindex(shape.shape):
            values = {name: one.values[place] for name, one in zip(given, arrays, strict=True)}
            here = {name: xr.DataArray(one) for name, one in values.items() if given[name].ndim}
            rows.append(_boundary(judges.under(judged(case.sweep.conditions, values)), here))
        return _joined(rows, [shape[dim] for dim in shape.dims])

    return _side_by_side(ds, answer)


def _boundary(judge: Judge, varied: dict[str, xr.DataArray]) -> xr.Dataset:
    loads, velocities = judge.field.loads, judge.field.velocities
    found: dict[str, Any] = {}
    for axis, line, places in (("velocity", "load", loads), ("load", "velocity", velocities)):
        here = judge.critical(axis, places)
        found[f"critical_{axis}"] = (line, here[f"critical_{axis}"])
        found[f"{axis}_outcome"] = (line, here["outcome_words"])
        found[f"{axis}_outcome_code"] = (line, here["outcome"])
        found[f"turns_at_{line}"] = (
            (line, "turn"),
            np.pad(here["turns"], ((0, 0), (0, 8)), constant_values=np.nan)[:, :8],
        )
        if oil := find_lubrication(judge.case.sweep.scene, judge.case.sweep.lubricant):
            at = {line: places, axis: here[f"critical_{axis}"]}
            bulk = judge.conditions.bulk_temperature
            film = oil.film_parameter(at["load"], at["velocity"], bulk)
            found[f"film_parameter_at_{line}"] = (line, film)
    critical = found["critical_velocity"][1]
    parts = judge.velocity_errors(loads, critical)
    found["velocity_error"] = ("load", total(parts))
    found |= {
        f"velocity_error_{part}": ("load", one) for part, one in zip(PARTS, parts, strict=True)
    }
    names = "tested_velocity_low", "tested_velocity", "tested_velocity_high"
    for name, share in zip(names, DECIDED, strict=True):
        found[name] = ("load", judge.tested_velocity(loads, share))
    return _told(found | {"load": loads, "velocity": velocities}, judge, varied)


def _told(variables: dict[str, Any], judge: Judge, varied: dict[str, xr.DataArray]) -> xr.Dataset:
    """Dataset with units, meanings and conditions; attributes say what holds for all of it."""
    axes = {name: variables.pop(name) for name in PLANE}
    found = xr.Dataset(variables, axes)
    for name, value in plain_values(judge.conditions).items():
        known = {"failing_share": "share"}.get(name, name)
        if known not in varied and name != "corrections":
            found = found.assign_coords({name: np.nan if value is None else value})
    found = found.assign_coords(varied)
    for variable in found.variables:
        name = str(variable)
        unit, meaning = _STATED.get(str(name), ("", ""))
        about = {"units": unit} if unit else {}
        found[name].attrs |= about | ({"long_name": meaning} if meaning else {})
    if "caveats" in found:
        flags = {"flag_masks": [int(one) for one in Caveat]}
        flags["flag_meanings"] = " ".join(str(one.name).lower() for one in Caveat)  # type: ignore[assignment]
        found["caveats"].attrs |= flags
    for name in ("velocity_outcome_code", "load_outcome_code"):
        if name in found:
            found[name].attrs |= {
                "flag_values": [int(one) for one in Outcome],
                "flag_meanings": " ".join(one.name.lower() for one in Outcome),
            }
    return found.assign_attrs(words.about(judge))


def _quantities(name: str, value: Any, example: str) -> xr.DataArray:
    """Loads or velocities in SI; a list has the dimension ``place``."""
    if isinstance(value, xr.DataArray):
        given, unit = value.attrs.get("units"), in_si(name, example, example)
        factor = in_si(name, f"1 {given}", example) if given else 1.0
        return (value * factor).drop_attrs() if unit else value
    if isinstance(value, list | tuple | np.ndarray):
        return xr.DataArray([in_si(name, one, example) for one in value], dims="place")
    return xr.DataArray(in_si(name, value, example))


def _side_by_side(ds: xr.Dataset, answer: Callable[[CaseResults], xr.Dataset]) -> xr.Dataset:
    """Join the answers for all cases of a sweep along the dimensions of its varied entries."""
    cases = cases_of(ds)
    missing = sum(case.missing for case in cases)
    axes = [ds[dim] for dim in case_dims(ds)]
    return _joined([answer(case) for case in cases], axes).assign_attrs(missing_points=missing)


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


def tests(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """The tests of a scene at their own conditions, along ``test``: what is computed there.

    ``log_severity`` is y = ln(rise/limit), ``mild`` and ``severe`` are those at the ends of a
    transition, and ``by_the_others`` is the probability of the outcome by the other tests. The
    attribute ``levels`` has the y at which a further run is severe by 5, 50 and 95 %.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.tests("results/first_try.zarr")
    >>> found["load"].values.tolist(), found["severe"].round(2).values.tolist()
    ([750.0, 600.0, 400.0, 200.0], [0.03, -0.03, -0.11, -0.06])
    """
    case = cases_of(ds)[0]
    judge = JudgedCase(case).under(judged(case.sweep.conditions, conditions))
    evidence = judge.evidence
    pairs = zip(evidence.specimens, evidence.posterior.expected, strict=True)
    share = {id(row): one for rows, one in pairs for row in rows}
    columns: dict[str, list[Any]] = {}
    for row in evidence.rows:
        test, own = row.test, row.conditions
        for name, value in {
            "test": test.number, "outcome": test.outcome or "transition",
            "load": test.normal_load, "velocity": test.velocity,
            "friction": own.friction_at(test.velocity) if own else math.nan,
            "bulk_temperature": own.bulk_temperature if own else math.nan,
            "temperature": row.temperature,
            "log_severity": row.mild if math.isnan(row.severe) else row.severe,
            "mild": row.mild, "severe": row.severe,
            "by_the_others": share.get(id(row), math.nan), "reason": row.reason,
        }.items():  # fmt: skip
            columns.setdefault(name, []).append(value)
    found = xr.Dataset({name: ("test", values) for name, values in columns.items()})
    found = found if columns else xr.Dataset(coords={"test": np.array([], object)})
    for name in map(str, found.data_vars):
        unit, meaning = _STATED.get(name, ("", ""))
        found[name].attrs = {"units": unit, "long_name": meaning}
    levels = [float(evidence.posterior.level(share)) for share in DECIDED]
    return found.assign_attrs(words.about(judge), missing_points=0, levels=levels)


def points(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """State of each computed point of a sweep's first case, on each patch.

    ``state`` is mild, severe, failed or pending, and ``warned`` true at points with a warning.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.points("results/first_try.zarr")["state"].sel(load=750)[0].values.tolist()
    ['mild', 'severe', 'severe', 'severe', 'severe', 'severe']
    """
    case = cases_of(ds)[0]
    own = judged(case.sweep.conditions, conditions)
    y = case.log_rises(own) + np.log(own.friction_factor(case.velocities))
    judge = JudgedCase(case).under(own)
    severe = y > judge.limit
    kinds = case.done & severe, case.done, case.status == FAILED
    state = np.select(kinds, ("severe", "mild", "failed"), "pending")
    axes = {"load": case.loads, "velocity": case.velocities}
    dims = ("realization", *PLANE)
    found = xr.Dataset({"state": (dims, state), "warned": (dims, warning_flags(case) != 0)}, axes)
    return found.assign_attrs(words.about(judge), missing_points=case.missing)

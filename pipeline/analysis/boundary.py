"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

It has two lines: where y = ln(rise/limit) is 0, as computed; and where severe wear is 50 % likely,
with tests. A data frame states both.
"""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.at import ConditionKeywords, asked_at
from pipeline.analysis.caveats import scene_caveats
from pipeline.analysis.dataset import Layout, entry_dims, require_kind
from pipeline.analysis.deciding import attributes_by
from pipeline.analysis.film import inside_alone, turns_inside
from pipeline.analysis.judge import Judge, judge_of
from pipeline.analysis.margin_frame import forbidding_words
from pipeline.analysis.outcomes import outcomes
from pipeline.analysis.reading import ResultsLike
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import SURFACE, totals, velocity_errors
from pipeline.analysis.scenes import heads_of, side_by_side
from pipeline.analysis.tables import frame_of
from pipeline.quantities import UNITS, column_heads
from pipeline.store.schema import COORDINATES, PLANE, attributes_of
from pipeline.sweep.conditions import FIELDS, Conditions
from pipeline.sweep.conditions import UNITS as CONDITION_UNITS
from pipeline.sweep.variants import dimension_of
from pipeline.words import join_notes
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array

JUDGED = column_heads(
    "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share", "criterion"
)
"""Column headings of the conditions that wear is judged by."""


WITH_TESTS = {
    "tested_velocity": "with tests [m/s]",
    "tested_velocity_low": "5 % [m/s]",
    "tested_velocity_high": "95 % [m/s]",
}
"""Column headings of the velocities at which severe wear is 50, 5 and 95 % likely."""
ERRORS = {"velocity_error": "error [%]", "surface_error": "by surface [%]"}
"""Column headings of the numerical error of critical velocities, and of its part by the surface."""


@np.errstate(under="ignore")
def boundary(ds: ResultsLike, **conditions: Unpack[ConditionKeywords]) -> xr.Dataset:
    """Find the critical velocity at each load, and the critical load at each velocity.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of the store. Points that
        are pending or failed are skipped.
    **conditions
        Conditions to judge by, as in `pipeline.at`, such as ``friction=0.12``.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the lowest value at
        which wear turns severe, computed, untouched by tests. NaN if wear never does so, is severe
        at the lowest computed value, or is not known. ``tested_velocity(load)`` [m/s] is where
        severe wear is 50 % likely, with tests; ``tested_velocity_low`` and ``tested_velocity_high``
        are the ends of its band: first 5 %, and last 95 %. ``velocity_error(load)`` is the relative
        numerical error of ``critical_velocity``, a bound at 95 %, and ``surface_error(load)`` the
        part of it that more patches would reduce.

        The names of further variables have the suffix ``_at_load`` or ``_at_velocity``:

        - ``outcome``: wear turns severe within the computed points, or why not. It may be mild or
          severe in the scene's whole range. It may turn severe above or below the computed points.
          Too few points may be done. Or wear is severe at some point and mild at a higher one.
        - ``words``: the outcome in words, with the ranges of severe wear if there are several.
        - ``turns(load, turn)``: all loads or velocities at which wear changes.
        - ``film_parameter`` at the critical velocity or load, if oil and roughness are known.

        Attributes are the conditions, with units in ``units_of_attributes``; ``model_error``, how
        far the model may be off, and by how many tests; ``caveats``, limits of the answer;
        ``misfits`` and ``waiting``, tests that do not fit, and that have no result; and
        ``missing_points``, the number of pending and failed points.

        Several surfaces are patches of one specimen, whose rise is the mean over them.

    Raises
    ------
    InputError
        If no critical temperature is known, or the sweep lists pairs of load and velocity.
    StoreError
        If the path is not a readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.boundary(ds)["critical_velocity"].round(2).to_series()
    load
    200.0    3.76
    400.0    2.31
    600.0    1.59
    750.0    1.25
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.boundary(ds, friction=0.09, bulk_temperature="40 degC")
    >>> warmer["critical_velocity"].sel(load=600).round(2).item()
    1.51
    """
    data = asked_at(ds, conditions)
    require_kind(data.kind, Layout.PLANE)
    axes = [data.rows[name] for name in data.entry_dims]
    found = side_by_side([_plane_boundary(scene) for scene in data.scenes], axes)
    turns = [found[name].notnull() for name in found if "turn" in found[name].dims]
    most = max(int(one.sum("turn").max()) for one in turns)
    found = found.isel(turn=slice(max(most, 1)))
    return found.assign_attrs(missing_points=data.missing)


def _plane_boundary(data: Results) -> xr.Dataset:
    """Critical velocities by load, and critical loads by velocity, of one scene on a grid."""
    data.require_lists(*PLANE)
    judge = judge_of(data)
    data, conditions = judge.source, judge.conditions
    result = xr.Dataset(
        coords={
            "load": axis_of("load", data.loads),
            "velocity": axis_of("velocity", data.velocities),
        },
        attrs=_condition_attributes(conditions),
    )
    for axis, line in (("velocity", "load"), ("load", "velocity")):
        result = result.assign(_transitions(judge, axis, line))
        if oil := find_lubrication(data.sweep.scene, data.sweep.lubricant):
            places = {line: result[line].values, axis: result[f"critical_{axis}"].values}
            bulk = conditions.mean_bulk_temperature
            film = oil.film_parameter(places["load"], places["velocity"], bulk)
            words = "film parameter at the crossing"
            result[f"film_parameter_at_{line}"] = _variable(line, film, "1", words)
    errors = velocity_errors(judge.rises, data.loads, result["critical_velocity"].values)
    whole, surface = "relative numerical error of the critical velocity", "its part by the surface"
    result["velocity_error"] = _variable("load", totals(errors), "1", whole)
    result["surface_error"] = _variable("load", errors[SURFACE], "1", surface)
    low, middle, high = (
        inside_alone(judge.rises, "velocity", data.loads, one)[0]
        for one in judge.tested_velocities(data.loads)
    )
    for name, values, words in (
        ("tested_velocity", middle, "velocity at which severe wear is 50 % likely, with tests"),
        ("tested_velocity_low", low, "velocity at which severe wear is first 5 % likely"),
        ("tested_velocity_high", high, "velocity from which on severe wear is 95 % likely"),
    ):
        result[name] = _variable("load", values, "m/s", words)
    return result.assign_attrs(
        model_error=judge.evidence.text,
        caveats=join_notes(scene_caveats(data, conditions)),
        misfits=join_notes(judge.evidence.misfits) or "",
        waiting=next(filter(None, forbidding_words(judge)), ""),
    )


def _variable(dims: Any, values: Any, units: str, words: str) -> xr.Variable:
    return xr.Variable(dims, values, {"units": units, "long_name": words})


def axis_of(name: str, values: Array) -> xr.Variable:
    """Values of the axis "load" [N] or "velocity" [m/s], as a variable of a dataset."""
    about = COORDINATES[name]
    return xr.Variable(about.dims, values, attributes_of(about))


def _condition_attributes(conditions: Conditions) -> dict[str, Any]:
    """Conditions as attributes of a dataset, with units."""
    attributes = attributes_by(conditions)
    units = [f"{name}: {unit}" for name, unit in CONDITION_UNITS.items() if name in attributes]
    return attributes | {"units_of_attributes": ", ".join(units)}


_TURNS = 64  # most changes of wear stored for a line; more are artefacts of interpolation


def _transitions(judge: Judge, axis: str, line: str) -> dict[str, Any]:
    """Variables of a boundary along `axis`, by name, at each value (`line`) of the other axis."""
    places = judge.rises.loads if line == "load" else judge.rises.velocities
    found = judge.rises.turns(axis, places)
    critical, texts = turns_inside(judge.rises, axis, places, found)
    noun, unit = "velocity" if axis == "velocity" else "normal load", UNITS[axis]
    turns = np.full((len(places), max(found.places.shape[1], _TURNS)), np.nan)
    turns[:, : found.places.shape[1]] = found.places
    meanings = {
        "long_name": "why there is no crossing",
        "flag_values": np.array(list(outcomes(axis)), dtype=np.int8),
        "flag_meanings": " ".join(word.replace(" ", "_") for word in outcomes(axis).values()),
    }
    return {
        f"critical_{axis}": _variable(
            line, critical, unit, f"{noun} at the transition to severe wear"
        ),
        f"words_at_{line}": _variable(line, texts, "1", "outcome in words"),
        f"turns_at_{line}": _variable(
            [line, "turn"], turns[:, :_TURNS], unit, f"{noun} at which wear turns"
        ),
        f"outcome_at_{line}": (line, found.outcome.astype(np.int8), meanings),
    }


def boundary_frame(boundaries: xr.Dataset, axis: str = "load") -> pd.DataFrame:
    """Data frame of a boundary, with a row for each scene and each value of `axis`.

    `axis` is "load" for critical velocities at each load, or "velocity" for critical loads at each
    velocity.
    """
    name = "critical_velocity" if axis == "load" else "critical_load"
    values = {column_heads(name)[name]: boundaries[name]}
    if axis == "load":
        values |= {head: boundaries[name] for name, head in ERRORS.items()}
        values |= {head: boundaries[name] for name, head in WITH_TESTS.items()}
    values["outcome"] = boundaries[f"words_at_{axis}"]
    if (film := f"film_parameter_at_{axis}") in boundaries:
        values["film parameter Λ"] = boundaries[film]
    rows = next(iter(values.values()))
    dims = [*entry_dims(rows), axis]
    crossings = xr.Dataset({head: data.drop_attrs() for head, data in values.items()})
    frame = crossings.to_dataframe(dims).reset_index()
    names = ["friction", *JUDGED, "caveats"]
    judged = [one for one in names if dimension_of(FIELDS.get(one, "")) not in dims]
    for one in judged:
        if one not in frame:
            frame[one] = boundaries.attrs.get(one)
    heads = heads_of(boundaries, dims[:-1]) | column_heads(axis) | JUDGED | {"caveats": "notes"}
    # Friction leads even if it is a single value.
    front = [*dims[:-1], *{"friction"}.intersection(judged), axis]
    names = [*dict.fromkeys([*front, *values, *judged])]
    found = frame[names].itertuples(index=False, name=None)
    return frame_of([heads.get(column, column) for column in names], found)

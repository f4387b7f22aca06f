"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Several surfaces give a band of quantiles. A surface without a transition counts as beyond all
computed points.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.caveats import scene_caveats
from pipeline.analysis.dataset import Layout, require_kind
from pipeline.analysis.decisive import attributes_by
from pipeline.analysis.field import PointField, places_of, point_field
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.margin import error_band
from pipeline.analysis.results import Results, ResultsLike, results
from pipeline.analysis.scenes import side_by_side
from pipeline.analysis.transition import ABOVE, BELOW, MILD, SEVERAL, SEVERE, Line, outcomes
from pipeline.quantities import UNITS
from pipeline.store.schema import COORDINATES, PLANE, attributes_of
from pipeline.sweep.conditions import UNITS as CONDITION_UNITS
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.remarks import join_notes
from pipeline.sweep.surface import find_lubrication
from tribo.types import Array


@np.errstate(under="ignore")
def boundary(ds: ResultsLike) -> xr.Dataset:
    """Find the critical velocity at each load, and the critical load at each velocity.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of the store. Points that
        are pending or failed are skipped.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the lowest value at
        which wear turns severe. NaN if wear never does so, is severe at the lowest computed value,
        or is not known. ``mild_below(load)`` and ``severe_above(load)`` [m/s] are the ends of the
        error band. Outside the band the verdict of `pipeline.margin` is decided.

        The names of further variables have the suffix ``_at_load`` or ``_at_velocity``:

        - ``outcome``: wear turns severe within the computed points, or why not. It may be mild or
          severe in the scene's whole range. It may turn severe above or below the computed points.
          Too few points may be done. Or wear is severe at some point and mild at a higher one.
        - ``words``: the outcome in words, with the ranges of severe wear if there are several.
        - ``turns(load, turn)``: all loads or velocities at which wear changes.
        - ``film_parameter`` at the critical velocity or load, if oil and roughness are known.

        Attributes are the conditions, with units in ``units_of_attributes``; ``model_error``, the
        size of the model's own error and its basis; ``caveats``, limits of the answer;
        and ``missing_points``, the number of pending and failed points.

        With several surfaces all variables except the error band have a first dimension
        ``realization``, and a variable is added (a similar one for ``critical_load``):

        - ``critical_velocity_quantile(quantile, load)``: velocity below which a share of the
          surfaces turn severe. A quantile among surfaces that are mild or severe at all velocities
          is NaN. The pin scuffs before the median velocity: the hottest patch under it scuffs
          first.

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
    200.0    3.75
    400.0    2.33
    600.0    1.58
    750.0    1.26
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.at(ds, friction=0.09, bulk_temperature="40 degC")
    >>> pipeline.boundary(warmer)["critical_velocity"].sel(load=600).round(2).item()
    1.5
    """
    data = results(ds)
    require_kind(data.kind, Layout.PLANE)
    axes = [data.rows[name] for name in data.entry_dims]
    found = side_by_side([_plane_boundary(scene) for scene in data.scenes], axes)
    turns = [found[name].notnull() for name in found if "turn" in found[name].dims]
    most = max(int(one.sum("turn").max()) for one in turns)
    found = found.isel(turn=slice(max(most, 1)))
    return found.assign_attrs(missing_points=data.missing)


def _plane_boundary(data: Results) -> xr.Dataset:
    """Critical velocities by load, and critical loads by velocity, of one scene.

    Returns the dataset that `boundary` describes. The points must be a grid of loads and
    velocities.
    """
    data.require_lists(*PLANE)
    found = point_field(data)
    data = found.source
    coords = {name: data.rows[name].variable for name in data.front} | {
        "load": axis_of("load", data.loads), "velocity": axis_of("velocity", data.velocities)
    }  # fmt: skip
    result = xr.Dataset(coords=coords, attrs=_condition_attributes(found.conditions))
    if data.front:
        shares = ("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
        result = result.assign_coords(quantile=shares)
    for axis, line in (("velocity", "load"), ("load", "velocity")):
        result = result.assign(_transitions(found, axis, line))
        if oil := find_lubrication(data.sweep):
            places = {line: result[line].values, axis: result[f"critical_{axis}"].values}
            bulk, dims = found.conditions.mean_bulk_temperature, result[f"critical_{axis}"].dims
            film = oil.film_parameter(places["load"], places["velocity"], bulk)
            words = "film parameter at the crossing"
            result[f"film_parameter_at_{line}"] = _variable(dims, film, "1", words)
    return _add_errors(result, found)


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


def _transitions(field: PointField, axis: str, line: str) -> dict[str, Any]:
    """Variables of a boundary that describe transitions along `axis`, by name.

    `axis` is "velocity" or "load". The variables have a value for each value of the other axis,
    `line`.
    """
    places, others = (field.loads, field.velocities[-1:]), field.loads
    if line == "velocity":
        places, others = (field.loads[-1:], field.velocities), field.velocities
    found = field.lines(axis, *places_of(*places))
    noun, unit = "velocity" if axis == "velocity" else "normal load", UNITS[axis]
    dims = [*field.source.front, line]
    shape = (len(field.planes),) * len(field.source.front) + others.shape
    room = np.full((*found.places.shape[:-1], _TURNS), math.nan)
    turns = np.append(found.places, room, axis=-1)[..., :_TURNS]
    columns: dict[str, tuple[Any, str, str]] = {
        f"critical_{axis}": (
            np.where(np.isfinite(found.first), found.first, math.nan), unit,
            f"{noun} at the transition to severe wear",
        ),
        f"words_at_{line}": (found.texts(axis), "1", "outcome in words"),
    }  # fmt: skip
    result: dict[str, Any] = {
        name: _variable(dims, values.reshape(shape), units, words)
        for name, (values, units, words) in columns.items()
    }
    result[f"turns_at_{line}"] = _variable(
        [*dims, "turn"], np.sort(turns).reshape(*shape, -1), unit, f"{noun} at which wear turns"
    )
    meanings = {
        "long_name": "why there is no crossing",
        "flag_values": np.array(list(outcomes(axis)), dtype=np.int8),
        "flag_meanings": " ".join(word.replace(" ", "_") for word in outcomes(axis).values()),
    }
    codes = found.outcome.reshape(shape)
    result[f"outcome_at_{line}"] = dims, codes.astype(np.int8), meanings
    if field.source.front:
        result[f"critical_{axis}_quantile"] = _variable(
            ["quantile", line], _quantiles(found), unit, "that a share of the surfaces stays below"
        )
    return result


_STEPS = 241  # velocities, and most points beside, at which the ends of the error band are sought
_BEYOND = 3.0  # the band is sought up to this factor beyond the computed velocities
_BESIDE = (1 - 1e-6, 1 + 1e-6)  # both sides of a point: the numerical error is smaller at it


def _add_errors(boundaries: xr.Dataset, field: PointField) -> xr.Dataset:
    """Add the error band to `boundaries`, and return a copy with attributes on errors and caveats.

    The error band is the range of velocities [m/s] in which the verdict is not decided. The
    variables ``mild_below`` and ``severe_above`` have its lower and upper end at each load, found
    from `field`. They are added to `boundaries` itself, the attributes only to the copy:
    ``model_error`` and ``caveats``.
    """
    data, loads = field.source, field.source.loads
    scatter, velocities = model_error(data, field), data.velocities
    bands = np.full((len(loads), 2), math.nan)
    if velocities.max() > 0:
        grid = np.geomspace(velocities.min() / _BEYOND, velocities.max() * _BEYOND, _STEPS)
        beside = np.multiply.outer(_BESIDE, velocities[:: 1 + len(velocities) // _STEPS])
        bands = error_band(field, loads, np.union1d(grid, beside), scatter)
    for name, ends, words in (
        ("mild_below", bands[:, 0], "below this velocity the next run is mild"),
        ("severe_above", bands[:, 1], "above this velocity the next run is severe"),
    ):
        boundaries[name] = _variable("load", ends, "m/s", words)
    notes = join_notes(scene_caveats(data, field.conditions))
    return boundaries.assign_attrs(model_error=scatter.text, caveats=notes)


BAND = (0.1, 0.5, 0.9)
"""Quantiles of the band over surfaces: lower end, median and upper end."""


@np.errstate(invalid="ignore")
def _quantiles(line: Line) -> Array:
    """Quantiles, over surfaces, of the critical velocity [m/s] or critical load [N].

    Returns an array (3, k) of the three quantiles in `BAND`. `line` has a curve for each of m
    surfaces and k loads or velocities. Quantiles are interpolated between ranked surfaces. They are
    NaN next to a surface whose critical value is infinite, or outside the computed points. Surfaces
    with an unknown outcome are left out.
    """
    begin, end = line.computed
    is_kind = [np.isfinite(line.first), *(line.outcome == kind for kind in (MILD, SEVERE, ABOVE))]
    # If wear is severe at the lowest computed place, it turns severe somewhere below.
    is_kind.append(np.isin(line.outcome, (BELOW, SEVERAL)))
    least = np.select(is_kind, [line.first, np.inf, -np.inf, end, -np.inf], math.nan)
    most = np.select(is_kind, [line.first, np.inf, -np.inf, np.inf, begin], math.nan)
    rank = np.multiply.outer(BAND, np.maximum((~np.isnan(least)).sum(axis=0) - 1, 0))
    ranks = np.stack([np.floor(rank), np.ceil(rank)]).astype(int)
    low, high = (np.sort(ends, axis=0)[ranks, np.arange(rank.shape[1])] for ends in (least, most))
    found = low[0] + (rank - ranks[0]) * (low[1] - low[0])
    return np.where((np.isfinite(low) & (low == high)).all(axis=0), found, math.nan)

"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Over several surfaces it has a band. Quantiles count a surface without a transition beyond all that
was computed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import Kind, require_kind
from pipeline.analysis.decisive import attributes_by
from pipeline.analysis.field import Field, PointField, fields, point_field
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.margin import DECIDED, error_band
from pipeline.analysis.results import Results, results
from pipeline.analysis.scenes import side_by_side
from pipeline.analysis.transition import (
    ABOVE,
    BELOW,
    CROSSES,
    MILD,
    SEVERAL,
    SEVERE,
    Line,
    outcomes,
)
from pipeline.quantities import UNITS
from pipeline.store.place import PathLike
from pipeline.store.schema import COORDINATES, PLANE, attributes_of
from pipeline.sweep.caveats import caveats, joined
from pipeline.sweep.conditions import FIELDS, Conditions
from pipeline.sweep.conditions import UNITS as CONDITION_UNITS
from pipeline.sweep.physics import cold_bodies, describe_cold_bodies, turn_parts
from pipeline.sweep.surface import find_lubrication
from tribo import Corrections
from tribo.types import Array


@np.errstate(under="ignore")
def boundary(ds: xr.Dataset | PathLike | Results) -> xr.Dataset:
    """Critical velocity for each load and critical load for each velocity.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or folder or address of the store. Points
        that are pending or failed are skipped.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the first place at
        which wear turns severe. NaN where the computed points do not cross, or where wear is severe
        at the lowest.
        ``mild_below(load)`` and ``severe_above(load)`` [m/s] are the ends of the band that the
        errors leave: below and above it the verdict of `pipeline.margin` is decided.

        These have the suffix ``_at_load`` or ``_at_velocity``:

        - ``outcome``: crosses, or why not. Mild or severe throughout: the outermost points of the
          scene's range are done and say so. Otherwise the crossing lies above or below what was
          computed, or is not known for want of points. Or wear is severe at some and mild at a
          higher one.
        - ``turns(load, turn)``: all places at which wear turns; the first turns to mild wear where
          ``begins_severe``.
        - ``computed_from``, ``computed_to``: ends of what was computed [m/s, N].
        - ``film_parameter`` at the crossing, if the scene gives an oil.
        - ``rise_exponent`` (at loads alone): d ln(rise) over d ln(velocity) at the crossing.

        Attributes are the conditions, with units in ``units_of_attributes``; ``model_error``, what
        the model's own error rests on; ``caveats``, what a reader must know; ``missing_points``,
        the number of points that are pending or failed; and ``misfit``, why the tests contradict
        the model, where they do.

        Over several surfaces all but the band have a dimension ``realization`` in front, and these
        are added, likewise for ``critical_load``:

        - ``critical_velocity_quantile(quantile, load)``: velocity below which a share of the
          surfaces turn severe. Surfaces that are mild or severe throughout count beyond all
          velocities, so a quantile among them is NaN. The median is not the onset: the hottest
          patch under the pin scuffs first.
        - ``crossing_at_load``: number of surfaces that cross; ``known_at_load``: number of those
          known to cross or not.

        For samples there are only the band and ``critical_velocity_quantile``, the first velocities
        at which the next run is severe with a probability of 5, 50 and 95 %.

    Raises
    ------
    InputError
        If no critical temperature is known.
    StoreError
        If the path is not a readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.boundary(ds)["critical_velocity"].round(2).to_series()
    load
    200.0    3.74
    400.0    2.33
    600.0    1.58
    750.0    1.26
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.at(ds, friction=0.09, bulk_temperature="40 degC")
    >>> pipeline.boundary(warmer)["critical_velocity"].sel(load=600).round(2).item()
    1.5
    """
    held = results(ds)
    require_kind(held.kind, Kind.PLANE, Kind.SAMPLES)
    answer = _band_alone if held.kind is Kind.SAMPLES else boundary_under
    axes = [held.rows[name] for name in held.entry_dims]
    found = side_by_side([answer(scene) for scene in held.scenes], axes)
    if held.kind is Kind.PLANE:
        turns = [found[name].notnull() for name in found if "turn" in found[name].dims]
        most = max(int(one.sum("turn").max()) for one in turns)
        found = found.isel(turn=slice(max(most, 1)))
    return found.assign_attrs(missing_points=held.missing)


def boundary_under(ds: xr.Dataset | Results, conditions: Conditions | None = None) -> xr.Dataset:
    """The boundary of one scene, under given conditions or its own."""
    held = results(ds)
    held.require_lists(*PLANE)
    found = point_field(held, conditions)
    held = found.source
    coords = {name: held.rows[name].variable for name in held.front} | {
        "load": axis_of("load", held.loads), "velocity": axis_of("velocity", held.velocities)
    }  # fmt: skip
    result = xr.Dataset(coords=coords, attrs=_condition_attributes(found.conditions))
    for axis, line in (("velocity", "load"), ("load", "velocity")):
        result = result.assign(_transitions(found, axis, line))
    if oil := find_lubrication(held.sweep):
        for axis, line in (("velocity", "load"), ("load", "velocity")):
            places = {line: result[line].values, axis: result[f"critical_{axis}"].values}
            film = oil.film_parameter(
                places["load"], places["velocity"], found.conditions.mean_bulk_temperature
            )
            dims = result[f"critical_{axis}"].dims
            words = "film parameter at the crossing"
            result[f"film_parameter_at_{line}"] = dims, film, {"units": "1", "long_name": words}
    if "realization" in result.dims:
        result = add_band(result)
    return _add_errors(result, found)


def axis_of(name: str, values: Array) -> xr.Variable:
    """Loads [N] or velocities [m/s] as a dataset has them."""
    about = COORDINATES[name]
    return xr.Variable(about.dims, values, attributes_of(about))


def _condition_attributes(conditions: Conditions, sampled: Collection[str] = ()) -> dict[str, Any]:
    """Conditions as attributes, with their units, but for those of sampled entries."""
    attributes = {
        name: value
        for name, value in attributes_by(conditions).items()
        if FIELDS.get(name) not in sampled
    }
    units = [f"{name}: {unit}" for name, unit in CONDITION_UNITS.items() if name in attributes]
    return attributes | {"units_of_attributes": ", ".join(units)}


_TURNS = 64  # turns of a line that are told; more are waves between points


def _transitions(field: PointField, axis: str, line: str) -> dict[str, Any]:
    """Transitions along the velocity at each load, or along the load at each velocity."""
    plane, by_load = field.planes[0], line == "load"
    others = plane.loads if by_load else plane.velocities
    here = np.full(others.shape, (plane.velocities if by_load else plane.loads)[-1])
    members = field.lines(axis, *((others, here) if by_load else (here, others)))
    noun, unit = "velocity" if axis == "velocity" else "normal load", UNITS[axis]
    dims = [*field.source.front, line]
    shape = *(field.source.rows.sizes[name] for name in field.source.front), len(others)

    def each(take: Callable[[Line], Any]) -> Any:
        return np.array([take(member) for member in members])

    first = each(lambda one: one.first)
    critical = np.where(np.isfinite(first), first, math.nan)
    columns: dict[str, tuple[Any, str, str]] = {
        f"critical_{axis}": (
            critical, unit, f"{noun} at the transition to severe wear"
        ),
        f"computed_from_at_{line}": (
            each(lambda one: one.computed[0]), unit, f"{axis} computed from at this {line}"
        ),
        f"computed_to_at_{line}": (
            each(lambda one: one.computed[1]), unit, f"{axis} computed to at this {line}"
        ),
        f"begins_severe_at_{line}": (
            each(lambda one: one.begins_severe), "1", f"wear is severe at the lowest {axis} known"
        ),
    }  # fmt: skip
    result: dict[str, Any] = {
        name: (dims, values.reshape(shape), {"units": units, "long_name": words})
        for name, (values, units, words) in columns.items()
    }
    padded = each(lambda one: _padded(one.places))
    attrs = {"units": unit, "long_name": f"{noun} at which wear turns"}
    result[f"turns_at_{line}"] = [*dims, "turn"], padded.reshape(*shape, _TURNS), attrs
    if axis == "velocity":
        slopes = each(lambda one: one.curve.exponent(one.first)).reshape(shape)
        attrs = {"units": "1", "long_name": "d ln(rise) / d ln(velocity) at the crossing"}
        result["rise_exponent_at_load"] = dims, slopes, attrs
    meanings = {
        "long_name": "why there is no crossing",
        "flag_values": np.array(list(outcomes(axis)), dtype=np.int8),
        "flag_meanings": " ".join(word.replace(" ", "_") for word in outcomes(axis).values()),
    }
    codes = each(lambda one: one.outcome).reshape(shape)
    result[f"outcome_at_{line}"] = dims, codes.astype(np.int8), meanings
    return result


def _padded(places: Array) -> Array:
    """Turns by line, of which the first ones are kept, and NaN behind them."""
    room = np.full((len(places), _TURNS), math.nan)
    return np.sort(np.append(places, room, axis=1), axis=1)[:, :_TURNS]


_STEPS = 241  # velocities among which the ends of a band are sought
_BEYOND = 3.0  # factor beyond the velocities computed to which they are
_BESIDE = (1 - 1e-6, 1 + 1e-6)  # sides of a point, at which the numerical error may jump


def _add_errors(boundaries: xr.Dataset, field: Field) -> xr.Dataset:
    """Add the ends of the band that the errors leave, by load."""
    held, loads = field.source, field.source.loads
    scatter, velocities = model_error(held, field), held.velocities
    bands = np.full((len(loads), 2), math.nan)
    if velocities.max() > 0:
        grid = np.geomspace(velocities.min() / _BEYOND, velocities.max() * _BEYOND, _STEPS)
        grid = np.union1d(grid, np.multiply.outer(_BESIDE, velocities))
        bands = error_band(field, loads, grid, scatter)
    for name, ends, words in (
        ("mild_below", bands[:, 0], "below this velocity the next run is mild"),
        ("severe_above", bands[:, 1], "above this velocity the next run is severe"),
    ):
        boundaries[name] = "load", ends, {"units": "m/s", "long_name": words}
    misfit = {"misfit": field.misfit} if field.misfit else {}
    notes = joined(caveats(held.sweep, field.conditions, field.counts_inputs))
    return boundaries.assign_attrs(model_error=scatter.worded, caveats=notes, **misfit)


def _band_alone(scene: Results) -> xr.Dataset:
    """The boundary of samples, by the probability of severe wear."""
    (field,) = fields(scene)
    loads = scene.loads
    low, high = (float(end) for end in field.ends["velocity"])
    grid = np.geomspace(low, high, _STEPS)
    scatter = model_error(scene, field)
    rows = field.probability(loads[:, None], grid, scatter)
    lines = [np.interp(DECIDED, np.maximum.accumulate(row), grid, 0.0, math.inf) for row in rows]
    result = xr.Dataset(
        coords={"load": axis_of("load", loads), "quantile": ("quantile", list(DECIDED))},
        attrs=_condition_attributes(field.conditions, scene.sweep.variants.rule.unknown),
    )
    words = "velocity at which the next run is severe with a probability"
    attrs = {"units": "m/s", "long_name": words}
    result["critical_velocity_quantile"] = ("quantile", "load"), np.transpose(lines), attrs
    return _add_errors(result, field)


BAND = (0.1, 0.5, 0.9)
"""Shares of the surfaces whose transition lies lower: lower end, middle and upper end."""


def add_band(boundaries: xr.Dataset) -> xr.Dataset:
    """Add quantiles over several surfaces, and counts of the surfaces."""
    shares = ("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
    with_quantiles = boundaries.assign_coords(quantile=shares)
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        outcome, unit = boundaries[f"outcome_at_{axis}"], boundaries[name].attrs["units"]
        quantiles = xr.apply_ufunc(
            _band_of,
            boundaries[name],
            outcome,
            boundaries[f"computed_from_at_{axis}"],
            boundaries[f"computed_to_at_{axis}"],
            input_core_dims=[["realization"]] * 4,
            output_core_dims=[["quantile"]],
            vectorize=True,
        )
        crossing = (outcome == CROSSES).sum("realization")
        certain = outcome.isin((CROSSES, MILD, SEVERE, SEVERAL)).sum("realization")
        quantiles = quantiles.transpose(..., "quantile", axis)
        columns = {
            f"{name}_quantile": (quantiles, unit, "that a share of the surfaces stays below"),
            f"crossing_at_{axis}": (crossing, "1", "surfaces that cross"),
            f"known_at_{axis}": (certain, "1", "surfaces whose outcome is known"),
        }
        for column, (values, units, words) in columns.items():
            attrs = {"units": units, "long_name": words}
            with_quantiles[column] = values.dims, values.values, attrs
    return with_quantiles


def _band_of(places: Array, outcomes: Array, first: Array, last: Array) -> Array:
    """Quantiles of the transitions of several surfaces along one line."""
    low, high = _ends(places, outcomes, first, last)
    return np.array([quantile(low, high, share) for share in BAND])


def _ends(places: Array, outcomes: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Least and greatest place of each transition that has any."""
    is_kind = [np.isfinite(places), *(outcomes == kind for kind in (MILD, SEVERE, ABOVE))]
    # Wear that is severe at the lowest place computed turns severe below it.
    is_kind.append(np.isin(outcomes, (BELOW, SEVERAL)))
    low = np.select(is_kind, [places, np.inf, -np.inf, last, -np.inf], math.nan)
    high = np.select(is_kind, [places, np.inf, -np.inf, np.inf, first], math.nan)
    is_known = ~np.isnan(low)
    return (low[is_known], high[is_known]) if is_known.any() else (np.array([math.nan]),) * 2


def quantile(low: Array, high: Array, share: float) -> float:
    """Quantile of values from `low` to `high`, linear between ranks; NaN if it is not known."""
    place = share * (len(low) - 1)
    below, above = math.floor(place), math.ceil(place)
    ranked, greatest = np.sort(low), np.sort(high)
    ends = ranked[[below, above]]
    if not np.isfinite(ends).all() or (ends != greatest[[below, above]]).any():
        return math.nan
    return float(ends[0] + (place - below) * (ends[1] - ends[0]))


def turns_left_out(ds: xr.Dataset | Results, crossings: xr.Dataset) -> str | None:
    """Say that bodies roll as if each turn met a cold track; None where none does."""
    held = results(ds)
    scene = held.sweep.scene
    if held.entry_dims or not scene.motion:
        return None
    judged = held.conditions
    cold = cold_bodies(scene.motion, judged.corrections)
    if not cold:
        return None
    turns, around = turn_parts(scene, cold)
    corrections = replace(judged.corrections or Corrections(), **turns)
    warm = boundary_under(held, replace(judged, corrections=corrections))
    moved = 100 * (warm["critical_velocity"] / crossings["critical_velocity"] - 1).values
    moved = moved[np.isfinite(moved)]
    size = "move the boundary to lower velocities, by more than is computed here"
    if moved.size:
        size = f"move the critical velocities by {moved.max():+.0f} to {moved.min():+.0f} %"
    return describe_cold_bodies(cold, around, size)

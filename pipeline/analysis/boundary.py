"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Over several surfaces it has a band. Quantiles count a surface without a transition beyond all that
was computed; a mean, which this would bias, is given only if every surface has one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import asked, dataset_of, require_plane, stored_sweep, variant_of
from pipeline.analysis.decisive import Bulk, attributes_by, conditions_of, decisive_rise
from pipeline.analysis.scenes import by_scene, scenes, stacked
from pipeline.analysis.transition import (
    ABOVE,
    BELOW,
    CROSSES,
    MILD,
    SEVERE,
    UNITS,
    Crossing,
    along_friction,
    exponent,
    outcomes,
    range_of,
    spread,
)
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import rise_limit
from pipeline.sweep.surface import Lubrication
from tribo import InputError
from tribo.types import Array, Mask


def boundary(
    ds: xr.Dataset | PathLike,
    friction: float | Sequence[float] | Array | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
) -> xr.Dataset:
    """Critical velocity for each load and critical load for each velocity.

    Over several random surfaces there is a boundary for each of them, and the band of them all.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store. Points that are pending
        or failed are skipped.
    friction : float or several, optional
        Coefficient of friction, at least 0. A condition that is not given is the sweep's own.
        Several give a dimension ``friction``.
    bulk_temperature, critical_temperature : float, str or mapping, optional
        Temperature far from the contact, and the one above which the lubricant fails [K]; or text
        with a unit, such as ``"80 degC"``. In a sweep of bodies of unequal bulk temperatures, such
        as ``{"pin": "60 degC", "disk": "25 degC"}`` for both.
    share : float or str, optional
        Wear is severe where more than this share of the contact area is hotter than the critical
        temperature, such as 0.1 or ``"10%"``; 0 is Blok's criterion, the maximum temperature.
    criterion : str, optional
        Temperature that decides: ``"share"``, which that share exceeds, ``"highest"`` or
        ``"mean"``; see `tribo.CRITERIA`. Or your own, such as ``"laws:hottest"``.
    own_laws : bool
        Allow your own criterion to run, which is code of a file in the working folder.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the first crossing
        from mild to severe wear, NaN where the computed points do not cross. With each, by the
        suffix ``_at_load`` or ``_at_velocity``: ``outcome``, which gives the reason (mild or severe
        throughout, where the outermost points of the scene's own range are done and say so; above
        or below what was computed; not known for want of points); ``computed_from`` and
        ``computed_to``, the ends of what was computed [m/s, N]; ``missing``, the points that are
        pending or failed, and ``bridged``, those of them that a crossing is interpolated across;
        ``film_parameter``, where the scene gives an oil. ``rise_exponent_at_load`` is d ln(rise)
        over d ln(velocity) at the crossing: an error of the rise, divided by it, is that of the
        critical velocity. The conditions are attributes, whose units are in
        ``units_of_attributes``, and ``missing_points`` is the total of those that are missing.

        Over several surfaces all have a dimension ``realization`` in front, and there are also
        ``critical_velocity_quantile(quantile, load)``, the velocity below which 10, 50 and 90 %
        of the surfaces turn severe: those that stay mild or are severe throughout are counted,
        beyond all velocities, so that a quantile among them is NaN. ``critical_velocity_mean``
        and ``critical_velocity_spread`` (standard deviation) are NaN unless every surface
        crosses. ``crossing_at_load`` counts those that do, ``known_at_load`` those that are known
        to cross or not. Likewise for ``critical_load``.

    Raises
    ------
    InputError
        If a condition lies outside its range; if neither the sweep nor the call gives a critical
        temperature; or if the sweep has samples of unknown inputs.
    StoreError
        If the path is not a readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.boundary(ds)["critical_velocity"].round(2).to_series()
    load
    200.0    3.53
    400.0    2.23
    600.0    1.56
    750.0    1.24
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.boundary(ds, friction=0.09, bulk_temperature="40 degC")
    >>> warmer["critical_velocity"].sel(load=600).round(2).item()
    1.48
    """
    given: Any = friction
    several = list[float | None](np.ravel(given).tolist())
    if isinstance(friction, str) or not several:
        raise InputError(f"friction is {friction!r}; give a number such as 0.1, or several")
    ds = dataset_of(ds)
    require_plane(ds)
    others = (bulk_temperature, critical_temperature, share, criterion, own_laws)

    def of_scene(scene: xr.Dataset) -> xr.Dataset:
        judged = [conditions_of(scene, value, *others) for value in several]
        axis = xr.DataArray(
            [conditions.friction for conditions in judged],
            dims="friction",
            name="friction",
            attrs={"units": "1", "long_name": "friction coefficient"},
        )
        frictions = [axis] if np.ndim(given) else []
        return stacked([_judged(scene, one) for one in judged], frictions)

    return _boundaries(next(scenes(ds)), by_scene(ds, of_scene))


def boundary_under(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """The boundary of one scene under some conditions, with a band over several surfaces."""
    return _boundaries(ds, _judged(ds, conditions))


def _judged(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """What the boundary of one scene follows from: rises, their limit, and the oil."""
    rise = decisive_rise(ds, conditions)
    is_missing = rise.isnull() & asked(ds)
    oil = np.array(None, dtype=object)
    oil[()] = Lubrication.of(stored_sweep(ds))
    friction = np.array(None, dtype=object)
    friction[()] = conditions.friction_factor if conditions.has_friction_curve else None
    parts = {  # underscored, since a dimension may have any other name
        "_rise": rise,
        "_is_missing": is_missing,
        "_limit": rise_limit(conditions),
        "_friction": ((), friction),
        "_oil": ((), oil),
        "_temperature": conditions.mean_bulk_temperature,
    }
    judged = xr.Dataset(parts, attrs=attributes_by(conditions))
    judged.attrs["missing_points"] = int(is_missing.sum())
    return judged


def _boundaries(ds: xr.Dataset, judged: xr.Dataset) -> xr.Dataset:
    """The boundary of scenes, of which one gives the range, from what all are judged by."""
    units = [f"{name}: {unit}" for name, unit in _UNITS.items() if name in judged.attrs]
    attributes = judged.attrs | {"units_of_attributes": ", ".join(units)}
    boundaries = xr.Dataset(coords=judged["_rise"].coords, attrs=attributes)
    for axis, line in (("velocity", "load"), ("load", "velocity")):
        boundaries = boundaries.assign(_transitions(axis, ds, judged))
        if judged["_oil"].notnull().any():
            film = _film(line, judged, boundaries[f"critical_{axis}"])
            boundaries[f"film_parameter_at_{line}"] = film
    return with_band(boundaries, variant_of(ds))


def _film(line: str, judged: xr.Dataset, crossings: xr.DataArray) -> xr.DataArray:
    """Film parameters at crossings along a line; NaN where a scene gives no oil."""

    def along(oil: Lubrication | None, temperature: float, x: Array, crossing: Array) -> Array:
        if oil is None:
            return np.full(x.shape, np.nan)
        places = (x, crossing) if line == "load" else (crossing, x)
        return oil.film_parameter(*places, temperature)

    film: xr.DataArray = xr.apply_ufunc(
        along,
        judged["_oil"],
        judged["_temperature"],
        crossings[line],
        crossings,
        input_core_dims=[[], [], [line], [line]],
        output_core_dims=[[line]],
        vectorize=True,
    )
    return _described(film, "1", "film parameter at the crossing")


def _described(values: xr.DataArray, units: str, words: str) -> xr.DataArray:
    return values.drop_attrs(deep=False).assign_attrs(units=units, long_name=words)


_UNITS = {
    "friction": "1", "bulk_temperature": "K", "disk_temperature": "K", "critical_temperature": "K",
    "failing_share": "1",
}  # fmt: skip
"""Units of the conditions that are attributes of a boundary."""


def _transitions(axis: str, ds: xr.Dataset, judged: xr.Dataset) -> dict[str, xr.DataArray]:
    """Transitions along the velocity at each load, or along the load at each velocity."""
    rise, is_missing = judged["_rise"], judged["_is_missing"]
    line = "load" if axis == "velocity" else "velocity"
    noun = "velocity" if axis == "velocity" else "normal load"
    x, ends = rise[axis].values, range_of(ds, axis)

    def along(
        row: Array, missing: Mask, limit: float, friction: Callable[[Array], Array] | None
    ) -> tuple[float, ...]:
        places, is_done = x, np.isfinite(row)
        if friction and axis == "velocity":
            places, row = along_friction(x, row, friction)
            missing, is_done = spread(missing), spread(is_done)
        transition = Crossing.along(places, row, limit, ends, missing, is_done)
        slope = exponent(places, row, transition.place)
        return transition.place, transition.outcome, *transition.computed, transition.bridged, slope

    place, outcome, low, high, bridged, slope = xr.apply_ufunc(
        along,
        rise,
        is_missing,
        judged["_limit"],
        judged["_friction"],
        input_core_dims=[[axis], [axis], [], []],
        output_core_dims=[[]] * 6,
        output_dtypes=[float, np.int8, float, float, int, float],
        vectorize=True,
    )
    unit = UNITS[axis]
    columns = {
        f"critical_{axis}": (place, unit, f"{noun} at the transition to severe wear"),
        f"computed_from_at_{line}": (low, unit, f"{axis} computed from at this {line}"),
        f"computed_to_at_{line}": (high, unit, f"{axis} computed to at this {line}"),
        f"missing_at_{line}": (
            is_missing.sum(axis), "1", f"pending or failed points at this {line}"
        ),
        f"bridged_at_{line}": (
            bridged, "1", "pending or failed points that the crossing is interpolated across"
        ),
    }  # fmt: skip
    if axis == "velocity":
        words = "d ln(rise) / d ln(velocity) at the crossing"
        columns["rise_exponent_at_load"] = slope, "1", words
    transitions = {name: _described(*column) for name, column in columns.items()}
    meanings = {
        "long_name": "why there is no crossing",
        "flag_values": np.array(list(outcomes(axis)), dtype=np.int8),
        "flag_meanings": " ".join(word.replace(" ", "_") for word in outcomes(axis).values()),
    }
    outcome = outcome.drop_attrs(deep=False).assign_attrs(meanings)
    return transitions | {f"outcome_at_{line}": outcome}


BAND = (0.1, 0.5, 0.9)
"""Shares of the surfaces whose transition lies lower: lower end, middle and upper end."""


def with_band(boundaries: xr.Dataset, variant: str | None) -> xr.Dataset:
    """Add quantiles, mean, spread and counts over several surfaces or samples, their dimension."""
    if variant is None:
        return boundaries
    shares = ("quantile", list(BAND), {"long_name": "share of the surfaces that lie lower"})
    with_quantiles = boundaries.assign_coords(quantile=shares)
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        outcome, unit = boundaries[f"outcome_at_{axis}"], boundaries[name].attrs["units"]
        mean, spread, quantiles = xr.apply_ufunc(
            _band_of,
            boundaries[name],
            outcome,
            boundaries[f"computed_from_at_{axis}"],
            boundaries[f"computed_to_at_{axis}"],
            input_core_dims=[[variant]] * 4,
            output_core_dims=[[], [], ["quantile"]],
            vectorize=True,
        )
        crossing = (outcome == CROSSES).sum(variant)
        certain = outcome.isin((CROSSES, MILD, SEVERE)).sum(variant)
        quantiles = quantiles.transpose(..., "quantile", axis)
        columns = {
            f"{name}_mean": (mean, unit, "mean over the surfaces"),
            f"{name}_spread": (spread, unit, "their standard deviation"),
            f"{name}_quantile": (quantiles, unit, "that a share of the surfaces stays below"),
            f"crossing_at_{axis}": (crossing, "1", "surfaces that cross"),
            f"known_at_{axis}": (certain, "1", "surfaces whose outcome is known"),
        }
        for column, (values, units, words) in columns.items():
            attrs = {"units": units, "long_name": words}
            with_quantiles[column] = values.dims, values.values, attrs
    return with_quantiles


def _band_of(
    places: Array, outcomes: Array, first: Array, last: Array
) -> tuple[float, float, Array]:
    """Mean, spread and quantiles of the transitions of several surfaces along one line."""
    low, high = _ends(places, outcomes, first, last)
    all_cross = np.isfinite(low).all() and (low == high).all()
    mean = float(np.mean(low)) if all_cross else math.nan
    spread = float(np.std(low, ddof=1)) if all_cross and len(low) > 1 else math.nan
    return mean, spread, np.array([quantile(low, high, share) for share in BAND])


def _ends(places: Array, outcomes: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Least and greatest place that each transition may have, of those of which any is known."""
    is_kind = [outcomes == kind for kind in (CROSSES, MILD, SEVERE, ABOVE, BELOW)]
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

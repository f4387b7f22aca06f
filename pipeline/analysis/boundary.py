"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Friction, bulk temperature, critical temperature and failing share enter only here, by
`pipeline.sweep.criterion`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.band import CROSSES, MILD, SEVERE, UNKNOWN, with_band
from pipeline.analysis.dataset import asked_points, at_bulks, leading, ordered, read_by_surface
from pipeline.analysis.interpolation import crossing, interpolated
from pipeline.scene.quantities import in_si, share_of
from pipeline.store import DONE
from pipeline.sweep.criterion import (
    Conditions,
    contact_temperature,
    of_bulks,
    require_bulks,
    rise_limit,
    worst_moment,
)
from pipeline.sweep.lubrication import Lubrication
from tribo import InputError
from tribo.thermal import quantiles
from tribo.types import Array

Bulk = float | str | Mapping[str, float | str]
"""A bulk temperature [K] or with a unit; or one for each body, by ``"pin"`` and ``"disk"``."""

_COLDEST_OIL, _HOTTEST_OIL = 220.0, 900.0  # bulk temperatures [K]


def boundary(
    ds: xr.Dataset,
    friction: float | Iterable[float] | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
) -> xr.Dataset:
    """Critical velocity for each load and critical load for each velocity.

    Over several random surfaces there is a boundary for each of them, and the band of them all.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`. Points that are pending or failed are skipped.
    friction : float or several, optional
        Coefficient of friction, at least 0; like the following the sweep's own if not given.
        Several give a dimension ``friction``.
    bulk_temperature, critical_temperature : float, str or mapping, optional
        Temperature far from the contact, and the one above which the lubricant fails [K]; or text
        with a unit, such as ``"80 degC"``. In a sweep of bodies of unequal bulk temperatures, such
        as ``{"pin": "60 degC", "disk": "25 degC"}`` for both.
    share : float or str, optional
        Wear is severe where more than this share of the contact area is hotter than the critical
        temperature, such as 0.1 or ``"10%"``; 0 is Blok's criterion, the maximum temperature.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the first crossing
        from mild to severe wear, NaN where the sweep does not cross. ``outcome_at_load`` and
        ``outcome_at_velocity`` say why not: mild or severe (at the lowest point already)
        throughout, or unknown for want of points. ``missing_at_load`` and
        ``missing_at_velocity`` count the points that are pending or failed. The conditions are
        attributes, and ``missing_points`` their total. Where the scene gives an oil,
        ``film_parameter_at_load`` and ``film_parameter_at_velocity`` are the film parameters at
        the crossings (see `pipeline.sweep.lubrication`).

        All of these have a dimension ``realization`` more over several surfaces, and there are
        ``critical_velocity_quantile(quantile, load)``, the velocity below which 10, 50 and 90 %
        of the surfaces turn severe: those that stay mild or are severe throughout are counted,
        beyond all velocities, so that a quantile among them is NaN. ``critical_velocity_mean``
        and ``critical_velocity_spread`` (standard deviation) are NaN unless every surface
        crosses. ``crossing_at_load`` counts those that do, ``known_at_load`` those that are known
        to cross or not. Likewise for ``critical_load``.

    Raises
    ------
    InputError
        If a condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.boundary(ds)["critical_velocity"].round(2).to_series()
    load
    200.0    3.54
    400.0    2.23
    600.0    1.56
    750.0    1.24
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.boundary(ds, friction=0.09, bulk_temperature="40 degC")
    >>> warmer["critical_velocity"].sel(load=600).round(2).item()
    1.48
    """
    if isinstance(friction, str):
        raise InputError(f'friction: "{friction}" is text; give a number such as 0.1, or several')
    if isinstance(friction, Iterable):
        others = (bulk_temperature, critical_temperature, share)
        values = [float(value) for value in friction]
        axis = xr.Variable("friction", values, {"units": "1", "long_name": "friction coefficient"})
        return xr.concat(
            [boundary(ds, value, *others) for value in values],
            axis,
            data_vars="all",
            combine_attrs="drop_conflicts",
        )
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    given = (friction, bulk_temperature, critical_temperature, share)
    parts = read_by_surface(ordered(ds))
    found = [_boundary(part, of_sample(part, conditions, given)) for part in parts]
    name = leading(ds)
    if name is None:
        return found[0]
    band = with_band(xr.concat(found, name, combine_attrs="override"))
    own = {key: getattr(conditions, key) for key in band.attrs if hasattr(conditions, key)}
    band = band.assign_attrs(own)  # a sample's are its own
    return band.assign_attrs(missing_points=sum(each.attrs["missing_points"] for each in found))


def of_sample(ds: xr.Dataset, conditions: Conditions, given: Iterable[Any]) -> Conditions:
    """Conditions of one sample: as it was drawn, where they are not given.

    Parameters
    ----------
    ds : Dataset
        Sweep on one surface or for one sample.
    conditions : Conditions
        Those that hold otherwise.
    given : iterable
        What is given of the friction, the bulk and the critical temperature and the failing share,
        in this order; None where it is not.
    """
    drawn = {
        name: float(ds[path])
        for (name, path), own in zip(_DRAWN.items(), given, strict=True)
        if own is None and path in ds.coords
    }
    return replace(conditions, **drawn) if drawn else conditions


_DRAWN = {
    "friction": "friction.coefficient",
    "bulk_temperature": "temperature.bulk",
    "critical_temperature": "temperature.critical",
    "failing_share": "temperature.failing_share",
}
"""Conditions that may be unknown inputs, and their paths in the scene."""


def _boundary(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """The boundary on one surface."""
    ds = at_bulks(ds, conditions)
    rise = decisive_rise(ds, conditions.failing_share)
    limit = rise_limit(conditions)
    loads, velocities, r = rise["load"].values, rise["velocity"].values, rise.values
    missing = ~np.isfinite(r) & asked_points(ds).values

    lubrication = Lubrication.stored(attributes_of(ds))
    result = xr.Dataset(
        {
            "critical_velocity": (
                "load",
                [crossing(velocities, row, limit) for row in r],
                {"units": "m/s", "long_name": "velocity at the transition to severe wear"},
            ),
            "critical_load": (
                "velocity",
                [crossing(loads, column, limit) for column in r.T],
                {"units": "N", "long_name": "normal load at the transition to severe wear"},
            ),
        },
        coords=rise.coords,
        attrs={**conditions.as_dict(), "missing_points": int(np.count_nonzero(missing))},
    )
    for name, axis in (("load", 1), ("velocity", 0)):
        found = result["critical_velocity" if name == "load" else "critical_load"].values
        result[f"outcome_at_{name}"] = (name, _outcome(found, r, limit, axis), _OUTCOME_ATTRS)
        result[f"missing_at_{name}"] = (
            name,
            np.count_nonzero(missing, axis=axis),
            {"units": "1", "long_name": f"pending or failed points at this {name}"},
        )
        if lubrication:
            at = (loads, found) if name == "load" else (found, velocities)
            parameter = lubrication.film_parameter(*at, conditions.mean_bulk_temperature)
            result[f"film_parameter_at_{name}"] = (
                name,
                parameter,
                {"units": "1", "long_name": "film parameter at the crossing"},
            )
    return result


_OUTCOME_ATTRS = {
    "long_name": "why there is no crossing",
    "flag_values": np.array([CROSSES, MILD, SEVERE, UNKNOWN], dtype=np.int8),
    "flag_meanings": "crosses mild_throughout severe_from_the_lowest unknown",
}


def decisive_temperature(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    resolution: int | None = None,
) -> xr.DataArray:
    """Temperature that just the failing share of the contact area exceeds, at the highest.

    Wear is severe where it lies above the critical temperature.

    Parameters
    ----------
    ds, friction, bulk_temperature, critical_temperature, share
        See `boundary`.
    resolution : int, optional
        See `decisive_rise`.

    Returns
    -------
    DataArray, dims (load, velocity), after ``realization`` over several surfaces
        Temperature [K]; NaN at points that are pending or failed.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> temperature = pipeline.decisive_temperature(ds, friction=0.12)
    >>> temperature.sel(load=600, velocity=1.6).round().item()
    444.0
    """
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    rise = decisive_rise(at_bulks(ds, conditions), conditions.failing_share, resolution)
    temperature = contact_temperature(rise, conditions)
    temperature.attrs = {
        "units": "K",
        "long_name": "temperature exceeded by the failing share of the contact",
        **conditions.as_dict(),
    }
    return temperature.rename("decisive_temperature")


def decisive_rise(
    ds: xr.Dataset, share: float, resolution: int | None = None, continued: bool = False
) -> xr.DataArray:
    """Rise, at friction 1, that just a share of the contact area exceeds, at the highest.

    It is the highest one from when the load of a point is reached on: at the end of the ramp or,
    where the load is held, at any later step at which the temperature was asked for.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    share : float
        Share of the contact area, from 0 (the maximum) to below 1.
    resolution : int, optional
        Interpolate onto so many loads and velocities, evenly spaced. The surface passes through
        the boundary that `boundary` finds for each load and each velocity. NaN beyond the
        outermost known points.
    continued : bool, optional
        Whether at each load to go on beyond those, as a power of the velocity.

    Returns
    -------
    DataArray, dims (load, velocity), after ``realization`` over several surfaces
        Rise [K], sorted along all axes; NaN at points that are pending or failed.
    """
    ds = ordered(ds[["normal_load", "rise_quantile", "status"]])
    if name := leading(ds):
        each = [decisive_rise(part, share, resolution, continued) for part in read_by_surface(ds)]
        found: xr.DataArray = xr.concat(each, name)
        return found
    ds = ds.transpose("load", "velocity", "step", ...)
    rises = rise_exceeded(ds, share).where(ds["status"] == DONE).values
    worst = worst_moment(rises, ds["normal_load"].values, ds["load"].values[:, None, None])
    r = np.take_along_axis(rises, worst[..., None], axis=-1)[..., 0]
    loads, velocities = ds["load"].values, ds["velocity"].values
    if resolution is not None:
        fine = np.linspace(velocities[0], velocities[-1], resolution)
        r = np.array([interpolated(velocities, row, fine, continued) for row in r])
        velocities, fine = fine, np.linspace(loads[0], loads[-1], resolution)
        r = np.array([interpolated(loads, column, fine) for column in r.T]).T
        loads = fine
    return xr.DataArray(
        r,
        coords={
            "load": ("load", loads, ds["load"].attrs),
            "velocity": ("velocity", velocities, ds["velocity"].attrs),
            **{name: ds[name] for name in ds.coords if name in ("realization", "sample")},
        },
        dims=("load", "velocity"),
        name="decisive_rise",
        attrs={
            "units": "K",
            "long_name": "rise at friction 1 exceeded by a share of the contact",
            "share": share,
        },
    )


def rise_exceeded(ds: xr.Dataset, share: float) -> xr.DataArray:
    """Rise, at friction 1, that just a share of the contact area exceeds.

    Returns
    -------
    DataArray
        Rise [K], with the dimensions of ``rise_quantile`` but the quantile; NaN where the
        temperature is not known.
    """
    found: xr.DataArray = xr.apply_ufunc(
        quantiles.rise_exceeded,
        ds["rise_quantile"],
        input_core_dims=[["quantile"]],
        kwargs={"share": share, "quantiles": ds["quantile"].values},
    )
    return found


def conditions_of(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
) -> Conditions:
    """Take the sweep's own conditions, and those that are given in their place.

    Raises
    ------
    InputError
        If one lies outside its range, or is neither given nor in the sweep.
    """
    given = {
        "friction": friction,
        "critical_temperature": _kelvin("critical_temperature", critical_temperature),
        "failing_share": None if share is None else share_of(share),
    }
    values = dict(attributes_of(ds).get("conditions") or {})
    values |= {name: value for name, value in given.items() if value is not None}
    if bulk_temperature is not None:
        each = (
            {body: _kelvin("bulk_temperature", own) for body, own in bulk_temperature.items()}
            if isinstance(bulk_temperature, Mapping)
            else _kelvin("bulk_temperature", bulk_temperature)
        )
        values |= of_bulks(each)
    for name in (*given, "bulk_temperature"):
        if values.get(name) is None and name != "critical_temperature":
            raise InputError(f"the sweep has no {name} of its own; give one")
    conditions = Conditions(**values)
    require_bulks(ds, conditions)
    if conditions.friction and not attributes_of(ds).get("scene", {}).get("friction_heat", True):
        raise InputError(
            f"friction is {conditions.friction:g}; the sweep was computed without friction, and "
            "so without any heat: run it again with friction, into another store"
        )
    return conditions


def _kelvin(name: str, given: float | str | None) -> float | None:
    """Read a temperature [K], and refuse one at which no oil works."""
    if isinstance(given, str):
        given = in_si(name, given, "80 degC")
    if given is None or isinstance(given, Iterable):
        return given  # several are refused with the other conditions
    hottest = _HOTTEST_OIL if name == "bulk_temperature" else np.inf
    if given < _COLDEST_OIL or hottest < given < np.inf:
        raise InputError(
            f"{name} is {given - 273.15:.4g} °C ({given:g} K), at which no oil works; give one "
            f"from {_COLDEST_OIL - 273.15:.4g} °C on; in Python a plain number is in kelvins, and "
            'text has its unit, such as "80 degC"'
        )
    return given


def _outcome(found: Array, r: Array, limit: float, axis: int) -> NDArray[np.int8]:
    known = np.isfinite(r)
    lowest = np.take_along_axis(r, np.expand_dims(known.argmax(axis), axis), axis).squeeze(axis)
    outcome = np.where(lowest > limit, SEVERE, MILD)
    outcome[~known.any(axis)] = UNKNOWN
    outcome[np.isfinite(found)] = CROSSES
    return outcome.astype(np.int8)

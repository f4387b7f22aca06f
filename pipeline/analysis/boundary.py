"""The boundary between mild and severe wear, from a stored sweep and without a new simulation.

Friction, bulk temperature, critical temperature and failing share enter only here, by
`pipeline.sweep.criterion`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.analysis.band import CROSSES, MILD, SEVERE, UNKNOWN, with_band
from pipeline.analysis.dataset import asked_points, by_surface, ordered
from pipeline.analysis.interpolation import crossing, interpolated
from pipeline.store.variables import DONE
from pipeline.sweep.criterion import Conditions, contact_temperature, rise_limit, worst_moment
from tribo import InputError
from tribo.thermal import quantiles
from tribo.types import Array

_COLDEST_OIL, _HOTTEST_OIL = 220.0, 900.0  # bulk temperatures [K]


def boundary(
    ds: xr.Dataset,
    friction: float | Iterable[float] | None = None,
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
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
    bulk_temperature, critical_temperature : float or str, optional
        Temperature far from the contact, and the one above which the lubricant fails [K]; or text
        with a unit, such as ``"80 degC"``.
    share : float, optional
        Wear is severe where more than this share of the contact area is hotter than the critical
        temperature; 0 is Blok's criterion, the maximum temperature.

    Returns
    -------
    Dataset
        ``critical_velocity(load)`` [m/s] and ``critical_load(velocity)`` [N]: the first crossing
        from mild to severe wear, NaN where the sweep does not cross. ``outcome_at_load`` and
        ``outcome_at_velocity`` say why not: mild or severe (at the lowest point already)
        throughout, or unknown for want of points. ``missing_at_load`` and
        ``missing_at_velocity`` count the points that are pending or failed. The conditions are
        attributes, and ``missing_points`` their total.

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
    found = [_boundary(surface, conditions) for surface in by_surface(ordered(ds))]
    if "realization" not in ds.dims:
        return found[0]
    band = with_band(xr.concat(found, "realization", combine_attrs="override"))
    return band.assign_attrs(missing_points=sum(each.attrs["missing_points"] for each in found))


def _boundary(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """The boundary on one surface."""
    rise = decisive_rise(ds, conditions.failing_share)
    limit = rise_limit(conditions)
    loads, velocities, r = rise["load"].values, rise["velocity"].values, rise.values
    missing = ~np.isfinite(r) & asked_points(ds).values

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
        attrs={**asdict(conditions), "missing_points": int(np.count_nonzero(missing))},
    )
    for name, axis in (("load", 1), ("velocity", 0)):
        found = result["critical_velocity" if name == "load" else "critical_load"].values
        result[f"outcome_at_{name}"] = (name, _outcome(found, r, limit, axis), _OUTCOME_ATTRS)
        result[f"missing_at_{name}"] = (
            name,
            np.count_nonzero(missing, axis=axis),
            {"units": "1", "long_name": f"pending or failed points at this {name}"},
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
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
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
    """
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    rise = decisive_rise(ds, conditions.failing_share, resolution)
    temperature = contact_temperature(rise, conditions)
    temperature.attrs = {
        "units": "K",
        "long_name": "temperature exceeded by the failing share of the contact",
        **asdict(conditions),
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
    if "realization" in ds.dims:
        each = [decisive_rise(part, share, resolution, continued) for part in by_surface(ds)]
        found: xr.DataArray = xr.concat(each, "realization")
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
            **{name: ds[name] for name in ("realization",) if name in ds.coords},
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
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
) -> Conditions:
    """Take the sweep's own conditions, and those that are given in their place.

    Raises
    ------
    InputError
        If one lies outside its range, or is neither given nor in the sweep.
    """
    given = {
        "friction": friction,
        "bulk_temperature": _kelvin("bulk_temperature", bulk_temperature),
        "critical_temperature": _kelvin("critical_temperature", critical_temperature),
        "failing_share": share,
    }
    values = dict(ds.attrs.get("conditions") or {})
    values |= {name: value for name, value in given.items() if value is not None}
    for name in given:
        if values.get(name) is None and name != "critical_temperature":
            raise InputError(f"the sweep has no {name} of its own; give one")
    conditions = Conditions(**values)
    if conditions.friction and not ds.attrs.get("scene", {}).get("friction_heat", True):
        raise InputError(
            f"friction is {conditions.friction:g}; the sweep was computed without friction, and "
            "so without any heat: run it again with friction, into another store"
        )
    return conditions


def _kelvin(name: str, given: float | str | None) -> float | None:
    """Read a temperature [K], and refuse one at which no oil works."""
    if isinstance(given, str):
        from pipeline.scene.units import UnitError, to_si  # takes 0.1 s, and few calls need it

        try:
            given = to_si(given, "300 K")
        except UnitError as error:
            raise InputError(f'{name}: {error}; give one such as "80 degC"') from error
    if given is None or isinstance(given, Iterable):
        return given  # several are refused with the other conditions
    hottest = _HOTTEST_OIL if name == "bulk_temperature" else np.inf
    if given < _COLDEST_OIL or hottest < given < np.inf:
        raise InputError(
            f"{name} is {given:g} K, that is {given - 273.15:.4g} °C, at which no oil works; give "
            f'kelvins from {_COLDEST_OIL:g} on, or text with a unit, such as "{given:g} degC"'
        )
    return given


def _outcome(found: Array, r: Array, limit: float, axis: int) -> NDArray[np.int8]:
    known = np.isfinite(r)
    lowest = np.take_along_axis(r, np.expand_dims(known.argmax(axis), axis), axis).squeeze(axis)
    outcome = np.where(lowest > limit, SEVERE, MILD)
    outcome[~known.any(axis)] = UNKNOWN
    outcome[np.isfinite(found)] = CROSSES
    return outcome.astype(np.int8)

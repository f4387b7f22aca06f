"""The boundary between mild and severe wear, from a stored sweep and without a new simulation."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from pipeline.analysis.conditions import Bulk, conditions_of
from pipeline.analysis.crossings import crossings
from pipeline.analysis.dataset import at_bulks, dataset_of, ordered
from pipeline.analysis.results import Results, decisive_plane
from pipeline.store import PathLike
from pipeline.sweep.criterion import contact_temperature
from tribo.thermal import quantiles


def boundary(
    ds: xr.Dataset | PathLike,
    friction: float | Iterable[float] | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
) -> xr.Dataset:
    """Critical velocity for each load and critical load for each velocity.

    Over several random surfaces there is a boundary for each of them, and the band of them all.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store. Points that are pending
        or failed are skipped.
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
        throughout, or unknown for want of points. ``rise_exponent_at_load`` is d ln(rise) over
        d ln(velocity) at the crossing: an error of the rise, divided by it, is that of the critical
        velocity. ``missing_at_load`` and
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
    200.0    3.53
    400.0    2.23
    600.0    1.56
    750.0    1.24
    Name: critical_velocity, dtype: float64
    >>> warmer = pipeline.boundary(ds, friction=0.09, bulk_temperature="40 degC")
    >>> warmer["critical_velocity"].sel(load=600).round(2).item()
    1.48
    """
    ds = ordered(dataset_of(ds))
    results = Results.of(ds)
    found = crossings(results, friction, bulk_temperature, critical_temperature, share).as_dataset()
    own = ("load", "velocity", "realization", "sample")
    coordinates = {name: ds[name].variable for name in own if name in ds.coords}
    return found.assign_coords(coordinates)


def decisive_temperature(
    ds: xr.Dataset | PathLike,
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
    ds = dataset_of(ds)
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
    ds = ordered(ds)
    results = Results.of(ds)
    planes = [decisive_plane(part, share) for part in results.parts()]
    if resolution is not None:
        planes = [plane.refined(resolution, continued) for plane in planes]
    loads, velocities, r = planes[0]
    dims: tuple[str, ...] = ("load", "velocity")
    if results.leading:
        dims, r = (results.leading, *dims), np.stack([plane.rises for plane in planes])
    variants = (name for name in ("realization", "sample") if name in ds.coords)
    return xr.DataArray(
        r,
        coords={
            "load": ("load", loads, ds["load"].attrs),
            "velocity": ("velocity", velocities, ds["velocity"].attrs),
            **{name: ds[name].variable for name in variants},
        },
        dims=dims,
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

"""A stored sweep as a labelled dataset, with the temperatures of the scene's own conditions."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pipeline.store.committed import Committed, as_needed
from pipeline.store.folder import PathLike, folder_of
from pipeline.sweep.criterion import Conditions, contact_temperature, failed_fraction
from pipeline.sweep.model import Point
from tribo import InputError
from tribo.types import Array


def open_sweep(path: PathLike) -> xr.Dataset:
    """Open a stored sweep.

    Parameters
    ----------
    path : str or path
        Folder or address of a store that `pipeline.run_sweep` has made; it may still be growing.

    Returns
    -------
    Dataset
        The stored variables, with loads, velocities and seeds of surfaces ascending. Steps beyond
        a load's own and points that are not done are NaN. Under the conditions of the scene there
        are also, at each step where the temperature was asked for:

        ``max_temperature``, ``mean_temperature``
            Highest and mean temperature of the contact [K].
        ``temperature_quantile``
            Temperature that a share ``quantile`` of the contact area stays below [K].
        ``failed_fraction``
            Share of the contact area above the critical temperature, if the scene gives that.

        Data are read when they are used.

    Raises
    ------
    StoreError
        If there is no readable store.
    """
    ds = ordered(xr.open_dataset(str(folder_of(path)), engine=Committed))
    return ds.assign(_temperatures(ds))


def ordered(ds: xr.Dataset) -> xr.Dataset:
    """Sort the axes of a sweep, which a store keeps in the order in which they grew."""
    return ds.sortby([name for name in ("realization", "load", "velocity") if name in ds.dims])


def by_surface(ds: xr.Dataset) -> list[xr.Dataset]:
    """Take the sweep on each of its surfaces alone; as it is if it has no such dimension."""
    if "realization" not in ds.dims:
        return [ds]
    return [ds.sel(realization=seed) for seed in ds["realization"].values.tolist()]


def on_surface(ds: xr.Dataset, realization: int | None = None) -> xr.Dataset:
    """Take the sweep on one of its surfaces, the first if not given.

    Raises
    ------
    InputError
        If the sweep does not hold that surface.
    """
    seeds = ds["realization"].values.tolist() if "realization" in ds.dims else []
    if realization is None:
        return ds.sel(realization=seeds[0]) if seeds else ds
    if realization not in seeds:
        held = f"it holds {', '.join(map(str, seeds))}" if seeds else "its scene gives no others"
        raise InputError(f"realization is {realization}, which the sweep does not hold; {held}")
    return ds.sel(realization=realization)


def asked_points(ds: xr.Dataset) -> xr.DataArray:
    """Tell which points the last run asked for, dims (load, velocity): all, or those it chose.

    The other points in the store were asked for by an earlier run. The sweep is on one surface.
    """
    asked = xr.ones_like(ds["status"], dtype=bool)
    chosen = ds.attrs.get("chosen")
    if chosen is not None:
        surface = int(ds["realization"]) if "realization" in ds.coords else None
        wanted = {
            point[:2]
            for point in (Point(*entry) for entry in chosen)
            if point.realization == surface
        }
        loads, velocities = ds["load"].values.tolist(), ds["velocity"].values.tolist()
        rows = [[(load, velocity) in wanted for velocity in velocities] for load in loads]
        asked = xr.DataArray(rows, {"load": ds["load"], "velocity": ds["velocity"]})
    return asked.transpose("load", "velocity")


def end_of_point(ds: xr.Dataset) -> xr.Dataset:
    """Take each point at its last step, the load that it is named after.

    Parameters
    ----------
    ds : Dataset
        Dataset of `open_sweep`.

    Returns
    -------
    Dataset
        Without the dimension ``step``; NaN where a point is not done.
    """
    steps = ds["time"].notnull().sum("step")
    return ds.isel(step=(steps - 1).clip(min=0)).drop_vars("step")


def _temperatures(ds: xr.Dataset) -> dict[str, xr.Variable]:
    """Temperature and failed share at the friction and bulk temperature of the scene."""
    conditions = Conditions(**ds.attrs["conditions"])

    def warmed(name: str, meaning: str) -> xr.Variable:
        rise = ds[name].variable
        return as_needed(
            rise.dims,
            rise.shape,
            rise.dtype,
            lambda key: contact_temperature(rise[key].values, conditions),
            {"units": "K", "long_name": f"{meaning} of the contact"},
        )

    rises = ds["rise_quantile"].variable

    def failed(key: tuple[Any, ...]) -> Array:
        quantiles = rises[(*key, slice(None))].values
        shares = np.full(quantiles.shape[:-1], np.nan)
        for index in np.ndindex(shares.shape):
            if np.isfinite(quantiles[index][0]):
                shares[index] = failed_fraction(quantiles[index], conditions)
        return shares

    found = {
        "max_temperature": warmed("max_rise", "highest temperature"),
        "mean_temperature": warmed("mean_rise", "mean temperature"),
        "temperature_quantile": warmed("rise_quantile", "quantile of the temperature"),
    }
    if conditions.critical_temperature is not None:
        found["failed_fraction"] = as_needed(
            rises.dims[:-1],
            rises.shape[:-1],
            float,
            failed,
            {"units": "1", "long_name": "share of the contact above the critical temperature"},
        )
    return found

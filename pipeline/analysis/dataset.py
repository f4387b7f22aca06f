"""A stored sweep as a labelled dataset, with the temperatures of the scene's own conditions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of, portable
from pipeline.analysis.results import Results, require_surface
from pipeline.store import Committed, PathLike, as_needed, folder_of
from pipeline.store.identity import simulated_inputs
from pipeline.store.variables import LEADING, VARIABLES
from pipeline.sweep.criterion import (
    Conditions,
    contact_temperature,
    failed_fraction,
    require_bulks,
)
from pipeline.sweep.unknown import first_alike
from tribo import InputError
from tribo.thermal import at_bulk_ratio
from tribo.types import Array

_IN_UTC = {
    "units": "seconds since 1970-01-01 00:00:00",
    "calendar": "standard",
    "long_name": "when the point was finished, UTC",
}


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

        ``step_count``
            Number of steps of each point; 0 where it is not done.

        Data are read when they are used. Attributes are text and numbers, those that are more as
        JSON, so that ``to_netcdf`` writes them.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> ds["max_temperature"].dims
    ('load', 'velocity', 'step')
    >>> end = pipeline.end_of_point(ds)
    >>> end["max_temperature"].sel(load=600, velocity=1.6).round().item()
    436.0
    """
    ds = _shared(ordered(xr.open_dataset(str(folder_of(path)), engine=Committed)))
    for name in ds.variables:  # as they are written today, in old stores too
        if name in VARIABLES and (units := VARIABLES[str(name)].units):
            ds[name].attrs["units"] = units
    ds["finished_at"].attrs |= _IN_UTC
    ds = ds.assign(_temperatures(ds) | {"step_count": _step_counts(ds), "message": _messages(ds)})
    return (
        ds.drop_vars("checksum", errors="ignore")
        .drop_attrs(deep=False)
        .assign_attrs(portable(ds.attrs))
    )


def dataset_of(source: xr.Dataset | PathLike | Results) -> xr.Dataset:
    """The dataset of a sweep, which is opened if it is not yet."""
    if isinstance(source, Results):
        source = source.source
    return source if isinstance(source, xr.Dataset) else open_sweep(source)


def ordered(ds: xr.Dataset) -> xr.Dataset:
    """Sort the axes of a sweep, which a store keeps in the order in which they grew."""
    return ds.sortby([name for name in (*LEADING, "load", "velocity") if name in ds.dims])


def _shared(ds: xr.Dataset) -> xr.Dataset:
    """Give each sample the simulation that it shares with another, if it has none of its own.

    The coordinate ``simulation`` is the number of the sample that was simulated.
    """
    if "sample" not in ds.dims:
        return ds
    columns = [ds[path].values.tolist() for path in simulated_inputs(ds.attrs)]
    first = first_alike(ds.sizes["sample"], columns)
    if first == tuple(range(len(first))):
        return ds
    own = {name: entry for name, entry in ds.coords.items() if "sample" in entry.dims}
    return ds.isel(sample=list(first)).assign_coords(own | {"simulation": ("sample", list(first))})


def on_surface(ds: xr.Dataset, realization: int | None = None) -> xr.Dataset:
    """Take the sweep on one of its surfaces, the first if not given.

    Raises
    ------
    InputError
        If the sweep does not hold that surface.
    """
    if "sample" in ds.dims:
        raise InputError(
            "the sweep has samples of unknown inputs; irg risk and irg sensitivity show them all, "
            "and in Python ds.sel(sample=0) is one of them"
        )
    seeds = ds["realization"].values.tolist() if "realization" in ds.dims else []
    if realization is None:
        return ds.sel(realization=seeds[0]) if seeds else ds
    require_surface(realization, seeds)
    return ds.sel(realization=realization)


def at_bulks(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """Take the rises of a sweep at the bulk temperatures of some conditions.

    Parameters
    ----------
    ds : Dataset
        Dataset of `open_sweep`.
    conditions : Conditions
        Conditions to judge by.

    Returns
    -------
    Dataset
        The same where the bulk temperatures are equal; else with rises above the pin's bulk for
        each unit of `Conditions.rise_factor`, but for the fields.

    Raises
    ------
    InputError
        If they are not, and the sweep was computed for equal ones.
    """
    ratio = conditions.bulk_ratio
    if ratio == 0:
        return ds
    require_bulks(ds, conditions)
    rises = xr.apply_ufunc(
        at_bulk_ratio,
        ds["rise_quantile"],
        ds["bulk_rise_quantile"],
        input_core_dims=[["quantile"], ["bulk_ratio", "quantile"]],
        output_core_dims=[["quantile"]],
        kwargs={"ratio": ratio},
        keep_attrs=True,
    )
    found = {"rise_quantile": rises}
    if "max_rise" in ds:
        found["max_rise"] = rises.isel(quantile=-1, drop=True)
        found["mean_rise"] = ds["mean_rise"] + ratio * ds["mean_bulk_response"]
    return ds.assign(found)


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

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> end = pipeline.end_of_point(ds)
    >>> end["contact_width"].sel(load=600, velocity=1.6).round(6).item()
    0.00029
    """
    steps = ds["step_count"] if "step_count" in ds else ds["time"].notnull().sum("step")
    return ds.isel(step=(steps - 1).clip(min=0)).drop_vars("step")


def _messages(ds: xr.Dataset) -> xr.Variable:
    """Messages as Python's text; xarray 2025.6 does not write NumPy's own to netCDF."""
    told = ds["message"].variable
    return as_needed(
        told.dims,
        told.shape,
        object,
        lambda key: np.asarray(told[key].values, dtype=object),
        told.attrs,
    )


def _step_counts(ds: xr.Dataset) -> xr.Variable:
    """Number of steps of each point."""
    time = ds["time"].variable
    return as_needed(
        time.dims[:-1],
        time.shape[:-1],
        np.int32,
        lambda key: np.isfinite(time[(*key, slice(None))].values).sum(axis=-1, dtype=np.int32),
        {"units": "1", "long_name": "number of steps of the point; the last is its end"},
    )


def _temperatures(ds: xr.Dataset) -> dict[str, xr.Variable]:
    """Temperature and failed share at the friction and bulk temperature of the scene."""
    conditions = Conditions(**attributes_of(ds)["conditions"])
    rises = _rises(ds, conditions)

    def warmed(name: str, meaning: str) -> xr.Variable:
        rise = ds[name].variable
        return as_needed(
            rise.dims,
            rise.shape,
            rise.dtype,
            lambda key: contact_temperature(rises[name](key), conditions),
            {"units": "K", "long_name": f"{meaning} of the contact"},
        )

    *dims, _ = ds["rise_quantile"].dims

    def failed(key: tuple[Any, ...]) -> Array:
        quantiles = rises["rise_quantile"]((*key, slice(None)))
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
            tuple(dims),
            tuple(ds.sizes[name] for name in dims),
            float,
            failed,
            {"units": "1", "long_name": "share of the contact above the critical temperature"},
        )
    return found


def _rises(ds: xr.Dataset, conditions: Conditions) -> dict[str, Callable[[tuple[Any, ...]], Array]]:
    """Readers of rises [K] at the bulk temperatures of some conditions, by an orthogonal index."""

    def stored(name: str) -> Callable[[tuple[Any, ...]], Array]:
        variable = ds[name].variable
        return lambda key: variable[key].values

    found = {name: stored(name) for name in ("max_rise", "mean_rise", "rise_quantile")}
    ratio = conditions.bulk_ratio
    if ratio == 0:
        return found
    quantiles, of_bulks = found["rise_quantile"], stored("bulk_rise_quantile")
    mean, response = found["mean_rise"], stored("mean_bulk_response")
    every = slice(None)

    def at_ratio(key: tuple[Any, ...]) -> Array:
        return at_bulk_ratio(quantiles((*key, every)), of_bulks((*key, every, every)), ratio)

    return {
        "max_rise": lambda key: at_ratio(key)[..., -1],
        "mean_rise": lambda key: mean(key) + ratio * response(key),
        "rise_quantile": lambda key: at_ratio(key[:-1])[..., key[-1]],
    }

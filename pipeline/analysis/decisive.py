"""The rise that decides at each point of a stored sweep, and temperatures that follow from it."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr

from pipeline.analysis.conditions import Bulk, attributes_by, conditions_of
from pipeline.analysis.dataset import (
    dataset_of,
    own_wear_rate,
    plane_of,
    sweep_at_bulks,
    values_of,
)
from pipeline.analysis.scenes import by_scene
from pipeline.analysis.transition import certain, interpolated
from pipeline.store.schema import DONE, PLANE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import (
    columns_needed,
    contact_temperature,
    failed_fraction,
    rise_limit,
    worst_rises,
)
from pipeline.sweep.variants import WEAR_RATE
from tribo import Criterion, InputError
from tribo.types import Array, Mask


def decisive_rise(ds: xr.Dataset, conditions: Conditions) -> xr.DataArray:
    """Rise, at friction 1, that decides at each point [K]; NaN where pending or failed.

    It is the highest one from when the load of a point is reached on: at the end of the ramp or,
    where the load is held, at any later step at which the temperature was asked for. Dimensions
    are (load, velocity), after those in front such as ``realization``, all ascending.
    """
    ds = _about_quantile(dataset_of(ds), conditions.decisive.quantile)
    for name in ("load", "velocity"):
        if name not in ds.dims:
            raise InputError(
                f"the sweep is one at a single {name}, and not a plane: take a list of one, such "
                f"as ds.sel({name}=[{ds[name].item():g}])"
            )
    names = ["normal_load", conditions.decisive.column, *columns_needed(conditions)]
    columns = {name: values_of(ds, name) for name in dict.fromkeys(names) if name in ds}
    columns["quantile"] = ds["cooler_share"].values
    rises = worst_rises(columns, ds["load"].values[:, None, None], conditions)
    dims = [*(str(name) for name in ds["status"].dims if name not in PLANE), *PLANE]
    is_done = values_of(ds, "status") == DONE
    rises = np.where(is_done, rises, np.nan)
    limit = None if conditions.critical_temperature is None else rise_limit(conditions)
    require_sound(ds, _deciding(is_done, rises, limit, *dims), *dims)
    return xr.DataArray(
        rises,
        {name: ds[name].variable for name in ("realization", *dims) if name in ds.coords},
        dims,
        "decisive_rise",
        {"units": "K", "long_name": "decisive rise at friction 1"},
    )


def _about_quantile(ds: xr.Dataset, level: float | None) -> xr.Dataset:
    """The sweep with the two quantiles about a level alone, which is all that is read of it."""
    stored = ds["cooler_share"].values
    if level is None or not stored[0] <= level <= stored[-1]:
        return ds
    last = max(int(np.searchsorted(stored, level)), 1)
    return ds.isel(cooler_share=slice(last - 1, last + 1))


def require_sound(ds: xr.Dataset, suspects: Mask, *dims: str) -> None:
    """Compare the data of some points, by the given dimensions, with their checksums, each once.

    Datasets of no store are left alone.
    """
    reader = ds["status"].encoding.get("reader")
    if reader is None:
        return
    # The velocity at another wear rate is that of a contact of the store, scaled.
    rate = ds.attrs.get("wear_rate")
    scale = {"velocity": rate / own_wear_rate(ds)} if rate else {}
    places: dict[str, list[int | None]] = {}
    for name in reader.dims:
        values = np.atleast_1d(ds[name].values).tolist() if name in ds.coords else [None]
        places[name] = [
            None if value is None else reader.position(name, value * scale.get(name, 1))
            for value in values
        ]
    if rate:  # interpolated between all of them
        places |= {name: [*reader.positions(name)] for name in reader.dims if name == WEAR_RATE}
    indices = set()
    for found in np.argwhere(suspects).tolist():
        at = dict(zip(dims, found, strict=True))
        here = ([places[k][at[k]]] if k in at else places[k] for k in reader.dims)
        indices |= {index for index in itertools.product(*here) if None not in index}
    reader.require_sound(indices)


def _deciding(is_done: Mask, rises: Array, limit: float | None, *dims: str) -> Mask:
    """Done points without a rise [K], and those beside which it crosses a limit [K]."""
    mask = is_done & np.isnan(rises)
    for axis, name in enumerate(dims):
        if limit is not None and name in PLANE:
            mask |= np.apply_along_axis(turns, axis, rises, limit)
    return mask


def turns(rise: Array, limit: float) -> Mask:
    """Known points of a row with the other kind of wear at the next known one on either side."""
    (indices,), severe = np.nonzero(np.isfinite(rise)), Criterion.is_severe(rise, limit)
    turns = np.flatnonzero(severe[indices[:-1]] != severe[indices[1:]])
    beside = np.zeros(rise.shape, dtype=bool)
    beside[indices[turns]] = beside[indices[turns + 1]] = True
    return beside


def refined(rise: xr.DataArray, resolution: int, limit: float | None = None) -> xr.DataArray:
    """Interpolate a decisive rise [K] onto so many loads and velocities, evenly spaced.

    The surface passes through the boundary that `boundary` finds for each load and each velocity.
    It is NaN beyond the outermost points that are done. With a limit, above which wear is severe
    [K], it is extrapolated as a power of velocity: below mild points and above severe ones.
    """
    loads, velocities = rise["load"].values, rise["velocity"].values
    axes = {
        "load": np.linspace(loads[0], loads[-1], resolution),
        "velocity": np.linspace(velocities[0], velocities[-1], resolution),
    }

    def at_velocities(row: Array) -> Array:
        if limit is None:
            return interpolated(velocities, row, axes["velocity"])
        return certain(velocities, row, axes["velocity"], limit)

    rows = np.apply_along_axis(at_velocities, -1, rise.values)
    plane = np.apply_along_axis(lambda column: interpolated(loads, column, axes["load"]), -2, rows)
    coords = {
        name: (name, axes[str(name)], coord.attrs) if name in axes else coord.variable
        for name, coord in rise.coords.items()
    }
    return xr.DataArray(plane, coords, rise.dims, rise.name, rise.attrs)


@by_scene
def decisive_temperature(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
) -> xr.DataArray:
    """Deciding temperature of the contact at each point, the highest while its load is held.

    Wear is severe where it lies above the critical temperature.

    Parameters
    ----------
    ds, friction, bulk_temperature, critical_temperature, share, criterion, own_laws
        See `boundary`.

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
    ds = plane_of(ds)
    conditions = conditions_of(
        ds, friction, bulk_temperature, critical_temperature, share, criterion, own_laws
    )
    rise = decisive_rise(ds, conditions)
    temperature = contact_temperature(rise, conditions)
    temperature.attrs = {
        "units": "K",
        "long_name": f"deciding temperature, {conditions.decisive.temperature}",
        **attributes_by(conditions),
    }
    return temperature.rename("decisive_temperature")


@by_scene
def temperatures(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
) -> xr.Dataset:
    """Temperatures of the contact, at each station of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, a part of it, or the path of a store. The whole of a large
        sweep takes much memory: select loads and velocities first.
    friction, bulk_temperature, critical_temperature
        See `boundary`.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact, ``temperature_quantile`` that a
        share ``cooler_share`` of the contact area stays below [K]; and, where there is a critical
        temperature, ``failed_fraction``, the share of the contact area above it.

    Examples
    --------
    >>> import pipeline
    >>> point = pipeline.open_sweep("results/first_try.zarr").sel(load=600, velocity=1.6)
    >>> end = pipeline.end_of_point(point)
    >>> pipeline.temperatures(end)["max_temperature"].round().item()
    436.0
    >>> pipeline.temperatures(end, friction=0.12)["max_temperature"].round().item()
    463.0
    """
    # No temperature depends on the criterion, and that of a store may be code.
    conditions = conditions_of(
        ds, friction, bulk_temperature, critical_temperature, criterion="share"
    )
    rises = sweep_at_bulks(ds, conditions)
    attributes = attributes_by(conditions)
    del attributes["criterion"]
    result = xr.Dataset(attrs=attributes)
    for name, rise, meaning in (
        ("max_temperature", "max_rise", "highest temperature"),
        ("mean_temperature", "mean_rise", "mean temperature"),
        ("temperature_quantile", "rise_quantile", "quantile of the temperature"),
    ):
        result[name] = contact_temperature(rises[rise], conditions).drop_attrs()
        result[name].attrs = {"units": "K", "long_name": f"{meaning} of the contact"}
    if conditions.critical_temperature is not None:
        share = xr.apply_ufunc(
            failed_fraction,
            rises["rise_quantile"],
            input_core_dims=[["cooler_share"]],
            kwargs={"conditions": conditions},
            vectorize=True,
        )
        result["failed_fraction"] = share.where(rises["max_rise"].notnull())
        result["failed_fraction"].attrs = {
            "units": "1",
            "long_name": "share of the contact above the critical temperature",
        }
    return result

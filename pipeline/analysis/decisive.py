"""The rise that decides at each point of a stored sweep."""

from __future__ import annotations

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import dataset_of, values_of
from pipeline.analysis.interpolation import certain, interpolated
from pipeline.analysis.soundness import deciding, require_sound
from pipeline.store.schema import DONE, PLANE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import columns_needed, rise_limit, worst_rises
from tribo import InputError
from tribo.types import Array


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
    require_sound(ds, deciding(is_done, rises, limit, *dims), *dims)
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

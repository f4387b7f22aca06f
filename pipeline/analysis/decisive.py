"""The rise that decides at each point of a stored sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import dataset_of, values_of, variant_of
from pipeline.analysis.interpolation import certain, interpolated
from pipeline.store.schema import DONE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import decisive_rises
from pipeline.sweep.rises import columns_needed


def with_rises(ds: xr.Dataset, conditions: Sequence[Conditions]) -> xr.Dataset:
    """Load what decides under some conditions, and leave out the other quantiles."""
    stored, names = ds["quantile"].values, ["normal_load"]
    columns = {judged.decisive.column for judged in conditions}
    names += [*columns, *(name for judged in conditions for name in columns_needed(judged))]
    if "rise_quantile" in columns:
        wanted = [
            judged.decisive.quantile
            for judged in conditions
            if judged.decisive.column == "rise_quantile"
        ]
        levels = [level for level in wanted if level is not None]
        if len(levels) == len(wanted) and stored[0] <= min(levels) <= max(levels) <= stored[-1]:
            first = max(int(np.searchsorted(stored, min(levels))) - 1, 0)
            last = max(int(np.searchsorted(stored, max(levels))), first + 1)
            ds = ds.isel(quantile=slice(first, last + 1))
    return ds.assign({name: ds[name].load() for name in dict.fromkeys(names) if name in ds})


def decisive_rise(ds: xr.Dataset, conditions: Conditions | Sequence[Conditions]) -> xr.DataArray:
    """Rise, at friction 1, that decides at each point.

    It is the highest one from when the load of a point is reached on: at the end of the ramp or,
    where the load is held, at any later step at which the temperature was asked for.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    conditions : Conditions, or several
        Conditions to judge by, or those of each surface or sample.

    Returns
    -------
    DataArray, dims (load, velocity), after ``realization`` over several surfaces
        Rise [K], sorted along all axes; NaN at points that are pending or failed.
    """
    ds, axis = dataset_of(ds), variant_of(ds)
    several = [conditions] if isinstance(conditions, Conditions) else list(conditions)
    ds = with_rises(ds, several)
    names = ["normal_load", *(judged.decisive.column for judged in several)]
    names += [name for judged in several for name in columns_needed(judged)]
    columns = {name: values_of(ds, name) for name in dict.fromkeys(names) if name in ds}
    loads, levels = ds["load"].values[:, None, None], {"quantile": ds["quantile"].values}
    if len({(one.decisive, one.bulk_ratio, one.corrections) for one in several}) == 1:
        rises = decisive_rises(columns | levels, loads, several[0])
    else:
        rises = np.array(
            [
                decisive_rises(
                    {name: values[number] for name, values in columns.items()} | levels,
                    loads,
                    judged,
                )
                for number, judged in enumerate(several)
            ]
        )
    kept = ("load", "velocity", "realization", "sample")
    return xr.DataArray(
        np.where(values_of(ds, "status") == DONE, rises, np.nan),
        {name: ds[name].variable for name in kept if name in ds.coords},
        [name for name in (axis, "load", "velocity") if name],
        "decisive_rise",
        {"units": "K", "long_name": "decisive rise at friction 1"},
    )


def refined(rise: xr.DataArray, resolution: int, limit: float | None = None) -> xr.DataArray:
    """Interpolate a decisive rise onto many loads and velocities, evenly spaced.

    The surface passes through the boundary that `boundary` finds for each load and each velocity.
    NaN beyond the outermost known points.

    Parameters
    ----------
    rise : DataArray, dims (..., load, velocity)
        Rise of `decisive_rise` [K].
    resolution : int
        Number of loads and of velocities.
    limit : float, optional
        Rise above which wear is severe [K]: at each load, go on below mild points and above severe
        ones, as a power of the velocity. Not if not given.
    """
    loads, velocities = rise["load"].values, rise["velocity"].values
    fine_loads = np.linspace(loads[0], loads[-1], resolution)
    fine = np.linspace(velocities[0], velocities[-1], resolution)
    rows = np.apply_along_axis(
        lambda row: (
            interpolated(velocities, row, fine)
            if limit is None
            else certain(velocities, row, fine, limit)
        ),
        -1,
        rise.values,
    )
    plane = np.apply_along_axis(lambda column: interpolated(loads, column, fine_loads), -2, rows)
    axes = {"load": fine_loads, "velocity": fine}
    coords = {
        name: (name, axes[str(name)], coord.attrs) if name in axes else coord.variable
        for name, coord in rise.coords.items()
    }
    return xr.DataArray(plane, coords, rise.dims, rise.name, rise.attrs)

"""The conditions that a stored sweep is judged by, the rise that decides, and temperatures."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import (
    dataset_of,
    keep_steps,
    read_conditions,
    require_lists,
    require_variables,
    scene_sweep,
    sweep_at_bulks,
    taken_at,
    values_of,
)
from pipeline.analysis.scenes import map_scenes
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE, PLANE, SCENE_ID
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import (
    columns_needed,
    equivalent_rise,
    failed_fraction,
    worst_rises,
)
from tribo import QUANTILES, Criterion, InputError
from tribo.simulation.corrections import NEEDED
from tribo.types import Array, Mask


def attributes_by(conditions: Conditions) -> dict[str, Any]:
    """Conditions as attributes of types that netCDF can store; corrections as JSON."""
    plain = conditions.as_dict()
    if "corrections" in plain:
        plain["corrections"] = json.dumps(plain["corrections"])
    return plain


def decisive_rise(ds: xr.Dataset, conditions: Conditions) -> xr.DataArray:
    """Rise at friction 1 that decides at each point [K], dims (..., load, velocity), or NaN."""
    ds = dataset_of(ds)
    require_lists(ds, *PLANE)
    column = conditions.decisive.column
    corrected = NEEDED if conditions.corrections else ()
    ds = keep_steps(ds, "status", "normal_load", column, "cooler_share", *corrected)
    names = ["normal_load", column, *columns_needed(conditions)]
    columns = {name: values_of(ds, name) for name in dict.fromkeys(names) if name in ds}
    columns["quantile"] = ds["cooler_share"].values
    rises = worst_rises(columns, ds["load"].values[:, None, None], conditions)
    rises = equivalent_rise(rises, solved_rises(ds, conditions), conditions)
    dims = [*(str(name) for name in ds["status"].dims if name not in PLANE), *PLANE]
    is_done = values_of(ds, "status") == DONE
    rises = np.where(is_done, rises, np.nan)
    return xr.DataArray(
        rises,
        {name: ds[name].variable for name in ("realization", *dims) if name in ds.coords},
        dims,
        "decisive_rise",
        {"units": "K", "long_name": "decisive rise at friction 1"},
    )


def solved_rises(ds: xr.Dataset, conditions: Conditions) -> Array:
    """Rises by solved friction over its coefficient [K], NaN at points not solved for conditions.

    The order of points is that of `decisive_rise`.
    """
    solved = scene_sweep(ds).variant(taken_at(ds)).scene.solved_friction
    if solved is None or solved != conditions.solved_friction or "coupled_rise" not in ds:
        return np.array(np.nan)
    return np.asarray(values_of(ds, "coupled_rise"))


def strip_friction(rise: xr.DataArray, conditions: Conditions) -> xr.DataArray:
    """A decisive rise [K] without the friction factor of its velocity, if there is one."""
    velocities = rise["velocity"]
    return rise / velocities.copy(data=conditions.friction_factor(velocities.values))


def boundary_neighbours(rises: Array, limit: float) -> Mask:
    """Points of rises (..., n_load, n_velocity) [K] whose next known one is across the limit."""
    along_both = (np.apply_along_axis(_turns, axis, rises, limit) for axis in (-2, -1))
    return np.logical_or(*along_both)


def _turns(rise: Array, limit: float) -> Mask:
    """Known points of a row with the other kind of wear at the next known one on either side."""
    (indices,), severe = np.nonzero(np.isfinite(rise)), Criterion.is_severe(rise, limit)
    turns = np.flatnonzero(severe[indices[:-1]] != severe[indices[1:]])
    beside = np.zeros(rise.shape, dtype=bool)
    beside[indices[turns]] = beside[indices[turns + 1]] = True
    return beside


@np.errstate(under="ignore")
def temperatures(ds: xr.Dataset | PathLike) -> xr.Dataset:
    """Temperatures of the contact, at each step of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, a part of it, or the path of a store. The
        whole of a large sweep takes much memory: select loads and velocities first.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact, ``temperature_quantile`` that a
        share ``cooler_share`` of the contact area stays below [K]; and, where there is a critical
        temperature, ``failed_fraction``, the share of the contact area above it. Where friction
        depends on temperature each part has that of its own; the run solves the deciding
        temperature alone.

    Examples
    --------
    >>> import pipeline
    >>> point = pipeline.open_sweep("results/first_try.zarr").sel(load=600, velocity=1.6)
    >>> end = pipeline.end_of_point(point)
    >>> pipeline.temperatures(end)["max_temperature"].round().item()
    436.0
    >>> hotter = pipeline.at(end, friction=0.12)
    >>> pipeline.temperatures(hotter)["max_temperature"].round().item()
    464.0
    """
    # No temperature depends on the criterion.
    found = map_scenes(ds, lambda scene: _temperatures(scene, read_conditions(scene, False)))
    return found.drop_vars(SCENE_ID, errors="ignore")  # so that it merges with any dataset


def _temperatures(ds: xr.Dataset, conditions: Conditions) -> xr.Dataset:
    """Temperatures of one scene."""
    require_variables(ds, "max_rise", "mean_rise", "rise_quantile", "cooler_share")
    if ds["cooler_share"].size < len(QUANTILES):
        raise InputError(
            f"the dataset has {ds['cooler_share'].size} of {len(QUANTILES)} shares of the contact "
            "(cooler_share), and needs all; select some from the result"
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
        plain = rises[rise].drop_attrs()
        result[name] = plain.copy(data=conditions.contact_temperature(plain.values))
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

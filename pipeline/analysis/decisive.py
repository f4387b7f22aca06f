"""The conditions that a stored sweep is judged by, the rise that decides, and temperatures."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import (
    dataset_of,
    entry_dims,
    read_conditions,
    require_variables,
    sweep_at_bulks,
)
from pipeline.analysis.results import results
from pipeline.analysis.scenes import scenes, side_by_side
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE, SCENE_ID
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import failed_fraction
from tribo import QUANTILES, InputError


def attributes_by(conditions: Conditions) -> dict[str, Any]:
    """Conditions as attributes of types that netCDF can store; corrections as JSON."""
    plain = conditions.as_dict()
    if "corrections" in plain:
        plain["corrections"] = json.dumps(plain["corrections"])
    return plain


def decisive_rise(ds: xr.Dataset, conditions: Conditions) -> xr.DataArray:
    """Rise at friction 1 that decides at each point [K], dims (..., load, velocity), or NaN."""
    held = results(ds)
    dims = [*held.front, *PLANE]
    return xr.DataArray(
        held.rises(conditions),
        {name: ds[name].variable for name in ("realization", *dims) if name in ds.coords},
        dims,
        "decisive_rise",
        {"units": "K", "long_name": "decisive rise at friction 1"},
    )


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
    ds = dataset_of(ds)
    answers = [_temperatures(scene, read_conditions(scene, False)) for scene in scenes(ds)]
    found = side_by_side(answers, [ds[name] for name in entry_dims(ds)])
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

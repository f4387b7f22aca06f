"""Temperatures of the contact, and conditions as attributes of a dataset."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr

from pipeline.analysis.at import ConditionKeywords, at
from pipeline.analysis.dataset import dataset_of
from pipeline.analysis.reading import results
from pipeline.analysis.results import Results
from pipeline.analysis.scenes import side_by_side
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.conditions import Conditions, plain_values, rise_limit
from tribo import QUANTILES, InputError
from tribo.simulation.severity import rises_above_colder
from tribo.thermal import failed_share
from tribo.types import Array


def attributes_by(conditions: Conditions) -> dict[str, Any]:
    """Conditions by name as dataset attributes that netCDF can store; corrections become JSON."""
    plain = plain_values(conditions)
    if "corrections" in plain:
        plain["corrections"] = json.dumps(plain["corrections"])
    return plain


@np.errstate(under="ignore")
def temperatures(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionKeywords]) -> xr.Dataset:
    """Temperatures of the contact at each step of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, a part of such a dataset that keeps
        ``status``, or the path of a store. A whole large sweep takes much memory: select loads and
        velocities first.
    **conditions
        Conditions to judge by, as in `pipeline.at`, such as ``friction=0.12``.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact [K]; ``temperature_quantile``,
        the temperature [K] that a share ``cooler_share`` of the contact stays below; and, with a
        critical temperature, ``failed_fraction``, the share of the contact area above it.

        If friction depends on temperature, each temperature T is computed as if the whole contact
        had the friction at T. Verdicts use the run's own solution instead, in which each element
        has the friction at its own temperature. A run solves this only for the temperature that the
        criterion compares with the critical temperature.

    Raises
    ------
    InputError
        If the dataset lacks a variable, or some of the shares ``cooler_share``.

    Examples
    --------
    >>> import pipeline
    >>> point = pipeline.open_sweep("results/first_try.zarr").sel(load=600, velocity=1.6)
    >>> end = pipeline.end_of_point(point)
    >>> pipeline.temperatures(end)["max_temperature"].round().item()
    436.0
    >>> pipeline.temperatures(end, friction=0.12)["max_temperature"].round().item()
    464.0
    """
    ds = at(ds, **conditions) if conditions else dataset_of(ds)
    held = results(ds.drop_vars("step", errors="ignore"))  # any step will do
    like = ds.isel(dict.fromkeys(held.entry_dims, 0), missing_dims="ignore")
    answers = [_temperatures(scene, like) for scene in held.scenes]
    return side_by_side(answers, [held.rows[name] for name in held.entry_dims])


def _temperatures(scene: Results, like: xr.Dataset) -> xr.Dataset:
    """Highest, mean and quantiles of the contact temperature [K] of one scene, as `like`."""
    scene.require("max_rise", "mean_rise", "rise_quantile")
    if len(scene.shares) < len(QUANTILES):
        raise InputError(
            f"the dataset has {len(scene.shares)} of {len(QUANTILES)} shares of the contact "
            "(cooler_share), and needs all; select some from the result"
        )
    conditions = scene.plain_conditions  # no temperature depends on the criterion
    rises = rises_above_colder(scene.columns, conditions)
    attributes = attributes_by(conditions)
    del attributes["criterion"]
    result = xr.Dataset(attrs=attributes)
    for name, rise, meaning in (
        ("max_temperature", "max_rise", "highest temperature"),
        ("mean_temperature", "mean_rise", "mean temperature"),
        ("temperature_quantile", "rise_quantile", "quantile of the temperature"),
    ):
        dims = [*scene.front, *PLANE, "step", "cooler_share"][: rises[rise].ndim]
        result[name] = _shaped(like[rise], dims, conditions.contact_temperature(rises[rise]))
        result[name].attrs = {"units": "K", "long_name": f"{meaning} of the contact"}
    if conditions.critical_temperature is not None:
        failed = np.vectorize(failed_share, excluded=[1], signature="(q)->()")
        share = failed(rises["rise_quantile"], rise_limit(conditions))
        share = np.where(np.isnan(rises["max_rise"]), np.nan, share)
        result["failed_fraction"] = _shaped(like["max_rise"], dims[:-1], share)
        result["failed_fraction"].attrs = {
            "units": "1",
            "long_name": "share of the contact above the critical temperature",
        }
    return result


def _shaped(like: xr.DataArray, dims: Sequence[str], values: Array) -> xr.DataArray:
    """Array with the dimensions and coordinates of `like`, and new `values` along `dims`."""
    whole = xr.Variable(dims, values)
    cut = whole.isel({name: 0 for name in dims if name not in like.dims})
    return like.drop_attrs().copy(data=cut.transpose(*like.dims).values)

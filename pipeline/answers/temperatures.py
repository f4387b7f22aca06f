"""Temperatures of the contact at each step of each point."""

from __future__ import annotations

from typing import Any, Unpack, cast

import numpy as np
import xarray as xr

from pipeline.answers.conditions import ConditionValues, judged
from pipeline.answers.results import cases_of, dataset_of, sweep_of, sweeps_of
from pipeline.answers.verdict import conditions_of
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import allowable_rise
from tribo import QUANTILES, InputError
from tribo.simulation.severity import columns_needed, corrected_columns
from tribo.thermal.quantiles import failed_share

_MEANINGS = {
    "max_temperature": ("max_rise", "highest temperature of the contact"),
    "mean_temperature": ("mean_rise", "mean temperature of the contact"),
    "temperature_quantile": ("rise_quantile", "quantile of the temperature of the contact"),
}
_INNER = ("step", "area_fraction_below")


@np.errstate(under="ignore")
def temperatures(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Temperatures of the contact at each step of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, a part of it that keeps ``status``, or path of a store. A
        whole large sweep takes much memory: select loads and velocities first.
    **conditions
        Conditions to judge by, as in `pipeline.margin`, such as ``friction=0.12``.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact [K]; ``temperature_quantile``,
        the temperature [K] that a share ``area_fraction_below`` of the contact stays below; and,
        with a critical temperature, ``failed_area_fraction``, the share of the contact area above
        it.

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
    ds = dataset_of(ds)
    from_tests = sweep_of(ds).base.critical_from_tests
    if len(ds["area_fraction_below"]) < len(QUANTILES):
        raise InputError(
            f"the dataset has {len(ds['area_fraction_below'])} of {len(QUANTILES)} values of "
            "area_fraction_below, and needs all; select some from the result"
        )
    whole = list[xr.Dataset]()
    known = [conditions_of(one, conditions) for one in cases_of(ds)] if from_tests else []
    for number, (case, part) in enumerate(sweeps_of(ds)):
        own = known[number] if known else judged(case.conditions, conditions)
        names = {"max_rise", "mean_rise", "rise_quantile", *columns_needed(own)}
        axes, like = (*part["status"].dims, *_INNER), part["status"]
        held = {
            name: part[name].broadcast_like(like).transpose(*axes, missing_dims="ignore")
            for name in names
        }
        rises = corrected_columns({name: one.values for name, one in held.items()}, own)
        found = xr.Dataset()
        for name, (rise, meaning) in _MEANINGS.items():
            found[name] = held[rise].copy(data=own.contact_temperature(rises[rise]))
            found[name].attrs = {"units": "K", "long_name": meaning}
        if own.critical_temperature is not None:
            failed = np.vectorize(failed_share, excluded=[1], signature="(q)->()")
            share = failed(rises["rise_quantile"], allowable_rise(own))
            share = np.where(np.isnan(rises["max_rise"]), np.nan, share)
            found["failed_area_fraction"] = held["max_rise"].copy(data=share)
            found["failed_area_fraction"].attrs = {
                "units": "1",
                "long_name": "share of the contact above the critical temperature",
            }
        whole.append(found)
    joined: Any = whole[0] if len(whole) == 1 else xr.combine_by_coords(whole)
    return cast(xr.Dataset, joined)

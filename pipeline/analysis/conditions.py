"""The conditions that a sweep is judged by: its own, and those that are given in their place.

The wear rate is one of them where the table of variants has several. A point at the velocity V and
the sweep's own rate k has the contacts of V' = Vk/k' at the rate k', so that rows at several rates
share contacts. Between them the logarithm of the rise is interpolated over that of the rate, as it
is between velocities.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import scipy  # loads its parts when they are used
import xarray as xr

from pipeline.analysis.dataset import (
    attributes_of,
    dataset_of,
    is_emulated,
    own_wear_rate,
    with_wear_rates,
)
from pipeline.scene.faults import quoted
from pipeline.scene.units import display, in_si, share_of
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions, changes_of
from pipeline.sweep.criterion import require_bulks
from pipeline.sweep.own_laws import OwnLawError
from pipeline.sweep.variants import WEAR_RATE
from tribo import InputError
from tribo.types import Array

Bulk = float | str | Mapping[str, float | str]
"""A bulk temperature [K] or with a unit; or one for each body, by ``"pin"`` and ``"disk"``."""

CONDITIONS = (
    "friction", "bulk_temperature", "critical_temperature", "share", "criterion", "own_laws",
)  # fmt: skip
"""Names of the conditions that may be given in place of the sweep's own, and the permission."""

_STORED = {entry.name for entry in fields(Conditions)} - {"own_criterion"}
COLDEST_OIL, HOTTEST_OIL = 220.0, 900.0
"""Bulk temperatures between which an oil may work [K]."""


def conditions_of(
    ds: xr.Dataset,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
) -> Conditions:
    """Take the sweep's own conditions, and those that are given in their place."""
    bulk: Any = bulk_temperature
    stored = attributes_of(ds).get("conditions") or {}
    values = {name: value for name, value in stored.items() if name in _STORED} | changes_of(
        friction,
        {body: _kelvin("bulk_temperature", one) for body, one in bulk.items()}
        if isinstance(bulk, Mapping)
        else _kelvin("bulk_temperature", bulk),
        _kelvin("critical_temperature", critical_temperature),
        None if share is None else share_of(share),
        criterion,
        own_laws,
    )
    named = str(values.get("criterion", ""))
    if ":" in named and "own_criterion" not in values:
        raise OwnLawError(
            f"the store was judged by the criterion {quoted(named)} (SHA-256 "
            f"{stored.get('criterion_hash')}), which is code, and nothing that a store names is "
            f"run; give --criterion={quoted(named)} --own-laws in the folder of its file, or "
            "another, such as --criterion=share"
        )
    for name in ("friction", "failing_share", "bulk_temperature"):
        if values.get(name) is None:
            raise InputError(f"the sweep has no {name} of its own; give one")
    conditions = Conditions(**values)
    require_bulks(ds, conditions)
    if conditions.friction and not attributes_of(ds).get("scene", {}).get("friction_heat", True):
        raise InputError(
            f"friction is {conditions.friction:g}; the sweep was computed without friction, and "
            "so without any heat: run it again with friction, into another store"
        )
    return conditions


def _kelvin(name: str, value: float | str | None) -> float | None:
    """Read a temperature [K], and refuse one at which no oil works."""
    if isinstance(value, str):
        value = in_si(name, value, "80 degC")
    if value is None or isinstance(value, Iterable):
        return value  # several are refused with the other conditions
    hottest = HOTTEST_OIL if name == "bulk_temperature" else np.inf
    if value < COLDEST_OIL or hottest < value < np.inf:
        raise InputError(
            f"{name} is {value - 273.15:.4g} °C ({value:g} K), at which no oil works; give one "
            f"from {COLDEST_OIL - 273.15:.4g} °C on; in Python a plain number is in kelvins, and "
            'text has its unit, such as "80 degC"'
        )
    return value


def attributes_by(conditions: Conditions) -> dict[str, Any]:
    """Conditions as attributes of types that netCDF can store; corrections as JSON."""
    plain = conditions.as_dict()
    if "corrections" in plain:
        plain["corrections"] = json.dumps(plain["corrections"])
    return plain


_EXAMPLE = "2e-6 mm^3/(N m)"


def at_wear_rate(ds: xr.Dataset | PathLike, wear_rate: float | str | None) -> xr.Dataset:
    """Take a sweep at a specific wear rate, without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store, of a scene with
        ``[sweep] wear_rates``.
    wear_rate : float or str or None
        Specific wear rate [m²/N] or text such as ``"2e-6 mm^3/(N m)"``, within those of the sweep;
        its own if None.

    Returns
    -------
    Dataset
        The sweep with its contacts at the velocities at which this rate has them, and their rises;
        these only from when the load of a point is reached on. Without fields, since those were
        stored at the sweep's own rate alone. The attribute ``wear_rate`` is the rate [m²/N].

    Raises
    ------
    InputError
        If the sweep does not answer for that wear rate.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> pipeline.at_wear_rate(ds, "2e-6 mm^3/(N m)")
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: wear_rate is 2e-06 mm³/(N m); the sweep was computed for its own \
rate alone, 1.2e-06 mm³/(N m): give its scene sweep.wear_rates, and run it into another store
    """
    rows, ds = with_wear_rates(ds), dataset_of(ds)
    if wear_rate is None:
        return ds
    rate = in_si("wear_rate", wear_rate, _EXAMPLE)
    if is_emulated(ds):
        raise InputError(
            f"wear_rate is {display(rate, 'mm³/(N m)', 4)}, but these samples have it as an input; "
            f'give --at "wear.specific_wear_rate={rate * 1e9:g} mm^3/(N m)", in Python '
            "pipeline.Ensemble.of"
        )
    attributes = attributes_of(ds)
    stored_rate = own_wear_rate(ds)
    if rate == stored_rate:
        return ds.assign_attrs(wear_rate=rate)
    _require_known(rate, stored_rate, rows)

    def at_rate(name: str) -> xr.DataArray:
        values = rows[name].transpose(*ds[name].dims, WEAR_RATE).values
        return ds[name].copy(data=_power_law(rows[WEAR_RATE].values, values, rate))

    quantile = at_rate("rise_quantile")
    highest = quantile.isel(cooler_share=-1).assign_attrs(ds["max_rise"].attrs)
    scale = stored_rate / rate
    velocities = ds["velocity"] * scale
    own_range = [velocity * scale for velocity in attributes.get("velocities", [])]
    left_out = [name for name in ds.data_vars if "x" in ds[name].dims]
    return (
        ds.drop_vars(left_out)
        .assign(
            rise_quantile=quantile,
            mean_rise=at_rate("mean_rise"),
            max_rise=highest,
            sliding_distance=(ds["sliding_distance"] * scale).assign_attrs(
                ds["sliding_distance"].attrs
            ),
            pin_heat_share=at_rate("pin_heat_share"),
        )
        .assign_coords({"velocity": velocities.assign_attrs(ds["velocity"].attrs), WEAR_RATE: rate})
        .assign_attrs(
            wear_rate=rate,
            velocities=json.dumps(own_range),
            title=f"{attributes.get('title')}, wear rate {display(rate, 'mm³/(N m)', 4)}",
        )
    )


def _require_known(rate: float, stored_rate: float, rows: xr.Dataset) -> None:
    text = f"wear_rate is {display(rate, 'mm³/(N m)', 4)}; the sweep was computed for"
    if not stored_rate:
        raise InputError(f"{text} a pin that does not wear, and has no others")
    if WEAR_RATE not in rows.dims:
        raise InputError(
            f"{text} its own rate alone, {display(stored_rate, 'mm³/(N m)', 4)}: give its scene "
            "sweep.wear_rates, and run it into another store"
        )
    low, high = rows[WEAR_RATE].values[[0, -1]].tolist()
    if not low * (1 - 1e-9) <= rate <= high * (1 + 1e-9):
        ends = " to ".join(display(end, "mm³/(N m)", 4) for end in (low, high))
        raise InputError(f"{text} {ends}: give one within")


def _power_law(rates: Array, rises: Array, rate: float) -> Array:
    """Rises at a rate, between those at others along the last axis; NaN where one is not known."""
    positive = np.all(rises > 0, axis=-1, keepdims=True)
    logarithms = np.log(np.where(positive, rises, 1.0))
    curve = scipy.interpolate.PchipInterpolator(np.log(rates), logarithms, axis=-1)
    power_law = np.exp(curve(np.log(rate)))
    is_finite = np.isfinite(rises).all(axis=-1)
    return np.where(is_finite, np.where(positive[..., 0], power_law, 0.0), np.nan)

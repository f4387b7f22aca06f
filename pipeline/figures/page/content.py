"""Data of a sweep in a page: all that its boundary rests on, in full; the rest to look at.

Numbers go in as base64 of little-endian arrays, in the order surface, load, velocity.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import (
    asked,
    corrected,
    end_of_point,
    ordered,
    plane_of,
    values_of,
)
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.entries import entries_of
from pipeline.analysis.margin_error import error_table
from pipeline.analysis.transition import outcomes, range_of
from pipeline.analysis.wear_rate import at_wear_rate, own_wear_rate
from pipeline.figures.page.controls import controls
from pipeline.figures.page.fields import FIELDS, POINT, packed_fields
from pipeline.store.schema import DONE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.lubrication import Lubrication
from pipeline.sweep.rises import above_colder
from pipeline.sweep.selection import Selection
from tribo import Criterion
from tribo.types import Array, Mask

MOST_FIELDS = 500
"""Number of points whose fields a page holds unless told otherwise, some 5 MB."""

_OIL_TEMPERATURES = np.arange(220.0, 601.0, 1.0)  # [K]

_NUMBERS = (
    ("contact_width", "contact width", "µm", 1e6, 0),
    ("contact_fraction", "contact area", "% of the window", 100.0, 0),
    ("mean_pressure", "mean pressure", "GPa", 1e-9, 0),
    ("max_pressure", "highest pressure", "GPa", 1e-9, 0),
    ("saturated_fraction", "contact at the hardness", "%", 100.0, 0),
    ("wear_depth_max", "wear depth", "µm", 1e6, 0),
    ("wear_volume", "worn volume", "mm³", 1e9, 0),
    ("pin_heat_share", "pin’s share of the heat", "%", 100.0, None),
    ("sliding_distance", "sliding distance", "m", 1.0, -1),
    ("time", "duration", "s", 1.0, 0),
)
"""Numbers of a point: variable, label, unit, its factor, and the power of the wear rate that they
follow; None where they are known at the sweep's own alone."""


def content(ds: xr.Dataset, most_fields: int = MOST_FIELDS, **criterion: Any) -> dict[str, Any]:
    """Collect what a page shows, as plain data.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    most_fields : int
        Number of points whose fields to take, those nearest to the transition.
    **criterion
        The criterion in place of the sweep's own, and permission to run it.
    """
    ds = ordered(plane_of(ds))
    attributes = attributes_of(ds)
    conditions = conditions_of(ds, **criterion)
    unequal = ds["bulk_ratio"].values.tolist() if "bulk_ratio" in ds.coords else []
    ratios, shares = sorted([*unequal, 0.0]), _shares(ds, conditions)
    stored, rates = _wear_rates(ds)
    systems = [corrected(at_wear_rate(ds, rate), conditions) for rate in rates or (None,)]
    tables = [_tables(system, conditions.decisive, ratios, shares) for system in systems]
    decisive, rises = (np.stack(table, axis=-3) for table in zip(*tables, strict=True))
    status = values_of(ds, "status")
    done = status == DONE
    moments, steps = _kept_steps(done, decisive, ds)
    end = end_of_point(ds[[name for name, *_ in _NUMBERS if name in ds]])
    has_heat = attributes.get("scene", {}).get("friction_heat", True)
    has_fields = set(FIELDS) <= set(ds.data_vars)
    chosen = _nearest(ds, done, conditions, most_fields) if has_fields else []
    return {
        "title": attributes.get("title"),
        "name": attributes.get("name"),
        "conditions": _conditions(ds, conditions) | ({"wear_rate": rates[stored]} if rates else {}),
        "controls": [
            asdict(control)
            for control in controls(conditions, has_heat, len(ratios) > 1, len(shares) > 1, rates)
        ],
        "measured": attributes.get("measured") or [],
        "friction_band": attributes.get("friction_band"),
        "film": _film(attributes, ds),
        "chosen": bool(attributes.get("boundary_only")),
        "range": {name: range_of(ds, name) for name in ("load", "velocity")},
        "outcomes": {axis: list(outcomes(axis).values()) for axis in ("velocity", "load")},
        "errors": packed(error_table(ds, decisive_rise(ds, conditions)), "<f4"),
        "deciding": conditions.decisive.temperature,
        "loads": ds["load"].values.tolist(),
        "velocities": ds["velocity"].values.tolist(),
        "quantiles": ds["quantile"].values.tolist(),
        "surfaces": ds["realization"].values.tolist() if "realization" in ds.dims else None,
        "done": int(done.sum()),
        "status": packed(status, "i1"),
        "asked": packed(asked(ds).transpose(*POINT, missing_dims="ignore"), "u1"),
        "moments": packed(moments, "<i4"),
        "moment_times": packed(values_of(ds, "time")[steps], "<f4"),
        "wear_rates": rates,
        "bulk_ratios": ratios,
        "shares": shares,
        "decisive": packed(decisive[steps], "<f8"),
        "rises": packed(rises[steps], "<f4"),
        "numbers": [
            {"label": label, "unit": unit, "power": power}
            | {"values": packed(factor * values_of(end, name), "<f4")}
            for name, label, unit, factor, power in _NUMBERS
            if name in ds
        ],
        "messages": {
            str(place): str(message)
            for place, message in enumerate(values_of(ds, "message").ravel())
            if message
        },
        "fields": packed_fields(ds, chosen) | {"stored": int(done.sum()) * has_fields},
        "record": record(attributes),
    }


def _wear_rates(ds: xr.Dataset) -> tuple[int, list[float]]:
    """Place of the sweep's own among the wear rates that it answers for, and these [m²/N]."""
    if "wear_rate" not in ds.coords:
        return 0, []
    stored_rate = own_wear_rate(ds)
    rates = sorted({stored_rate, *ds["wear_rate"].values.tolist()})
    return rates.index(stored_rate), rates


def _shares(ds: xr.Dataset, conditions: Conditions) -> list[float]:
    """Failing shares at which the deciding rise is tabulated, ascending: it is linear between them.

    The scene's own alone for a criterion that does not depend on it.
    """
    failing_share = conditions.failing_share
    if not conditions.decisive.takes_share:
        return [failing_share]
    shares = np.minimum(np.round(1 - ds["quantile"].values, 12), np.nextafter(1.0, 0.0))
    return [float(share) for share in np.union1d(shares, failing_share)]


def _kept_steps(
    done: Mask, decisive: Array, ds: xr.Dataset
) -> tuple[NDArray[np.intp], tuple[NDArray[np.intp], ...]]:
    """Number of steps of each point that are kept, and their indices in the order of the points."""
    normal_load, loads = values_of(ds, "normal_load"), ds["load"].values
    moments, kept = np.zeros(done.shape, dtype=np.intp), []
    for place in zip(*np.nonzero(done), strict=True):
        rows = decisive[place].reshape(decisive.shape[done.ndim], -1)
        steps = _moments(rows, normal_load[place], float(loads[place[-2]]))
        moments[place] = steps.size
        kept += [(*place, step) for step in steps]
    indices = np.array(kept, dtype=np.intp).reshape(-1, done.ndim + 1)
    return moments, tuple(indices.T)


def _tables(
    ds: xr.Dataset, criterion: Criterion, ratios: list[float], shares: list[float]
) -> tuple[Array, Array]:
    """Deciding rises by share, and quantiles, by load, velocity, step and bulk ratio [K]."""
    names = ("rise_quantile", "mean_rise", "bulk_rise_quantile", "mean_bulk_response")
    columns = {name: values_of(ds, name) for name in names if name in ds}
    quantile = {"quantile": ds["quantile"].values}
    at_ratios = [{**above_colder(columns, ratio), **quantile} for ratio in ratios]
    criteria = [replace(criterion, share=share) for share in shares]
    decisive = [np.stack([one.rise(rises) for one in criteria], axis=-1) for rises in at_ratios]
    quantiles = [rises["rise_quantile"] for rises in at_ratios]
    return np.stack(decisive, axis=-2), np.stack(quantiles, axis=-2)


def _moments(rises: Array, normal_load: Array, load: float) -> NDArray[np.intp]:
    """Steps at which a point may be at its worst, for one share or bulk ratio or another.

    Those from when the load is reached on (`pipeline.sweep.criterion.worst_moment`), without such
    as another is hotter than at all of them.

    Examples
    --------
    >>> hold = np.array([[0.0, 5.0], [1.0, 9.0], [1.0, 8.0], [2.0, 7.0], [np.nan, np.nan]])
    >>> _moments(hold, np.array([500.0, 600.0, 600.0, 600.0, 600.0]), 600.0).tolist()
    [1, 3]
    """
    is_finite = np.isfinite(rises.sum(axis=-1))
    counts = np.flatnonzero(is_finite & (normal_load >= load))
    if not counts.size and is_finite[-1]:
        counts = np.array([len(is_finite) - 1])
    kept: list[int] = []
    for step in counts.tolist():
        row = rises[step]
        if not any((rises[other] >= row).all() for other in kept):
            kept = [other for other in kept if not (row >= rises[other]).all()] + [step]
    return np.array(kept, dtype=np.intp)


def _film(attributes: Mapping[str, Any], ds: xr.Dataset) -> dict[str, Any] | None:
    """Film parameter as powers of load and velocity, times a factor of the bulk temperature."""
    lubrication = Lubrication.stored(attributes)
    if lubrication is None:
        return None
    load, velocity = float(ds["load"].max()), float(ds["velocity"].max()) or 1.0
    here = [
        lubrication.film_thickness(load, velocity, float(temperature))
        for temperature in _OIL_TEMPERATURES
    ]
    cold = float(_OIL_TEMPERATURES[0])
    halves = (
        lubrication.film_thickness(load / 2, velocity, cold),
        lubrication.film_thickness(load, velocity / 2, cold),
    )
    return {
        "load": load,
        "velocity": velocity,
        "powers": [math.log2(here[0] / half) for half in halves],
        "temperatures": _OIL_TEMPERATURES.tolist(),
        "logarithms": np.log(np.array(here) / lubrication.rms_height).tolist(),
    }


def record(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Entries of the scene with their units, and what computed the sweep."""
    selection = attributes.get("selection")
    return (
        entries_of(attributes)
        | ({"accuracy": str(Selection.from_dict(selection))} if selection else {})
        | {"history": str(attributes.get("history", ""))}
        | {"scene hash": str(attributes.get("scene_hash", ""))}
    )


def _conditions(ds: xr.Dataset, conditions: Conditions) -> dict[str, Any]:
    """The conditions of the sweep; that of the disk's bulk where it may differ from the pin's."""
    disk, bulk = conditions.disk_temperature, conditions.bulk_temperature
    plain = conditions.as_dict()
    if "bulk_rise_quantile" in ds:
        plain["disk_temperature"] = bulk if disk is None else disk
    return plain


def _nearest(
    ds: xr.Dataset, done: Mask, conditions: Conditions, most: int
) -> list[tuple[int, ...]]:
    """Choose the points whose fields to show: all, or those nearest to the transition."""
    places = np.argwhere(done)
    if len(places) > most:
        judged = conditions.critical_temperature is not None and conditions.rise_factor > 0
        limit = rise_limit(conditions) if judged else math.inf
        rise = np.nan_to_num(decisive_rise(ds, conditions).values[done])
        distance = np.abs(rise - min(limit, rise.max(initial=0.0)))
        places = places[np.sort(np.argsort(distance, kind="stable")[:most])]
    return [tuple(place) for place in places.tolist()]


def packed(values: Any, dtype: str) -> str:
    """An array as the base64 of its bytes."""
    return base64.b64encode(np.asarray(values, dtype=dtype).tobytes()).decode()

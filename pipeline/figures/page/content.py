"""Data of a sweep in a page: all that its boundary rests on, in full; the rest to look at.

Numbers go in as base64 of little-endian arrays, in the order surface, load, velocity.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import (
    asked,
    corrected,
    end_of_point,
    ordered,
    plane_of,
    variant_of,
)
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.entries import entries_of
from pipeline.analysis.transition import OUTCOMES, range_of
from pipeline.analysis.wear_rate import at_wear_rate, own_wear_rate
from pipeline.figures.page.controls import controls
from pipeline.figures.page.fields import FIELDS, packed_fields
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


def content(ds: xr.Dataset, most_fields: int = MOST_FIELDS) -> dict[str, Any]:
    """Collect what a page shows, as plain data.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    most_fields : int
        Number of points whose fields to take, those nearest to the transition.
    """
    ds = ordered(plane_of(ds))
    axis = variant_of(ds)
    surfaces = [ds] if axis is None else [ds.isel({axis: row}) for row in range(ds.sizes[axis])]
    attributes = attributes_of(ds)
    conditions = Conditions(**attributes["conditions"])
    unequal = ds["bulk_ratio"].values.tolist() if "bulk_ratio" in ds.coords else []
    ratios, shares = sorted([*unequal, 0.0]), _shares(ds, conditions)
    stored, rates = _wear_rates(ds)
    parts = [
        _on_surface(
            [corrected(at_wear_rate(part, rate), conditions) for rate in rates or (None,)],
            stored, conditions.criterion, ratios, shares,
        )
        for part in surfaces
    ]  # fmt: skip
    done = np.array([part["status"] == DONE for part in parts], dtype=bool)
    has_heat = attributes.get("scene", {}).get("friction_heat", True)
    chosen = _nearest(surfaces, done, conditions, most_fields) if _has_fields(ds) else []
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
        "outcomes": list(OUTCOMES.values()),
        "deciding": conditions.decisive.temperature,
        "loads": ds["load"].values.tolist(),
        "velocities": ds["velocity"].values.tolist(),
        "quantiles": ds["quantile"].values.tolist(),
        "surfaces": None if axis is None else ds[axis].values.tolist(),
        "done": int(done.sum()),
        "status": packed([part["status"] for part in parts], "i1"),
        "asked": packed([part["asked"] for part in parts], "u1"),
        "moments": packed([part["moments"] for part in parts], "<i4"),
        "moment_times": packed([part["times"] for part in parts], "<f4"),
        "wear_rates": rates,
        "bulk_ratios": ratios,
        "shares": shares,
        "decisive": packed([part["decisive"] for part in parts], "<f8"),
        "rises": packed([part["rises"] for part in parts], "<f4"),
        "numbers": [
            {"label": label, "unit": unit, "power": power}
            | {"values": packed([factor * part["end"][name] for part in parts], "<f4")}
            for name, label, unit, factor, power in _NUMBERS
            if name in ds
        ],
        "messages": {
            str(place): message
            for place, message in enumerate(text for part in parts for text in part["messages"])
            if message
        },
        "fields": packed_fields(surfaces, chosen) | {"stored": int(done.sum()) * _has_fields(ds)},
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


def _on_surface(
    systems: list[xr.Dataset],
    stored: int,
    criterion: str,
    ratios: list[float],
    shares: list[float],
) -> dict[str, Any]:
    """Data of each point on one surface, from the sweep at each wear rate, and at its own."""
    systems = [system.transpose("load", "velocity", "step", ...) for system in systems]
    tables = [_tables(system, criterion, ratios, shares) for system in systems]
    decisive, rises = (np.stack(table, axis=3) for table in zip(*tables, strict=True))
    ds = systems[stored]
    status, times = ds["status"].values, ds["time"].values
    normal_load = ds["normal_load"].values
    moments = np.zeros(status.shape, dtype=int)
    kept = []
    for place in zip(*np.nonzero(status == DONE), strict=True):
        rows = decisive[place].reshape(len(normal_load[place]), -1)
        steps = _moments(rows, normal_load[place], float(ds["load"][place[0]]))
        moments[place] = steps.size
        kept += [(*place, step) for step in steps]
    indices = tuple(np.array(kept, dtype=np.intp).reshape(-1, 3).T)
    end = end_of_point(ds[[name for name, *_ in _NUMBERS if name in ds]])
    return {
        "status": status,
        "asked": asked(ds).transpose("load", "velocity").values,
        "moments": moments,
        "times": times[indices],
        "decisive": decisive[indices],
        "rises": rises[indices],
        "end": {name: end[name].transpose("load", "velocity").values for name in end.data_vars},
        "messages": [str(message) for message in ds["message"].values.ravel()],
    }


def _tables(
    ds: xr.Dataset, criterion: str, ratios: list[float], shares: list[float]
) -> tuple[Array, Array]:
    """Deciding rises by share, and quantiles, by load, velocity, step and bulk ratio [K]."""
    names = ("rise_quantile", "mean_rise", "bulk_rise_quantile", "mean_bulk_response")
    columns = {name: ds[name].values for name in names if name in ds}
    quantile = {"quantile": ds["quantile"].values}
    at_ratios = [{**above_colder(columns, ratio), **quantile} for ratio in ratios]
    criteria = [Criterion(criterion, share) for share in shares]
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


def _has_fields(ds: xr.Dataset) -> bool:
    return set(FIELDS) <= set(ds.data_vars)


def _nearest(
    surfaces: list[xr.Dataset], done: Mask, conditions: Conditions, most: int
) -> list[tuple[int, int, int]]:
    """Choose the points whose fields to show: all, or those nearest to the transition."""
    places = np.argwhere(done)
    if len(places) > most:
        rises = np.array([decisive_rise(part, conditions) for part in surfaces])
        judged = conditions.critical_temperature is not None and conditions.rise_factor > 0
        limit = rise_limit(conditions) if judged else math.inf
        rise = np.nan_to_num(rises[done])
        distance = np.abs(rise - min(limit, rise.max(initial=0.0)))
        places = places[np.sort(np.argsort(distance, kind="stable")[:most])]
    return [(int(surface), int(load), int(velocity)) for surface, load, velocity in places]


def packed(parts: list[Any], dtype: str) -> str:
    """Arrays one after the other, as the base64 of their bytes."""
    joined = b"".join(np.ascontiguousarray(part, dtype=dtype).tobytes() for part in parts)
    return base64.b64encode(joined).decode()

"""What a page holds of a sweep: all that its boundary rests on, in full; the rest to look at.

Numbers go in as base64 of little-endian arrays, in the order surface, load, velocity.
"""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.dataset import asked, end_of_point, ordered, variant_of
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.transition import OUTCOMES, range_of
from pipeline.figures.page.fields import FIELDS, packed_fields
from pipeline.store.schema import DONE
from pipeline.sweep.criterion import Conditions, rise_limit
from tribo import Criterion, WarningKind
from tribo.types import Array, Mask

MOST_FIELDS = 500
"""Number of points whose fields a page holds unless told otherwise, some 5 MB."""

_SHOWN = (
    "time", "sliding_distance", "contact_fraction", "contact_width", "max_pressure",
    "mean_pressure", "saturated_fraction", "wear_depth_max", "wear_volume", "pin_heat_share",
)  # fmt: skip


def content(ds: xr.Dataset, most_fields: int = MOST_FIELDS) -> dict[str, Any]:
    """Collect what a page shows, as plain data.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    most_fields : int
        Number of points whose fields to take, those nearest to the transition.
    """
    ds = ordered(ds)
    axis = variant_of(ds)
    surfaces = [ds] if axis is None else [ds.isel({axis: at}) for at in range(ds.sizes[axis])]
    attributes = attributes_of(ds)
    conditions = Conditions(**attributes["conditions"])
    parts = [_on_surface(part, conditions.decisive) for part in surfaces]
    done = np.array([part["status"] == DONE for part in parts], dtype=bool)
    by_share = conditions.criterion == "share"
    chosen = _nearest(surfaces, done, conditions, most_fields) if _has_fields(ds) else []
    return {
        "title": attributes.get("title"),
        "name": attributes.get("name"),
        "conditions": _conditions(ds, conditions),
        "friction_heat": attributes.get("scene", {}).get("friction_heat", True),
        "measured": attributes.get("measured") or [],
        "chosen": bool(attributes.get("boundary_only")),
        "range": {name: range_of(ds, name) for name in ("load", "velocity")},
        "outcomes": list(OUTCOMES.values()),
        "deciding": conditions.decisive.temperature,
        "decisive": "" if by_share else _packed([part["decisive"] for part in parts], "<f8"),
        "loads": ds["load"].values.tolist(),
        "velocities": ds["velocity"].values.tolist(),
        "quantiles": ds["quantile"].values.tolist(),
        "surfaces": None if axis is None else _surfaces(ds, axis),
        "done": int(done.sum()),
        "status": _packed([part["status"] for part in parts], "i1"),
        "asked": _packed([part["asked"] for part in parts], "u1"),
        "moments": _packed([part["moments"] for part in parts], "<i4"),
        "moment_times": _packed([part["times"] for part in parts], "<f4"),
        "bulk_ratios": ds["bulk_ratio"].values.tolist() if "bulk_ratio" in ds.coords else [],
        "bulk_rises": _packed([part["bulk_rises"] for part in parts], "<f8"),
        "rises": _packed([part["rises"] for part in parts], "<f8"),
        "numbers": {
            name: _packed([part["numbers"][name] for part in parts], "<f4")
            for name in parts[0]["numbers"]
        },
        "messages": _by_place([part["messages"] for part in parts]),
        "warnings": _by_place([part["warnings"] for part in parts]),
        "fields": packed_fields(surfaces, chosen) | {"stored": int(done.sum()) * _has_fields(ds)},
        "record": {
            name: attributes[name]
            for name in ("scene", "scene_hash", "preset", "selection", "versions", "later_versions")
            if attributes.get(name) is not None
        },
    }


def _on_surface(ds: xr.Dataset, criterion: Criterion) -> dict[str, Any]:
    """What is known of each point on one surface."""
    ds = ds.transpose("load", "velocity", "step", ...)
    status = ds["status"].values
    quantiles, times = ds["rise_quantile"].values, ds["time"].values
    normal_load = ds["normal_load"].values
    every = quantiles[..., None, :]
    if "bulk_rise_quantile" in ds:
        every = np.concatenate([every, ds["bulk_rise_quantile"].values], axis=-2)
    decisive = _decisive(ds, criterion, every)
    moments = np.zeros(status.shape, dtype=int)
    rises, at = [np.empty((0, *every.shape[-2:]))], [np.empty(0)]
    decided = [np.empty((0, every.shape[-2]))]
    for place in zip(*np.nonzero(status == DONE), strict=True):
        rows = every[place].reshape(len(normal_load[place]), -1)
        rows = np.hstack([rows, decisive[place]])
        counts = _moments(rows, normal_load[place], float(ds["load"][place[0]]))
        moments[place] = counts.size
        rises.append(every[place][counts])
        at.append(times[place][counts])
        decided.append(decisive[place][counts])
    end = end_of_point(ds[[name for name in _SHOWN if name in ds]])
    flags = ds["warning_flags"].values.ravel().tolist()
    kinds = [[kind.label for kind in WarningKind if flag & kind] for flag in flags]
    return {
        "status": status,
        "asked": asked(ds).transpose("load", "velocity").values,
        "moments": moments,
        "times": np.concatenate(at),
        "decisive": np.concatenate(decided).ravel(),
        "rises": np.concatenate(rises)[:, 0].ravel(),
        "bulk_rises": np.concatenate(rises)[:, 1:].ravel(),
        "numbers": {
            str(name): end[name].transpose("load", "velocity").values for name in end.data_vars
        },
        "messages": [str(message) for message in ds["message"].values.ravel()],
        "warnings": kinds,
    }


def _decisive(ds: xr.Dataset, criterion: Criterion, quantiles: Array) -> Array:
    """Deciding rise by load, velocity, step and bulk ratio, that of equal bulks first [K]."""
    mean = ds["mean_rise"].values[..., None]
    if "mean_bulk_response" in ds:
        ratios = np.append(0.0, ds["bulk_ratio"].values)
        mean = mean + ratios * ds["mean_bulk_response"].values[..., None]
    columns = {"rise_quantile": quantiles, "mean_rise": mean, "quantile": ds["quantile"].values}
    found: Array = criterion.rise(columns)
    return found


def _moments(quantiles: Array, normal_load: Array, load: float) -> NDArray[np.intp]:
    """Steps at which a point may be at its worst, for one share of the contact or another.

    Those from when the load is reached on (`pipeline.sweep.criterion.worst_moment`), without such
    as another is hotter than at every quantile.

    Examples
    --------
    >>> hold = np.array([[0.0, 5.0], [1.0, 9.0], [1.0, 8.0], [2.0, 7.0], [np.nan, np.nan]])
    >>> _moments(hold, np.array([500.0, 600.0, 600.0, 600.0, 600.0]), 600.0).tolist()
    [1, 3]
    """
    known = np.isfinite(quantiles.sum(axis=-1))
    counts = np.flatnonzero(known & (normal_load >= load))
    if not counts.size and known[-1]:
        counts = np.array([len(known) - 1])
    kept: list[int] = []
    for step in counts.tolist():
        row = quantiles[step]
        if not any((quantiles[other] >= row).all() for other in kept):
            kept = [other for other in kept if not (row >= quantiles[other]).all()] + [step]
    return np.array(kept, dtype=np.intp)


def _surfaces(ds: xr.Dataset, axis: str) -> dict[str, Any]:
    """Say what the surfaces or samples are called, and in what they differ."""
    inputs = {
        str(name): [value.item() for value in np.atleast_1d(coordinate.values)]
        for name, coordinate in ds.coords.items()
        if coordinate.dims == (axis,) and name != axis
    }
    return {"axis": axis, "names": ds[axis].values.tolist(), "inputs": inputs}


def _conditions(ds: xr.Dataset, own: Conditions) -> dict[str, Any]:
    """The conditions of the sweep; that of the disk's bulk where it may differ from the pin's."""
    disk = own.bulk_temperature if own.disk_temperature is None else own.disk_temperature
    return own.as_dict() | ({"disk_temperature": disk} if "bulk_rise_quantile" in ds else {})


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


def _by_place(texts: list[list[Any]]) -> dict[str, Any]:
    """Give what is there by its place; most have none."""
    entries = (entry for part in texts for entry in part)
    return {str(place): entry for place, entry in enumerate(entries) if entry}


def _packed(parts: list[Any], dtype: str) -> str:
    """Arrays one after the other, as the base64 of their bytes."""
    joined = b"".join(np.ascontiguousarray(part, dtype=dtype).tobytes() for part in parts)
    return base64.b64encode(joined).decode()

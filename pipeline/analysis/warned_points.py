"""Points of a sweep that carry a warning, and whether the boundary rests on any of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import dataset_of, entry_dims
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.scenes import planes, stacked, value_text
from pipeline.analysis.slow_rise import WORDS, slow_rise
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE
from pipeline.sweep.criterion import contact_temperature, rise_limit
from pipeline.sweep.model import Point
from pipeline.sweep.own_laws import OwnLawError
from pipeline.sweep.warned import MELTS, MOLTEN, NO_WARNING, Warned
from tribo import Criterion, WarningKind
from tribo.types import Array, Mask


def warned(ds: xr.Dataset | PathLike, **conditions: Any) -> Warned:
    """Count the points of a sweep that carry a warning.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store.
    **conditions
        Those of `pipeline.boundary`, to tell which points lie beside it.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.warned(pipeline.open_sweep("results/first_try.zarr")).points
    0
    """
    ds = dataset_of(ds)
    flags = warnings_of(ds) | _molten(ds, conditions) * int(WarningKind.MOLTEN)
    there = flags != 0
    if not there.any():
        return NO_WARNING
    counts = {kind.label: int((flags & kind != 0).sum()) for kind in WarningKind}
    near = _beside_boundaries(ds, conditions)
    beside = there if near is None else there & near
    return Warned(
        points=int(there.sum()),
        kinds={kind: count for kind, count in counts.items() if count},
        at_boundary=None if near is None else int(beside.sum()),
        example=_first(ds, beside if beside.any() else there, flags),
    )


def has_warning(ds: xr.Dataset) -> xr.DataArray:
    """Points that are done and carry a warning."""
    return warnings_of(ds) != 0


def warnings_of(ds: xr.Dataset) -> xr.DataArray:
    """Sum of the `WarningKind` of each done point: its own, and what its neighbours tell."""
    flags = ds["warning_flags"].where(ds["status"] == DONE, 0).astype(int)
    flags = flags | slow_rise(ds) * int(WarningKind.SLOW_RISE)
    all_flags: xr.DataArray = flags.transpose(..., "load", "velocity", missing_dims="ignore")
    return all_flags


def _molten(ds: xr.Dataset, conditions: dict[str, Any]) -> xr.DataArray:
    """Points at which steel would have melted; none where no single condition judges them."""
    if isinstance(conditions.get("friction"), Iterable):
        return xr.zeros_like(ds["status"], bool)
    # Of a criterion that is code nothing runs here; the share serves as well.
    asked = conditions | {"criterion": "share"}
    parts = [
        contact_temperature(decisive_rise(scene, judged), judged) > MELTS
        for scene in planes(ds)
        for judged in [conditions_of(scene, **asked)]
    ]
    axes = [ds[name] for name in entry_dims(ds)]
    return stacked(parts, axes) if parts else xr.zeros_like(ds["status"], bool)


def _beside_boundaries(ds: xr.Dataset, conditions: dict[str, Any]) -> xr.DataArray | None:
    """Points beside the boundary of their scene; None where that is not known of all."""
    near = [_beside_boundary(scene, conditions) for scene in planes(ds)]
    if not near or any(marked is None for marked in near):
        return None
    axes = [ds[name] for name in entry_dims(ds)]
    return stacked([marked for marked in near if marked is not None], axes)


def _beside_boundary(ds: xr.Dataset, conditions: dict[str, Any]) -> xr.DataArray | None:
    """Points with a neighbour with the other kind of wear, at any of the frictions.

    None where no critical temperature tells the kind of wear, or a criterion that is not run.
    """
    frictions = conditions.get("friction")
    several = frictions if isinstance(frictions, Iterable) else [frictions]
    near = None
    for friction in several:
        asked = conditions | {"friction": friction}
        try:
            judged = conditions_of(ds, **asked)
        except OwnLawError:
            return None
        if judged.critical_temperature is None:
            return None
        rise, limit = decisive_rise(ds, judged), rise_limit(judged)
        for axis in (-2, -1):  # along the load, and along the velocity
            marked = rise.copy(data=np.apply_along_axis(_turns, axis, rise.values, limit))
            near = marked if near is None else near | marked
    return near


def _first(ds: xr.Dataset, chosen: xr.DataArray, flags: xr.DataArray) -> str:
    """The first message of those chosen, and its point; empty if a writer has just cleared it."""
    for place in np.argwhere(chosen.values):
        point = ds[["message"]].isel(dict(zip(chosen.dims, place.tolist(), strict=True)))
        flag = flags.values[tuple(place)]
        slow = WORDS if flag & WarningKind.SLOW_RISE else ""
        melted = MOLTEN if flag & WarningKind.MOLTEN else ""
        if message := str(point["message"].item()) or slow or melted:
            names = [str(dim) for dim in chosen.dims if dim not in ("load", "velocity")]
            values = tuple((name, value_text(ds[name], point[name].item())) for name in names)
            return f"{Point(point['load'].item(), point['velocity'].item(), values)}: {message}"
    return ""


def _turns(rise: Array, limit: float) -> Mask:
    """Known points of a row with the other kind of wear at the next known one on either side.

    Examples
    --------
    >>> _turns(np.array([1.0, 2.0, np.nan, 5.0, 6.0, 3.0]), 4.0)
    array([False,  True, False,  True,  True,  True])
    """
    (indices,), severe = np.nonzero(np.isfinite(rise)), Criterion.is_severe(rise, limit)
    turns = np.flatnonzero(severe[indices[:-1]] != severe[indices[1:]])
    beside = np.zeros(rise.shape, dtype=bool)
    beside[indices[turns]] = beside[indices[turns + 1]] = True
    return beside

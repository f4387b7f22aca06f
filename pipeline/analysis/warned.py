"""Points of a sweep that carry a warning, and whether the boundary rests on any of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.boundary import conditions_of, decisive_rise
from pipeline.analysis.dataset import at_bulks, leading, ordered, read_by_surface
from pipeline.store import DONE
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Point
from pipeline.sweep.warned import NO_WARNING, Warned
from tribo import WarningKind
from tribo.types import Array, Mask

_OLD_STORES = "of unknown kind"  # those that keep the text alone


def warned(ds: xr.Dataset, **conditions: Any) -> Warned:
    """Count the points of a sweep that carry a warning.

    Parameters
    ----------
    ds : Dataset
        Dataset of `pipeline.open_sweep`.
    **conditions
        Those of `pipeline.boundary`, to tell which points lie beside it.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.warned(pipeline.open_sweep("results/first_try.zarr")).points
    0
    """
    there = has_warning(ds)
    if not there.any():
        return NO_WARNING
    if "warning_flags" in ds:
        flags = ds["warning_flags"].where(there, 0)
        counts = {kind.label: int(((flags & kind) > 0).sum()) for kind in WarningKind}
    else:
        counts = {_OLD_STORES: int(there.sum())}
    found = _beside_boundary(ds, conditions)
    beside = there if found is None else there & found
    return Warned(
        points=int(there.sum()),
        kinds={kind: count for kind, count in counts.items() if count},
        at_boundary=None if found is None else int(beside.sum()),
        example=_first(ds["message"].where(beside if beside.any() else there, "")),
    )


def has_warning(ds: xr.Dataset) -> xr.DataArray:
    """Tell which points are done and carry a warning, with the dimensions of ``status``."""
    done = ds["status"] == DONE
    told: xr.DataArray = ds["warning_flags"] != 0 if "warning_flags" in ds else ds["message"] != ""
    return done & told


def _beside_boundary(ds: xr.Dataset, conditions: dict[str, Any]) -> xr.DataArray | None:
    """Tell which points have a neighbour with the other kind of wear, at any of the frictions.

    None where no critical temperature tells the kind of wear.
    """
    frictions = conditions.get("friction")
    several = frictions if isinstance(frictions, Iterable) else [frictions]
    each = [conditions_of(ds, **conditions | {"friction": friction}) for friction in several]
    if each[0].critical_temperature is None:
        return None
    found = []
    for part in read_by_surface(ordered(ds)):
        rises = [decisive_rise(at_bulks(part, own), own.failing_share) for own in each]
        limits = [rise_limit(own) for own in each]
        beside = [_beside(r.values, limit) for r, limit in zip(rises, limits, strict=True)]
        found.append(rises[0].copy(data=np.any(beside, axis=0)))
    name = leading(ds)
    return found[0] if name is None else xr.concat(found, name)


def _first(messages: xr.DataArray) -> str:
    """The first message that there is, and its point; empty if a writer has just cleared it."""
    if not messages.values.any():
        return ""
    at = {
        name: int(place[0])
        for name, place in zip(messages.dims, np.nonzero(messages.values), strict=True)
    }
    one = messages[at]
    return f"{Point(**{str(name): one[name].item() for name in at})}: {one.item()}"


def _beside(rise: Array, limit: float) -> Mask:
    known, severe = np.isfinite(rise), rise > limit
    along_velocity = [_turns(*row) for row in zip(known, severe, strict=True)]
    along_load = [_turns(*column) for column in zip(known.T, severe.T, strict=True)]
    beside: Mask = np.array(along_velocity) | np.array(along_load).T
    return beside


def _turns(known: Mask, severe: Mask) -> Mask:
    """Which known points of a row differ from the next known one on either side.

    Examples
    --------
    >>> _turns(np.array([1, 1, 0, 1], bool), np.array([0, 0, 0, 1], bool))
    array([False,  True, False,  True])
    """
    (at,) = np.nonzero(known)
    turns = np.flatnonzero(severe[at[:-1]] != severe[at[1:]])
    found = np.zeros(known.shape, dtype=bool)
    found[at[turns]] = found[at[turns + 1]] = True
    return found

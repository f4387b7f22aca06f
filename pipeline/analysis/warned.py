"""Points of a sweep that carry a warning, and whether the boundary rests on any of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.results import Results, decisive_plane
from pipeline.store import DONE
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Point
from pipeline.sweep.warned import NO_WARNING, Warned
from tribo import WarningKind
from tribo.types import Array, Mask

if TYPE_CHECKING:
    import xarray as xr

_OLD_STORES = "of unknown kind"  # those that keep the text alone


def warned(ds: xr.Dataset | Results, **conditions: Any) -> Warned:
    """Count the points of a sweep that carry a warning.

    Parameters
    ----------
    ds : Dataset or Results
        Dataset of `pipeline.open_sweep`.
    **conditions
        Those of `pipeline.boundary`, to tell which points lie beside it.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.warned(pipeline.open_sweep("results/first_try.zarr")).points
    0
    """
    results = Results.of(ds)
    there = np.array([has_warning(part) for part in results.parts()])
    if not there.any():
        return NO_WARNING
    if "warning_flags" in results:
        flags = np.where(there, [part["warning_flags"] for part in results.parts()], 0)
        counts = {kind.label: int(np.count_nonzero(flags & kind)) for kind in WarningKind}
    else:
        counts = {_OLD_STORES: int(np.count_nonzero(there))}
    found = _beside_boundary(results, conditions)
    beside = there if found is None else there & found
    return Warned(
        points=int(np.count_nonzero(there)),
        kinds={kind: count for kind, count in counts.items() if count},
        at_boundary=None if found is None else int(np.count_nonzero(beside)),
        example=_first(results, beside if beside.any() else there),
    )


def has_warning(part: Results) -> Mask:
    """Tell which points of one surface are done and carry a warning, by load and velocity."""
    flags = "warning_flags" in part
    told = part["warning_flags"] != 0 if flags else part["message"] != ""
    found: Mask = (part["status"] == DONE) & told
    return found


def _beside_boundary(results: Results, conditions: dict[str, Any]) -> Mask | None:
    """Tell which points have a neighbour with the other kind of wear, at any of the frictions.

    None where no critical temperature tells the kind of wear.
    """
    frictions = conditions.get("friction")
    several = frictions if isinstance(frictions, Iterable) else [frictions]
    each = [conditions_of(results, **conditions | {"friction": friction}) for friction in several]
    if each[0].critical_temperature is None:
        return None
    found = []
    for part in results.parts():
        rises = [decisive_plane(part.at(own), own.failing_share).rises for own in each]
        limits = map(rise_limit, each)
        beside = [_beside(r, limit) for r, limit in zip(rises, limits, strict=True)]
        found.append(np.any(beside, axis=0))
    return np.array(found)


def _first(results: Results, chosen: Mask) -> str:
    """The first message of those chosen, and its point; empty if a writer has just cleared it."""
    name = results.leading
    for part, rows in zip(results.parts(), chosen, strict=True):
        place = {name: part.place[name]} if name else {}
        for i, j in zip(*np.nonzero(rows), strict=True):
            if message := part["message"][i, j]:
                point = Point(float(part.loads[i]), float(part.velocities[j]), **place)
                return f"{point}: {message}"
    return ""


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

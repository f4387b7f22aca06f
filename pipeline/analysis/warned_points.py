"""Points of a sweep that carry a warning, and whether the boundary rests on any of them.

Two warnings follow from a whole sweep alone: that bodies roll as if each turn met a cold track, and
that the rise grows slowly with the velocity. The error of a boundary velocity is that of the rise
over the exponent n of rise ∝ Vⁿ. Below n = 0.3 `standard` was 5 to 8 % off, `draft` 11 to 21 %.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import (
    Kind,
    dataset_of,
    judged_dims,
    messages,
    read_conditions,
    require_variables,
    stored_sweep,
    sweep_kind,
)
from pipeline.analysis.decisive import boundary_neighbours, decisive_rise
from pipeline.analysis.scenes import map_scenes, scenes, value_text
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.laws import LawError
from pipeline.sweep.model import Point
from pipeline.sweep.remarks import remarks
from pipeline.sweep.severity import MELTS, MOLTEN, rise_limit
from pipeline.sweep.shown import shown
from tribo import CRITERIA, WarningKind
from tribo.simulation.point_warnings import SLOW, SLOWEST
from tribo.types import Array


@shown
@dataclass(frozen=True, slots=True)
class Warned:
    """Points of a sweep that carry a warning, by kind."""

    points: int  #: Points with at least one warning.
    kinds: dict[str, int]  #: Points with a warning of each kind that occurs.
    #: Those with a neighbour in load or in velocity with the other kind of wear; None where there
    #: is no boundary, for want of a critical temperature.
    at_boundary: int | None
    example: str = ""  #: One of these, or else of any, with its warning.

    def __add__(self, other: Warned) -> Warned:
        """Points of two sweeps."""
        beside = (self.at_boundary, other.at_boundary)
        return Warned(
            self.points + other.points,
            dict(Counter(self.kinds) + Counter(other.kinds)),
            None if None in beside else sum(filter(None, beside)),
            self.example or other.example,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)

    def lines(self) -> Iterator[str]:
        """Lines for the user; none where no point carries a warning."""
        if not self.points:
            return
        kinds = ", ".join(f"{kind} at {count}" for kind, count in self.kinds.items())
        if self.at_boundary is None:
            lies = "and it is not known which of them lie beside the boundary"
        elif self.at_boundary:
            lies = f"{self.at_boundary} beside the boundary, which may be wrong there"
        else:
            lies = "none beside the boundary"
        carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
        yield from remarks("warning", f"{carry} a warning ({kinds}), {lies}", f"at {self.example}")


NO_WARNING = Warned(0, {}, 0)
"""Of a sweep in which no point carries one."""


@np.errstate(under="ignore")
def warned(ds: xr.Dataset | PathLike) -> Warned:
    """Count the points of a sweep that carry a warning.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or the path of a store. Of several values
        of a condition, such as two frictions, a point lies beside the boundary at any of them.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.warned(pipeline.open_sweep("results/first_try.zarr")).points
    0
    """
    ds = dataset_of(ds)
    judged = judged_dims(ds)
    alone = ds.isel(dict.fromkeys(judged, 0))
    flags = warnings_of(alone) | _marked(ds, _is_molten).any(judged) * int(WarningKind.MOLTEN)
    there = flags != 0
    if not there.any():
        return NO_WARNING
    counts = {kind.label: int((flags & kind != 0).sum()) for kind in WarningKind}
    near = _boundary_neighbours(ds)
    beside = there if near is None else there & near.any(judged)
    return Warned(
        points=int(there.sum()),
        kinds={kind: count for kind, count in counts.items() if count},
        at_boundary=None if near is None else int(beside.sum()),
        example=_first(alone, beside if beside.any() else there, flags),
    )


def warnings_of(ds: xr.Dataset) -> xr.DataArray:
    """Sum of the `WarningKind` of each done point: its own, and what its neighbours tell."""
    require_variables(ds, "status", "warning_flags")
    flags = ds["warning_flags"].where(ds["status"] == DONE, 0).astype(int)
    flags = flags | _marked(ds, _rises_slowly) * int(WarningKind.SLOW_RISE)
    all_flags: xr.DataArray = flags.transpose(..., "load", "velocity", missing_dims="ignore")
    return all_flags


def _is_molten(scene: xr.Dataset) -> xr.DataArray:
    """Points at which steel would have melted."""
    # Of a criterion that is code nothing runs here; the share serves as well.
    judged = read_conditions(scene, with_criterion=False)
    return decisive_rise(scene, judged) > judged.limit(MELTS)


def _marked(ds: xr.Dataset, mark: Callable[[xr.Dataset], xr.DataArray]) -> xr.DataArray:
    """Points that are marked in their scene; none of rows that have no plane."""
    has_plane = sweep_kind(ds) is Kind.PLANE
    return map_scenes(ds, mark) if has_plane else xr.zeros_like(ds["status"], bool)


def _boundary_neighbours(ds: xr.Dataset) -> xr.DataArray | None:
    """Points beside the other kind of wear; None where that is not known."""
    if sweep_kind(ds) is not Kind.PLANE:
        return None
    try:
        if any(read_conditions(scene).critical_temperature is None for scene in scenes(ds)):
            return None
    except LawError:
        return None

    def mark_scene(scene: xr.Dataset) -> xr.DataArray:
        conditions = read_conditions(scene)
        rise = decisive_rise(scene, conditions)
        return rise.copy(data=boundary_neighbours(rise.values, rise_limit(conditions)))

    return _marked(ds, mark_scene)


def _first(ds: xr.Dataset, chosen: xr.DataArray, flags: xr.DataArray) -> str:
    """The first message of those chosen, and its point; empty if a writer has just cleared it."""
    said = messages(ds).transpose(*chosen.dims)
    for place in np.argwhere(chosen.values):
        point = said[tuple(place)]
        flag = flags.values[tuple(place)]
        slow = SLOW if flag & WarningKind.SLOW_RISE else ""
        melted = MOLTEN if flag & WarningKind.MOLTEN else ""
        kinds = ", ".join(kind.label for kind in WarningKind if flag & kind)  # of a copy
        told = str(point.item()) or (kinds if not (slow or melted) else "")
        if message := "; ".join(filter(None, (told, slow, melted))):
            names = [str(dim) for dim in chosen.dims if dim not in ("load", "velocity")]
            values = tuple((name, value_text(ds[name], point[name].item())) for name in names)
            return f"{Point(point['load'].item(), point['velocity'].item(), values)}: {message}"
    return ""


_APART = 1.1  # least ratio of velocities over which an exponent is taken


def _rises_slowly(scene: xr.Dataset) -> xr.DataArray:
    """Points at which the rise by friction, between equal bulks, grows slowly with velocity."""
    stored = stored_sweep(scene).conditions
    kind = stored.criterion if stored.criterion in CRITERIA else "share"
    plain = Conditions(1.0, 300.0, None, stored.failing_share, criterion=kind)
    rise = decisive_rise(scene, plain)
    x = rise["velocity"].values
    slow = np.apply_along_axis(lambda row: exponents(x, row) < SLOWEST, -1, rise.values)
    return rise.copy(data=slow)


def exponents(x: Array, y: Array) -> Array:
    """Exponent d ln(y)/d ln(x) at each point, between neighbours far enough apart; or NaN."""
    result = np.full(x.shape, math.nan)
    (known,) = np.nonzero((x > 0) & np.isfinite(y) & (y > 0))
    log_x, log_y = np.log(x[known]), np.log(y[known])
    least = math.log(_APART)
    for place, here in zip(known, log_x, strict=True):
        low = max(int(np.searchsorted(log_x, here - least, "right")) - 1, 0)
        high = min(int(np.searchsorted(log_x, here + least)), len(known) - 1)
        if log_x[high] - log_x[low] >= least:
            result[place] = (log_y[high] - log_y[low]) / (log_x[high] - log_x[low])
    return result

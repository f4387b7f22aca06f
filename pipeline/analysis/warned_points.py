"""Points of a sweep that carry a warning, and whether the boundary rests on any of them.

Two warnings follow from a whole sweep alone: that bodies roll as if each turn met a cold track, and
that the rise grows slowly with the velocity. The error of a boundary velocity is that of the rise
over the exponent n of rise ∝ Vⁿ. Below n = 0.3 `standard` was 5 to 8 % off, `draft` 11 to 21 %.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import Kind
from pipeline.analysis.results import Results, results
from pipeline.analysis.scenes import value_text
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.laws import LawError
from pipeline.sweep.remarks import remarks
from pipeline.sweep.severity import MELTS, MOLTEN, rise_limit
from pipeline.sweep.shown import shown
from tribo import CRITERIA, Criterion, WarningKind
from tribo.simulation.point_warnings import SLOW, SLOWEST
from tribo.types import Array, Indices, Mask


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
def warned(ds: xr.Dataset | PathLike | Results) -> Warned:
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
    held = results(ds)
    judged = tuple(held.front.index(name) for name in held.judged_dims)
    alone = tuple(0 if k in judged else slice(None) for k in range(len(held.front)))
    flags = warning_flags(held)[alone]
    flags = flags | _marked(held, _is_molten).any(axis=judged) * int(WarningKind.MOLTEN)
    there = flags != 0
    if not there.any():
        return NO_WARNING
    counts = {kind.label: int((flags & kind != 0).sum()) for kind in WarningKind}
    near = _boundary_neighbours(held)
    beside = there if near is None else there & near.any(axis=judged)
    return Warned(
        points=int(there.sum()),
        kinds={kind: count for kind, count in counts.items() if count},
        at_boundary=None if near is None else int(beside.sum()),
        example=_first(held, judged, beside if beside.any() else there, flags),
    )


def warning_flags(held: Results) -> Indices:
    """Sum of the `WarningKind` of each done point: its own, and what its neighbours tell."""
    held.require("status", "warning_flags")
    flags = np.where(held.done, held.columns["warning_flags"], 0).astype(int)
    return np.asarray(flags | _marked(held, _rises_slowly) * int(WarningKind.SLOW_RISE))


def _is_molten(scene: Results) -> Mask:
    """Points at which steel would have melted."""
    # Of a criterion that is code nothing runs here; the share serves as well.
    judged = scene.plain_conditions
    return np.asarray(scene.rises(judged) > judged.limit(MELTS))


def _marked(held: Results, mark: Callable[[Results], Mask]) -> Mask:
    """Points that are marked in their scene; none of rows that have no plane."""
    if held.kind is not Kind.PLANE:
        return np.zeros(held.done.shape, bool)
    return np.reshape([mark(scene) for scene in held.scenes], held.done.shape)


def _boundary_neighbours(held: Results) -> Mask | None:
    """Points beside the other kind of wear; None where that is not known."""
    if held.kind is not Kind.PLANE:
        return None
    try:
        if any(scene.conditions.critical_temperature is None for scene in held.scenes):
            return None
    except LawError:
        return None
    return _marked(held, _beside_turns)


def _beside_turns(scene: Results) -> Mask:
    """Points of a scene whose next known one along either axis has the other kind of wear."""
    rises, limit = scene.rises(scene.conditions), rise_limit(scene.conditions)
    return np.logical_or(*(np.apply_along_axis(_turns, k, rises, limit) for k in (-2, -1)))


def _turns(rise: Array, limit: float) -> Mask:
    """Known points of a row with the other kind of wear at the next known one on either side."""
    (indices,), severe = np.nonzero(np.isfinite(rise)), Criterion.is_severe(rise, limit)
    turns = np.flatnonzero(severe[indices[:-1]] != severe[indices[1:]])
    beside = np.zeros(rise.shape, dtype=bool)
    beside[indices[turns]] = beside[indices[turns + 1]] = True
    return beside


def _first(held: Results, judged: tuple[int, ...], chosen: Mask, flags: Indices) -> str:
    """The first message of those chosen, and its point; empty if a writer has just cleared it."""
    names = [name for k, name in enumerate(held.front) if k not in judged]
    for place in np.argwhere(chosen).tolist():
        flag = flags[tuple(place)]
        *row, load, velocity = place
        labels = dict(zip(names, row, strict=True))
        here = held.take(dict.fromkeys(held.judged_dims, 0) | labels)
        slow = SLOW if flag & WarningKind.SLOW_RISE else ""
        melted = MOLTEN if flag & WarningKind.MOLTEN else ""
        kinds = ", ".join(kind.label for kind in WarningKind if flag & kind)  # of a copy
        message = here.messages[load, velocity] or (kinds if not (slow or melted) else "")
        if message := "; ".join(filter(None, (message, slow, melted))):
            values = tuple((n, value_text(here.rows[n], here.rows[n].item())) for n in names)
            return f"{here.point(load, velocity)._replace(variant=values)}: {message}"
    return ""


_APART = 1.1  # least ratio of velocities over which an exponent is taken


def _rises_slowly(scene: Results) -> Mask:
    """Points at which the rise by friction, between equal bulks, grows slowly with velocity."""
    stored = scene.sweep.conditions
    kind = stored.criterion if stored.criterion in CRITERIA else "share"
    plain = Conditions(1.0, 300.0, None, stored.failing_share, criterion=kind)
    rises, x = scene.rises(plain), scene.velocities
    return np.apply_along_axis(lambda row: exponents(x, row) < SLOWEST, -1, rises)


def exponents(x: Array, y: Array) -> Array:
    """Exponent d ln(y)/d ln(x) at each point, between neighbours far enough apart; or NaN."""
    result = np.full(x.shape, math.nan)
    (known,) = np.nonzero((x > 0) & np.isfinite(y) & (y > 0))
    log_x, log_y = np.log(x[known]), np.log(y[known])
    least = math.log(_APART)
    low = np.maximum(np.searchsorted(log_x, log_x - least, "right") - 1, 0)
    high = np.minimum(np.searchsorted(log_x, log_x + least), len(known) - 1)
    ways = log_x[high] - log_x[low]
    is_apart = ways >= least
    result[known[is_apart]] = (log_y[high] - log_y[low])[is_apart] / ways[is_apart]
    return result

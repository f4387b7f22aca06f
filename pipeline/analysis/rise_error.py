"""Error of the deciding rise at a place of a sweep, in parts that belong together.

- Interpolation: 0 only where that very point is done.
- Preset: of its numerical choices, by the promised error of the boundary velocity.
- Warnings: those of the points that the rise rests on.
- Counted after the simulation: a film, and friction by temperature where it is not solved.

Each is a bound that some 99 % of places keep, and they are independent, so that their squares add.
A part that is not known is None, and so is the total. `python -m tests.promises.errors` judges by
`fine` where a tenth of the contact decides, and counts the places that keep to the total
(workflows/MEASURED.md).
"""

from __future__ import annotations

import functools
import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pipeline.analysis.curve import Curve
from pipeline.analysis.results import Results
from pipeline.analysis.warned_points import warning_flags
from pipeline.sweep.conditions import Conditions
from tribo import WarningKind
from tribo.types import Array, Indices, Mask

SHARE = 0.65
"""Share of a preset's bound of velocity that rises err by, which grow by its power of 0.5 to 0.7.

Found by `python -m tests.promises.front` and `python -m tests.promises.errors`.
"""

BETWEEN = 5.0
"""What interpolation errs by, over the root mean square by which it misses points left out.

For equal gaps: it grows in proportion to ln of the gap, as the rise is rough at these distances. On
24 scenes 99 % of the places between points of `fine` hold with it, and 97 % with 2.7.
Found by `python -m tests.promises.errors`.
"""

BEYOND = 0.12
"""Change of the exponent of a power law that is continued, for each unit of ln of the velocity.

Found by `python -m tests.promises.errors`.
"""

_OF_WARNED = {
    # Largest that were seen with these three, which the campaign hardly meets; `fine` has the
    # pixels of the last as well.
    WarningKind.FEW_STEPS: 0.10,
    WarningKind.FEW_TURNS: 0.10,
    WarningKind.COARSE_PIXELS: 0.70,
    # Where 15 to 38 elements touch; with some hundreds it was 0.6 %. The elements are the pixels
    # then. Other surfaces and smaller pixels are no error of these.
    WarningKind.FEW_NODES: 0.11,
    # At the highest friction that the table has, or with the error of each part alone.
    WarningKind.IGNITION: 0.0,
    WarningKind.UNSOLVED_FRICTION: 0.0,
    WarningKind.SLOW_RISE: 0.03,  # `standard` missed one of 33 points by 3.7 %
}
"""Relative error of the rise that a warning adds; that of others is not known.

Found by `python -m tests.promises.errors`.
"""

_OF_FILM = 0.032
"""Largest error of a rise whose film resistance is counted after the simulation, at 200 N."""
_OF_FRICTION = 0.3
"""That of friction by temperature that is not solved, over the largest change of its logarithm."""

_DURATIONS, _TOO_WARM = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and how much present heat makes contacts too warm at most.

The table of MEASURED.md; 5 % is that of loads that jump late, also in longer tests. On ramps of
seconds it was 1 %.
"""


_PARTS = (
    "interpolation",
    "preset",
    "warned points",
    "film and friction by temperature, which only a run of the scene solves",
)


@dataclass(frozen=True, slots=True)
class RiseError:
    """Relative error of a rise by its parts; None where a part is not known."""

    interpolation: float | None
    preset: float | None
    warned: float | None
    counted: float | None = 0.0  # after the simulation: a film, friction by temperature

    @classmethod
    def of(cls, parts: Array) -> RiseError:
        """The error by its parts (4,), of which NaN is not known."""
        return cls(*(None if math.isnan(part) else part for part in parts.tolist()))

    @property
    def parts(self) -> Array:
        """The parts (4,); NaN where one is not known."""
        return np.array(astuple(self), float)

    @property
    def total(self) -> float | None:
        """Root of the sum of the squares of the parts; None where one is not known."""
        total = float(totals(self.parts))
        return None if math.isnan(total) else total

    @property
    def text(self) -> str:
        """The error [K] and its parts in words."""
        parts = dict(zip(_PARTS, astuple(self), strict=True))
        known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part)
        if unknown := " and ".join(name for name, part in parts.items() if part is None):
            beside = f" ({known})" if known else ""
            return f"not known, since that of {unknown} is not known{beside}"
        return f"± {self.total:.2g} K" + (f": {known}" if known else "")

    def times(self, factor: float) -> RiseError:
        """The parts times a factor; all are 0 where the factor is 0."""
        if factor == 0:
            return RiseError(0.0, 0.0, 0.0, 0.0)
        return RiseError(*(None if part is None else factor * part for part in astuple(self)))


def totals(errors: Array) -> Array:
    """Roots of the sums of the squares of parts, which come first; NaN where one is not known."""
    return np.asarray(np.sqrt(np.square(errors).sum(axis=0)))


@dataclass(frozen=True, eq=False)
class RisePlane:
    """Deciding rises by load and velocity [K], NaN where not done; flags of warnings; times [s]."""

    loads: Array
    velocities: Array
    rises: Array
    flags: Indices
    durations: Array
    is_solved: Mask  # friction by temperature is, for the conditions

    def rests_on_solved(self, loads: Array, velocities: Array) -> Mask:
        """True at places (k,) if friction by temperature is solved at all points beneath."""
        rows, columns = self.rests_on(loads, velocities)
        return np.asarray(self.is_solved[rows[..., None], columns].all(axis=(1, 2)))

    def is_done(self, loads: Array, velocities: Array) -> Mask:
        """True at places (k,) whose very point is done."""
        at_load, at_velocity = loads[:, None] == self.loads, velocities[:, None] == self.velocities
        done = at_load @ self._is_done
        return np.asarray((done & at_velocity).any(axis=1))

    @functools.cached_property
    def _is_done(self) -> Mask:
        return np.isfinite(self.rises)

    def rests_on(self, loads: Array, velocities: Array) -> tuple[Indices, Indices]:
        """Rows (k, 2) and columns (k, 2, 2) of the points that rises at places are taken from.

        They are the point itself, or those beside it, and -1 where there is none.
        """
        along = _slots(self.velocities, velocities)
        rows = self._rows[along, _slots(self.loads, loads)]
        return rows, self._columns[rows, along[:, None]]

    @functools.cached_property
    def _rows(self) -> Indices:
        """Rows beside each slot of loads, by the slot of the velocity."""
        goes_on = self._is_done.sum(axis=1) >= 2  # beyond its ends
        reached = np.repeat(goes_on[None], 2 * len(self.velocities) + 1, axis=0)
        reached[1::2] |= self._is_done.T
        return _neighbours(reached)

    @functools.cached_property
    def _columns(self) -> Indices:
        """Columns beside each slot of velocities, by row."""
        return _neighbours(self._is_done)

    @functools.cached_property
    def warned(self) -> Array:
        """Errors that the warnings of the points stand for; NaN if unknown."""
        return warned_errors(self.flags, self.durations)


def planes_of(scene: Results, conditions: Conditions) -> tuple[RisePlane, ...]:
    """Plane of each surface of a scene under some conditions, without friction by velocity."""
    scene.require("time")
    rises = scene.rises(conditions) / conditions.friction_factor(scene.velocities)
    is_solved = np.broadcast_to(~np.isnan(scene.solved(conditions)), rises.shape)
    times = np.nan_to_num(scene.columns["time"], nan=-np.inf).max(axis=-1)
    shape = -1, *rises.shape[-2:]
    parts = (one.reshape(shape) for one in (rises, warning_flags(scene), times, is_solved))
    axes = scene.loads, scene.velocities
    return tuple(RisePlane(*axes, *values) for values in zip(*parts, strict=True))


def rise_errors(
    grid: RisePlane, loads: Array, velocities: Array, velocity_error: float | None
) -> Array:
    """Relative errors of the rise at places by part (4, k), without what is counted afterwards."""
    rows, columns = grid.rests_on(loads, velocities)
    warned = grid.warned[rows[..., None], columns].max(axis=(1, 2))
    between = _interpolation(grid, rows, columns, loads, velocities)
    return np.stack(np.broadcast_arrays(between, preset_error(velocity_error), warned, 0.0))


def _slots(points: Array, places: Array) -> Indices:
    """Numbers of the points (odd), and of the intervals between them (even), at places."""
    slots: Indices = 2 * np.searchsorted(points, places) + np.isin(places, points)
    return slots


def preset_error(velocity_error: float | None) -> float:
    """Relative error of a rise by the promised one of boundary velocities; NaN if not known."""
    return math.nan if velocity_error is None else SHARE * velocity_error


def counted_error(
    conditions: Conditions, rises: Array | float = 0.0, is_solved: Mask | bool = False
) -> Array:
    """Error of what is counted after the simulation: a film, friction by temperature.

    Rises at friction 1 [K] that friction may ignite have no known error, unless it is solved.
    """
    if (parts := conditions.corrections) is None:
        return np.array(0.0)
    law = conditions.friction_law
    film = _OF_FILM if parts.film_resistance else 0.0
    if not (law.by_temperature and law.coefficient):
        return np.array(film)
    bulk = conditions.coldest_bulk_temperature
    change = law.spread(bulk, conditions.critical_temperature or bulk)
    may_ignite = np.vectorize(conditions.may_ignite, otypes=[bool])(np.nan_to_num(rises))
    unsolved = np.where(may_ignite, math.nan, math.hypot(film, _OF_FRICTION * change))
    return np.where(is_solved, film, unsolved)


def _neighbours(is_done: Mask) -> Indices:
    """Columns of the done points beside each slot (r, 2 n + 1, 2) of rows (r, n); see `_slots`.

    They are the slot's own point twice, those on both sides, or the last two. A row with a single
    point has it twice; one without has -1.
    """
    order = np.argsort(~is_done, axis=1, kind="stable")
    count = is_done.sum(axis=1)[:, None]
    in_front = np.pad(np.cumsum(is_done, axis=1), ((0, 0), (1, 0))).repeat(2, axis=1)[:, :-1]
    first = np.clip(in_front - 1, 0, np.maximum(count - 2, 0))
    either_side = first, np.minimum(first + 1, count - 1)
    found = np.stack([np.take_along_axis(order, side, axis=1) for side in either_side], axis=-1)
    own = np.arange(is_done.shape[1])[:, None]
    found[:, 1::2] = np.where(is_done[..., None], own, found[:, 1::2])
    return np.where(count[..., None] > 0, found, -1)


def _interpolation(
    grid: RisePlane, rows: Indices, columns: Indices, loads: Array, velocities: Array
) -> Array:
    """Errors of interpolating, or of continuing beyond the points; NaN where unknown."""
    (lowest, highest), places = grid.loads[rows].T, velocities[:, None]
    first, last = np.moveaxis(grid.velocities[columns], -1, 0)
    gaps = np.log(last / first)
    way = np.maximum(np.log(first / places), np.log(places / last))
    slope_error = np.hypot(_slope_spread(grid), BEYOND * (way + gaps))
    beyond = np.where((gaps > 0) & (way > 0), way * slope_error, 0.0).max(axis=1)
    along = np.where(beyond > 0, beyond, _gap_errors(grid, "velocity", gaps.max(axis=1)))
    errors = np.hypot(along, _gap_errors(grid, "load", np.log(highest / lowest)))
    # No rise is known beyond the loads.
    is_known = (rows[:, 0] >= 0) & (lowest <= loads) & (loads <= highest)
    return np.where(is_known, errors, math.nan)


def _gap_errors(grid: RisePlane, axis: str, gaps: Array) -> Array:
    """Errors of interpolating in gaps of ln along an axis, by what it misses left-out points by."""
    return np.where(gaps > 0, BETWEEN * _missed(grid, axis) * gaps, 0.0)


@functools.lru_cache(maxsize=1024)  # many places lie between the same points
def _missed(grid: RisePlane, axis: str) -> float:
    """Root mean square of what interpolation misses left-out points by, over ln of the gap."""
    lines = (grid.velocities, grid.rises) if axis == "velocity" else (grid.loads, grid.rises.T)
    room = (0, 0), (1, 1)
    # The cubic through a place rests on two points on either side.
    x, y = (
        sliding_window_view(np.pad(part, room, constant_values=math.nan), 5, axis=1)
        for part in _powers(*lines)
    )
    curves = Curve(*(np.exp(np.delete(part, 2, axis=-1)) for part in (x, y)))
    missed = (np.log(curves(np.exp(x[..., [2]]))[..., 0]) - y[..., 2]) / (x[..., 3] - x[..., 1])
    every = missed[np.isfinite(missed)]
    return float(np.sqrt(np.mean(every**2))) if every.size else math.nan


@functools.lru_cache(maxsize=1024)  # many places lie beyond the same points
def _slope_spread(grid: RisePlane) -> float:
    """Standard deviation of the exponent of the velocity between neighbouring points."""
    x, y = _powers(grid.velocities, grid.rises)
    slopes = np.diff(y) / np.diff(x)
    slopes = slopes[np.isfinite(slopes)]
    return float(np.std(slopes)) if slopes.size else 0.0


def _powers(x: Array, rows: Array) -> tuple[Array, Array]:
    """Logarithms of abscissae and of rises by row, where both are positive; NaN behind them."""
    is_known = np.isfinite(rows) & (rows > 0) & (x > 0)
    curves = Curve(np.where(is_known, x, math.nan), rows)
    return np.log(curves.x), np.log(curves.y)


def warned_errors(flags: Indices, durations: Array) -> Array:
    """Errors that warnings of points stand for, by flags and durations [s]; NaN if unknown."""
    is_warm = (flags & int(WarningKind.PRESENT_HEAT)) > 0
    warm = np.interp(np.log(np.where(is_warm, durations, 1.0)), np.log(_DURATIONS), _TOO_WARM)
    errors = np.where(is_warm, warm, 0.0)
    for kind in {*WarningKind} - {WarningKind.PRESENT_HEAT}:
        is_kind = (flags & int(kind)) > 0
        errors = np.where(is_kind, np.maximum(errors, _OF_WARNED.get(kind, math.nan)), errors)
    return errors

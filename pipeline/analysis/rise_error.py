"""Numerical error of a temperature rise at any load and velocity of a sweep, in independent parts.

The rise is that of the contact temperature which the criterion compares with the critical
temperature. The parts are due to:

- Interpolation: the error is 0 only at a computed point.
- The preset's numerical choices: from the promised error of the critical velocity.
- Warnings: those of the points between which the rise is interpolated.

Each part is a bound that holds for some 99 % of operating points. The parts are independent, so
that their squares add. An unknown part is None, and makes the total None.
`python -m tests.promises.errors` compares rises that a tenth of the contact exceeds with those of
preset `fine`, and counts the points at which the total holds (workflows/MEASURED.md).
"""

from __future__ import annotations

import functools
import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pipeline.analysis.curve import Curve
from pipeline.analysis.left_out import Alignment
from pipeline.analysis.results import Results
from pipeline.analysis.warned_points import warning_flags
from pipeline.sweep.conditions import Conditions
from tribo import WarningKind
from tribo.types import Array, Indices, Mask

SHARE = 0.65
"""Relative error of a rise over that of the critical velocity: rises grow as velocity^0.5 to 0.7.

Found by `python -m tests.promises.front` and `python -m tests.promises.errors`.
"""

BETWEEN = 5.0
"""Bound of the interpolation error, over the root mean square error at points left out.

Both errors are for the same gap, the ratio of the neighbouring loads or velocities. They grow in
proportion to ln(gap), as the rise is rough at these distances. On 24 scenes the bound holds at 99 %
of loads and velocities between points of `fine`; with 2.7 it would hold at 97 %.
Found by `python -m tests.promises.errors`.
"""

ROUGH = 0.04
"""Least bound of the interpolation error over ln(gap), after a search of the boundary.

A search leaves too few points to show how rough the rise is. It is the largest bound of the whole
planes of the shipped scenes, 0.01 to 0.04.
"""

BEYOND = 0.12
"""Error of the exponent of an extrapolated power law, for each unit of ln(velocity).

The distance in ln(velocity) counts from the second outermost point.

Found by `python -m tests.promises.errors`.
"""

_OF_WARNED = {
    # The largest error seen with each of these three warnings; too few scenes of
    # `tests.promises.errors` have them for a quantile. Preset `fine` has the error of coarse pixels
    # too.
    WarningKind.FEW_STEPS: 0.10,
    WarningKind.FEW_TURNS: 0.10,
    WarningKind.COARSE_PIXELS: 0.70,
    # Seen with 15 to 38 elements in contact, each a single pixel; with some hundreds the error was
    # 0.6 %. Differences between surfaces, or from smaller pixels, are not included.
    WarningKind.FEW_NODES: 0.11,
    WarningKind.SLOW_RISE: 0.03,  # `standard` missed one of 33 points by 3.7 %
}
"""Relative error of the rise that a warning adds; for other warnings it is unknown.

Found by `python -m tests.promises.errors`.
"""


_DURATIONS, _TOO_WARM = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and the largest relative error of rises with the heat model "elapsed".

This model lets the present friction heat act since the start. The errors are from the table of
workflows/MEASURED.md; 5 % is for loads that jump late, also in longer tests. On ramps of seconds
the error was 1 %.
"""


_PARTS = (
    "interpolation",
    "preset",
    "warned points",
)


@dataclass(frozen=True, slots=True)
class RiseError:
    """Numerical error of a temperature rise, split into three parts by cause.

    The parts are relative to the rise; `times` converts them to K. A part is None if unknown.
    """

    interpolation: float | None
    preset: float | None
    warned: float | None  # for points with a warning

    @classmethod
    def of(cls, parts: Array) -> RiseError:
        """Make an error from its parts (3,), in the order of the attributes; NaN if unknown."""
        return cls(*(None if math.isnan(part) else part for part in parts.tolist()))

    @property
    def parts(self) -> Array:
        """The parts as an array (3,), in the order of the attributes; NaN if unknown."""
        return np.array(astuple(self), float)

    @property
    def total(self) -> float | None:
        """Total error: root of the sum of squares of the parts; None if a part is unknown."""
        total = float(totals(self.parts))
        return None if math.isnan(total) else total

    @property
    def text(self) -> str:
        """The total error and its parts in words, with the unit K.

        The parts must already be in K: `RiseError.times` converts relative ones.
        """
        parts = dict(zip(_PARTS, astuple(self), strict=True))
        known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part)
        if unknown := " and ".join(name for name, part in parts.items() if part is None):
            beside = f" ({known})" if known else ""
            return f"not known, because a part is not: {unknown}{beside}"
        return f"± {self.total:.2g} K" + (f": {known}" if known else "")

    def times(self, factor: float) -> RiseError:
        """Multiply all parts by a factor; a factor of 0 makes unknown parts 0, too."""
        if factor == 0:
            return RiseError(0.0, 0.0, 0.0)
        return RiseError(*(None if part is None else factor * part for part in astuple(self)))


def totals(errors: Array) -> Array:
    """Total errors: root of the sum of squares over parts, the first axis of `errors`.

    A total is NaN if a part is unknown.
    """
    return np.asarray(np.sqrt(np.square(errors).sum(axis=0)))


@dataclass(frozen=True, eq=False)
class RisePlane:
    """Temperature rises [K] at the points of one surface, and the warnings of these points.

    Rises are per unit friction coefficient, without the effect of velocity on friction. `flags` are
    sums of `WarningKind` codes, `durations` the times of loading [s], and `is_left_out` is True for
    points that a search of the boundary did not need, all (n_load, n_velocity).
    """

    loads: Array
    velocities: Array
    rises: Array
    flags: Indices
    durations: Array
    is_left_out: Mask

    def is_done(self, loads: Array, velocities: Array) -> Mask:
        """Mask (k,) of k pairs of load and velocity: True for computed points."""
        at_load, at_velocity = loads[:, None] == self.loads, velocities[:, None] == self.velocities
        done = at_load @ self._is_done
        return np.asarray((done & at_velocity).any(axis=1))

    @functools.cached_property
    def _is_done(self) -> Mask:
        return np.isfinite(self.rises)

    def rests_on(self, loads: Array, velocities: Array) -> tuple[Indices, Indices]:
        """Indices of the points between which rises at k pairs of load and velocity are found.

        Returns the indices of two loads (k, 2), and of two velocities at each of these loads
        (k, 2, 2). At a computed point all indices are of this point. An index is -1 if there is no
        point.
        """
        along = _slots(self.velocities, velocities)
        rows = self._loads_around[along, _slots(self.loads, loads)]
        return rows, self._velocities_around[rows, along[:, None]]

    @functools.cached_property
    def _loads_around(self) -> Indices:
        """Indices of the two loads between which a rise is interpolated; -1 if there are none.

        The shape is (2 n_velocity + 1, 2 n_load + 1, 2), with axes for the slot of the velocity,
        the slot of the load, and the two loads. A slot is a value of the axis, a gap between two
        values, or the range beyond an end, numbered by `_slots`.
        """
        goes_on = self._is_done.sum(axis=1) >= 2  # rows that can be extrapolated
        reached = np.repeat(goes_on[None], 2 * len(self.velocities) + 1, axis=0)
        reached[1::2] |= self._is_done.T
        return _neighbours(reached)

    @functools.cached_property
    def _velocities_around(self) -> Indices:
        """Indices of the two velocities between which a rise is interpolated; -1 if there are none.

        The shape is (n_load, 2 n_velocity + 1, 2), with axes for the load, the slot of the
        velocity, and the two velocities. A slot is a value of the axis, a gap between two values,
        or the range beyond an end, numbered by `_slots`. Beyond an end the two are the nearest.
        """
        return _neighbours(self._is_done)

    @functools.cached_property
    def warned(self) -> Array:
        """Relative errors (load, velocity) of the rises that the points' warnings imply.

        An error is 0 at a point without warnings, and NaN if a warning's effect is unknown.
        """
        return warned_errors(self.flags, self.durations)


def planes_of(scene: Results, conditions: Conditions) -> tuple[RisePlane, ...]:
    """Make a `RisePlane` for each surface of a scene: temperature rises and warnings of its points.

    The rises are those of the contact temperature that the criterion of `conditions` compares with
    the critical temperature, per unit friction coefficient. If friction depends on velocity, rises
    are divided by the ratio of friction at the point's velocity to the nominal coefficient of
    friction.
    """
    scene.require("time")
    rises = scene.rises(conditions) / conditions.friction_factor(scene.velocities)
    times = np.nan_to_num(scene.columns["time"], nan=-np.inf).max(axis=-1)
    shape = -1, *rises.shape[-2:]
    left_out = ~scene.asked & ~scene.done
    parts = (one.reshape(shape) for one in (rises, warning_flags(scene), times, left_out))
    axes = scene.loads, scene.velocities
    return tuple(RisePlane(*axes, *values) for values in zip(*parts, strict=True))


def rise_errors(
    grid: RisePlane, loads: Array, velocities: Array, velocity_error: float | None
) -> Array:
    """Relative errors of the temperature rises at k pairs of load and velocity, (3, k).

    The first axis has the causes: interpolation between points, the preset (grid and load steps),
    and warnings of the simulation. An unknown error is NaN. `grid` has the computed rises of one
    surface, between which others are interpolated.
    `velocity_error` is the relative error of the critical velocity due to the preset, or None if
    unknown.
    """
    rows, columns = grid.rests_on(loads, velocities)
    warned = grid.warned[rows[..., None], columns].max(axis=(1, 2))
    between = _interpolation(grid, rows, columns, loads, velocities)
    return np.stack(np.broadcast_arrays(between, preset_error(velocity_error), warned))


def _slots(points: Array, places: Array) -> Indices:
    """Number of the slot that each of `places` lies in, on an axis with n ascending `points`.

    `places` are loads or velocities. A slot is a point, a gap, or the range beyond an end. Slot
    2 i + 1 is point i. Slot 2 i is the gap between the points i − 1 and i. Slot 0 is the range
    below the first point, and slot 2 n the range above the last.
    """
    slots: Indices = 2 * np.searchsorted(points, places) + np.isin(places, points)
    return slots


def preset_error(velocity_error: float | None) -> float:
    """Relative error of a temperature rise due to the preset, which sets the grid and load steps.

    It is `velocity_error`, the relative error of the critical velocity due to the preset, times
    the measured ratio `SHARE`. The result is NaN if `velocity_error` is None (unknown).
    """
    return math.nan if velocity_error is None else SHARE * velocity_error


def _neighbours(is_done: Mask) -> Indices:
    """Indices of the two done points to interpolate between, (r, 2 n + 1, 2).

    `is_done` is the mask of done points (r, n) in r rows. The second axis of the result has the
    slots of a row, numbered by `_slots`: points, gaps, and the ranges beyond both ends. A slot that
    is a done point has this point twice. Other slots have the nearest done points on either side;
    beyond the first or last one, the nearest two. In a row with a single done point all slots have
    this point twice. In an empty row indices are -1.
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
    """Relative errors (k,) of rises at k pairs of load and velocity due to interpolation.

    Each rise is interpolated between points of `grid`. `rows` (k, 2) are the indices of two loads,
    and `columns` (k, 2, 2) those of two velocities at each of these loads, from
    `RisePlane.rests_on`. Beyond the two velocities the error is that of extrapolation. An error is
    NaN outside the two loads, or if `grid` has too few points to estimate the error.
    """
    (lowest, highest), places = grid.loads[rows].T, velocities[:, None]
    first, last = np.moveaxis(grid.velocities[columns], -1, 0)
    gaps = np.log(last / first)
    way = np.maximum(np.log(first / places), np.log(places / last))
    slope_error = np.hypot(_slope_spread(grid), BEYOND * (way + gaps))
    beyond = np.where((gaps > 0) & (way > 0), way * slope_error, 0.0).max(axis=1)
    along = np.where(beyond > 0, beyond, _gap_errors(grid, "velocity", gaps.max(axis=1)))
    errors = np.hypot(along, _gap_errors(grid, "load", np.log(highest / lowest)))
    # Rises are not extrapolated beyond the loads.
    is_known = (rows[:, 0] >= 0) & (lowest <= loads) & (loads <= highest)
    return np.where(is_known, errors, math.nan)


def _gap_errors(grid: RisePlane, axis: str, gaps: Array) -> Array:
    """Relative errors (k,) of rises that are interpolated along `axis`, "load" or "velocity".

    Each of `gaps` (k,) is the difference of ln(load) or ln(velocity) between the two computed
    points on either side. A gap is 0 at a computed point, and so is the error. An error is NaN if
    `grid` has too few points to estimate it.
    """
    found = BETWEEN * _left_out_error(grid, axis) * gaps ** _power(grid, axis)
    if axis == "velocity" and grid.is_left_out.any():
        found = np.fmax(found, ROUGH * gaps)
    return np.where(gaps > 0, found, 0.0)


def _power(grid: RisePlane, axis: str) -> int:
    """Power of the gap that an error of interpolation grows with.

    It is 1 between neighbours of a whole plane, where the rise is rough. Far from the boundary a
    search leaves wide gaps, where the curvature counts.
    """
    return 2 if axis == "velocity" and grid.is_left_out.any() else 1


@functools.lru_cache(maxsize=1024)  # many places are between the same points
def _left_out_error(grid: RisePlane, axis: str) -> float:
    """Root mean square of error of ln(rise) over gap, over points that are left out in turn.

    The gap is taken to its `_power`. A left-out point is interpolated from the others along `axis`,
    load or velocity. The gap is the difference of ln(load) or ln(velocity) between the neighbours
    of the point. The result is NaN if no point can be interpolated.
    """
    if axis == "load" and grid.is_left_out.any():
        every = _left_out_loads(grid)
        return float(np.sqrt(np.mean(every**2))) if every.size else math.nan
    lines = (grid.velocities, grid.rises) if axis == "velocity" else (grid.loads, grid.rises.T)
    room = (0, 0), (1, 1)
    # The cubic at a place is made of two points on either side.
    x, y = (
        sliding_window_view(np.pad(part, room, constant_values=math.nan), 5, axis=1)
        for part in _logarithms(*lines)
    )
    curves = Curve(*(np.exp(np.delete(part, 2, axis=-1)) for part in (x, y)))
    gaps = (x[..., 3] - x[..., 1]) ** _power(grid, axis)
    missed = (np.log(curves(np.exp(x[..., [2]]))[..., 0]) - y[..., 2]) / gaps
    every = missed[np.isfinite(missed)]
    return float(np.sqrt(np.mean(every**2))) if every.size else math.nan


def _left_out_loads(grid: RisePlane) -> Array:
    """(Error of ln(rise))/gap of each inner load, interpolated from the others; a searched plane.

    Rises are interpolated along lines of equal rise, as at loads that the search left out.
    """
    aligned, found = Alignment.of(grid.loads, grid.velocities, grid.rises), []
    for number in range(1, len(aligned.rows) - 1):
        load, rises = grid.loads[aligned.rows[number]], grid.rises[aligned.rows[number]]
        known = np.isfinite(rises) & (rises > 0)
        told = aligned.without(number).at(load, grid.velocities[known])
        before, after = grid.loads[aligned.rows[[number - 1, number + 1]]]
        found.append(np.log(told / rises[known]) / np.log(after / before))
    return np.concatenate(found) if found else np.empty(0)


@functools.lru_cache(maxsize=1024)  # many places are beyond the same points
def _slope_spread(grid: RisePlane) -> float:
    """Standard deviation of the slopes d ln(rise)/d ln(velocity) of the points in `grid`.

    Slopes are between neighbouring velocities at the same load. Without any slope the result is 0.
    """
    x, y = _logarithms(grid.velocities, grid.rises)
    slopes = np.diff(y) / np.diff(x)
    slopes = slopes[np.isfinite(slopes)]
    return float(np.std(slopes)) if slopes.size else 0.0


def _logarithms(x: Array, rows: Array) -> tuple[Array, Array]:
    """Logarithms of the known points of curves: abscissae `x` and ordinates `rows`, then NaN.

    Points that are not positive count as unknown.
    """
    is_known = np.isfinite(rows) & (rows > 0) & (x > 0)
    curves = Curve(np.where(is_known, x, math.nan), rows)
    return np.log(curves.x), np.log(curves.y)


def warned_errors(flags: Indices, durations: Array) -> Array:
    """Relative errors of rises that the warnings of their points imply.

    An error is 0 at a point without warnings, and NaN if a warning's effect is unknown. Of several
    warnings the one with the largest error counts. `flags` are sums of `WarningKind` codes, and
    `durations` the times of loading [s].
    """
    is_warm = (flags & int(WarningKind.PRESENT_HEAT)) > 0
    warm = np.interp(np.log(np.where(is_warm, durations, 1.0)), np.log(_DURATIONS), _TOO_WARM)
    errors = np.where(is_warm, warm, 0.0)
    for kind in {*WarningKind} - {WarningKind.PRESENT_HEAT}:
        is_kind = (flags & int(kind)) > 0
        errors = np.where(is_kind, np.maximum(errors, _OF_WARNED.get(kind, math.nan)), errors)
    return errors

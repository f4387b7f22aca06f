"""Error of the deciding rise at a place of a sweep, in three parts that belong together.

- Interpolation: 0 only where that very point is done.
- Preset: its promised error of the boundary velocity, times the exponent n of rise ∝ Vⁿ.
- Warnings: those of the points that the rise rests on.

A part that is not known is None, and so is the sum.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass

import numpy as np
import scipy  # loads its parts when they are used
import xarray as xr

from pipeline.analysis.dataset import asked, stored_sweep, with_steps
from pipeline.analysis.warned_points import warnings_of
from pipeline.sweep.accuracy import velocity_error
from tribo import WarningKind
from tribo.simulation.point_warnings import SLOWEST
from tribo.types import Array, Indices, Mask

_OF_WARNED = {
    WarningKind.FEW_STEPS: 0.10,
    WarningKind.FEW_TURNS: 0.10,
    WarningKind.COARSE_PIXELS: 0.70,
    # Of 122 random scenes, none to heavily worn, in windows of 48 to 128 pixels: `draft` missed the
    # highest rise under a ball by 36 %, under a cylinder by 28 % at most, the rise that 10 % exceed
    # by 26 and 16 %; `standard` by 21 and 14, 6 and 2 %. 95 % of cylinders were within 4 %. Of 283
    # others (ACCURACY.md) the largest were 20 and 8 %.
    WarningKind.FEW_NODES: 0.36,
    # `draft` was up to 21 % off in velocity where the exponent is below 0.3: 1.21^0.3 − 1.
    WarningKind.SLOW_RISE: 0.06,
}
"""Largest relative error of the rise that was seen with each warning; others have none known."""

_DURATIONS, _TOO_WARM = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and how much present heat makes contacts too warm at most.

The table of ACCURACY.md; 5 % is that of loads that jump late, also in longer tests.
"""


@dataclass(frozen=True, slots=True)
class RiseError:
    """Relative error of a rise by its three parts; None where a part is not known."""

    interpolation: float | None
    preset: float | None
    warned: float | None

    @property
    def total(self) -> float | None:
        """Sum of the parts; None where one is."""
        parts = astuple(self)
        return None if None in parts else sum(filter(None, parts))

    @property
    def worded(self) -> str:
        """The error [K] and its parts in words."""
        names = "interpolation", "preset", "warned points"
        parts = dict(zip(names, astuple(self), strict=True))
        known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part)
        if unknown := " and ".join(name for name, part in parts.items() if part is None):
            beside = f" ({known})" if known else ""
            return f"not known, since that of {unknown} is not known{beside}"
        return f"± {self.total:.2g} K" + (f": {known}" if known else "")

    def times(self, factor: float) -> RiseError:
        """The parts times a factor; all are 0 where the factor is 0."""
        if factor == 0:
            return RiseError(0.0, 0.0, 0.0)
        return RiseError(*(None if part is None else factor * part for part in astuple(self)))


@dataclass(frozen=True, slots=True, eq=False)
class RisePlane:
    """Deciding rises by load and velocity [K], NaN where not done; flags of warnings; times [s]."""

    loads: Array
    velocities: Array
    rises: Array
    is_missing: Mask  # asked for, and not done
    flags: Indices
    durations: Array

    @classmethod
    def joined(cls, planes: Sequence[RisePlane]) -> RisePlane:
        """Planes of places on a cross as one."""
        loads = np.unique(np.concatenate([plane.loads for plane in planes]))
        velocities = np.unique(np.concatenate([plane.velocities for plane in planes]))
        rises = np.full((len(loads), len(velocities)), np.nan)
        rest = (np.zeros(rises.shape, kind) for kind in (bool, int, float))
        whole = cls(loads, velocities, rises, *rest)
        for plane in planes:
            here = np.ix_(np.isin(loads, plane.loads), np.isin(velocities, plane.velocities))
            for name in ("rises", "is_missing", "flags", "durations"):
                getattr(whole, name)[here] = getattr(plane, name)
        return whole

    def beneath(self, load: float, velocity: float) -> Mask:
        """Mask of the points that the rise at a place is taken from."""
        mask = np.zeros(self.rises.shape, bool)
        for row, columns in self.rests_on(load, velocity):
            mask[row, columns] = True
        return mask

    def rests_on(self, load: float, velocity: float) -> list[tuple[int, Indices]]:
        """Rows that the rise at a place is taken from: the point itself, or those beside it."""
        own = self.loads == load
        reached = np.isfinite(self.rises).sum(axis=1) >= 2  # which go on beyond their ends
        reached |= np.isfinite(self.rises[:, self.velocities == velocity]).any(axis=1)
        beside = _beside(self.loads, own if (own & reached).any() else reached, load)
        points = (
            (int(row), _beside(self.velocities, np.isfinite(self.rises[row]), velocity))
            for row in beside
        )
        return [(row, places) for row, places in points if places.size]


def grids_of(ds: xr.Dataset, rise: xr.DataArray) -> list[RisePlane]:
    """Grid of each surface of a sweep, by its deciding rises."""
    shape = -1, *rise.shape[-2:]
    duration = with_steps(ds, "time")["time"].max("step")
    of_rows = rise, rise.isnull() & asked(ds), warnings_of(ds), duration
    parts = (part.transpose(*rise.dims).values.reshape(shape) for part in of_rows)
    axes = rise["load"].values, rise["velocity"].values
    return [RisePlane(*axes, *values) for values in zip(*parts, strict=True)]


def error_table(ds: xr.Dataset, rise: xr.DataArray) -> Array:
    """Relative error of the rise on and midway between loads and velocities, by surface."""
    promised = velocity_error(stored_sweep(ds))
    twice = (np.repeat(rise[name].values, 2) for name in ("load", "velocity"))
    loads, velocities = (((x[1:] + x[:-1]) / 2).tolist() for x in twice)
    totals = [
        rise_error(grid, load, velocity, promised).total
        for grid in grids_of(ds, rise)
        for load in loads
        for velocity in velocities
    ]
    return np.array(totals, dtype=float).reshape(-1, len(loads), len(velocities))


def rise_error(
    grid: RisePlane, load: float, velocity: float, velocity_error: float | None
) -> RiseError:
    """Relative error of the rise at a place, by the error of its preset in velocity."""
    rows = grid.rests_on(load, velocity)
    return RiseError(
        _interpolation(grid, rows, load, velocity),
        _preset(grid, rows, velocity, velocity_error),
        warned_error(
            (int(grid.flags[row, place]), float(grid.durations[row, place]))
            for row, places in rows
            for place in places
        ),
    )


def error_of_point(flags: int, duration: float, velocity_error: float | None) -> RiseError:
    """Relative error of the rise of a point by itself, which grows with exponent 1 at most."""
    return RiseError(0.0, velocity_error, warned_error([(flags, duration)]))


def _beside(x: Array, is_done: Array, place: float) -> Indices:
    """Indices of the done abscissa at a place, of both beside it, or of the last two."""
    (done,) = np.nonzero(is_done)
    same: Indices = done[x[done] == place]
    if same.size:
        return same
    above = int(np.clip(np.searchsorted(x[done], place), 1, max(len(done) - 1, 1)))
    either_side: Indices = done[above - 1 : above + 1]
    return either_side


def _interpolation(
    grid: RisePlane, rows: list[tuple[int, Indices]], load: float, velocity: float
) -> float | None:
    """Error of interpolating, or of continuing beyond the points; None if that is unknown."""
    if not rows:
        return None
    parts: list[float | None] = []
    if [grid.loads[row] for row, _ in rows] != [load]:
        ends = grid.loads[[row for row, _ in rows]]
        parts.append(_left_out(grid, "load", load, float(np.ptp(ends))))
    gaps = [grid.velocities[places] for _, places in rows if grid.velocities[places[0]] != velocity]
    if gaps and all(gap[0] < velocity < gap[-1] for gap in gaps):
        widest = max(float(np.ptp(gap)) for gap in gaps)
        parts.append(_left_out(grid, "velocity", velocity, widest))
    elif gaps:
        parts.append(_beyond(grid, velocity))
    return None if None in parts else sum(filter(None, parts))


def _left_out(grid: RisePlane, axis: str, place: float, gap: float) -> float | None:
    """Error along an axis, as that of done points left out, by the squares of the gaps."""
    x = grid.loads if axis == "load" else grid.velocities
    missed, widths = _misses(grid, axis, int(np.searchsorted(x, place)), bool((x == place).any()))
    errors = missed * np.maximum(1.0, gap / widths) ** 2
    return float(np.sqrt(np.mean(errors**2))) if errors.size else None


@functools.lru_cache(maxsize=1024)  # of many places between the same points
def _misses(grid: RisePlane, axis: str, above: int, is_on: bool) -> tuple[Array, Array]:
    """Relative misses at the points next to a place, on all lines, and the gaps without them."""
    x, rows = grid.velocities, grid.rises
    if axis == "load":
        x, rows = grid.loads, grid.rises.T
    is_known = np.isfinite(rows) & (rows > 0) & (x > 0)
    missed, widths = [np.empty(0)], [np.empty(0)]
    for mask in np.unique(is_known, axis=0):
        (known,) = np.nonzero(mask)
        alike = np.log(rows[(is_known == mask).all(axis=1)][:, known])
        first = int(np.searchsorted(known, above))
        on_point = is_on and first < len(known) and known[first] == above
        for line in (first - 1, first + on_point):
            if 0 < line < len(known) - 1:
                others = np.delete(np.arange(len(known)), line)
                curve = scipy.interpolate.PchipInterpolator(
                    np.log(x[known[others]]), alike[:, others], axis=1
                )
                missed.append(np.expm1(curve(math.log(x[known[line]])) - alike[:, line]))
                width = x[known[line + 1]] - x[known[line - 1]]
                widths.append(np.full(len(alike), width))
    return np.concatenate(missed), np.concatenate(widths)


def _beyond(grid: RisePlane, velocity: float) -> float | None:
    """Error of continuing to a velocity; None if that is unknown.

    The exponent of the power law beyond the points is taken to differ from that of the last two by
    twice the standard deviation of all exponents between neighbours. Beside whole diagrams of a
    worn pin and of one warmer than its disk once that was exceeded at none of 14 and at 36 % of 201
    points.
    """
    slopes, ways = [], [0.0]
    for row in grid.rises:
        counts = np.isfinite(row) & (row > 0) & (grid.velocities > 0)
        x, y = np.log(grid.velocities[counts]), np.log(row[counts])
        if len(x) >= 2:
            slopes += list(np.diff(y) / np.diff(x))
            ways += [x[0] - math.log(velocity), math.log(velocity) - x[-1]]
    return float(2 * np.std(slopes, ddof=1) * max(ways)) if len(slopes) >= 2 else None


def _preset(
    grid: RisePlane, rows: list[tuple[int, Indices]], velocity: float, velocity_error: float | None
) -> float | None:
    """Error of the rise by that of velocity, with exponents from `SLOWEST`, as tried, to 1."""
    if velocity_error is None or not rows:
        return None
    exponents = [_exponent(grid.velocities, grid.rises[row], velocity) for row, _ in rows]
    steepest = min(max(*exponents, SLOWEST), 1.0)
    return math.expm1(steepest * math.log1p(velocity_error))


def _exponent(x: Array, y: Array, place: float) -> float:
    """Exponent d ln(y)/d ln(x) between the done points about a place; 1 where it is not known."""
    is_known = np.isfinite(y) & (y > 0) & (x > 0)
    x, y = x[is_known], y[is_known]
    if len(x) < 2:
        return 1.0
    low = int(np.clip(np.searchsorted(x, place) - 1, 0, len(x) - 2))
    high = int(np.clip(np.searchsorted(x, place, "right"), low + 1, len(x) - 1))
    return math.log(y[high] / y[low]) / math.log(x[high] / x[low])


def warned_error(points: Iterable[tuple[int, float]]) -> float | None:
    """Error that warnings of points stand for, by flags and durations [s]; None if unknown."""
    errors = [0.0]
    for flags, duration in points:
        kinds = {kind for kind in WarningKind if kind & flags}
        if WarningKind.PRESENT_HEAT in kinds:
            errors.append(float(np.interp(math.log(duration), np.log(_DURATIONS), _TOO_WARM)))
            kinds.remove(WarningKind.PRESENT_HEAT)
        if kinds - _OF_WARNED.keys():
            return None
        errors += [_OF_WARNED[kind] for kind in kinds]
    return max(errors)

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
from collections.abc import Iterable, Iterator
from dataclasses import astuple, dataclass, replace

import numpy as np

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
    # The elements are the pixels then. Other surfaces and smaller pixels are no error of these.
    WarningKind.FEW_NODES: 0.01,
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

    @property
    def total(self) -> float | None:
        """Root of the sum of the squares of the parts; None where one is not known."""
        every = self.interpolation, self.preset, self.warned, self.counted  # asked a million times
        parts = [part for part in every if part is not None]
        return math.hypot(*parts) if len(parts) == len(_PARTS) else None

    @property
    def worded(self) -> str:
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


@dataclass(frozen=True, eq=False)
class RisePlane:
    """Deciding rises by load and velocity [K], NaN where not done; flags of warnings; times [s]."""

    loads: Array
    velocities: Array
    rises: Array
    flags: Indices
    durations: Array
    is_solved: Mask  # friction by temperature is, for the conditions

    def rests_on_solved(self, load: float, velocity: float) -> bool:
        """True if friction by temperature is solved at all points that a rise is taken from."""
        rests_on = self.rests_on(load, velocity)
        return all(self.is_solved[row, places].all() for row, places in rests_on)

    def is_done(self, loads: Array, velocities: Array) -> Mask:
        """True at places (k,) whose very point is done."""
        at_load, at_velocity = loads[:, None] == self.loads, velocities[:, None] == self.velocities
        done = at_load @ self._is_done
        return np.asarray((done & at_velocity).any(axis=1))

    @functools.cached_property
    def _is_done(self) -> Mask:
        return np.isfinite(self.rises)

    @functools.cached_property
    def _goes_on(self) -> Mask:
        return np.asarray(self._is_done.sum(axis=1) >= 2)

    def rests_on(self, load: float, velocity: float) -> list[tuple[int, Indices]]:
        """Rows that the rise at a place is taken from: the point itself, or those beside it."""
        own = self.loads == load
        # Rows of two points go on beyond their ends.
        reached = self._goes_on | self._is_done[:, self.velocities == velocity].any(axis=1)
        beside = _neighbours(self.loads, own if (own & reached).any() else reached, load)
        points = (
            (int(row), _neighbours(self.velocities, self._is_done[row], velocity)) for row in beside
        )
        return [(row, places) for row, places in points if places.size]


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
) -> list[RiseError]:
    """Relative errors of the rise at places (k,), by the error of its preset in velocity.

    Places between the same points rest on the same ones.
    """
    slots = np.stack([_slots(grid.loads, loads), _slots(grid.velocities, velocities)])
    _, first, alike = np.unique(slots, axis=1, return_index=True, return_inverse=True)
    errors = np.empty(len(loads), dtype=object)
    for number, place in enumerate(first.tolist()):
        (here,) = np.nonzero(alike.ravel() == number)
        load = float(loads[place])
        rows = grid.rests_on(load, float(velocities[place]))
        preset = _preset(velocity_error) if rows else None
        warned = warned_error(
            (int(grid.flags[row, place]), float(grid.durations[row, place]))
            for row, places in rows
            for place in places
        )
        between = _interpolation(grid, rows, load, velocities[here])
        parts = np.broadcast_to(np.nan if between is None else between, here.shape).tolist()
        errors[here] = [
            RiseError(None if math.isnan(part) else part, preset, warned) for part in parts
        ]
    return errors.tolist()


def _slots(points: Array, places: Array) -> Indices:
    """Numbers of the points, and of the intervals between them, in which places lie."""
    slots: Indices = 2 * np.searchsorted(points, places) - ~np.isin(places, points)
    return slots


def error_of_point(flags: int, duration: float, velocity_error: float | None) -> RiseError:
    """Relative error of the rise of a point by itself."""
    return RiseError(0.0, _preset(velocity_error), warned_error([(flags, duration)]))


def add_counted(
    error: RiseError, conditions: Conditions, rise: float | None = None, is_solved: bool = False
) -> RiseError:
    """The error with that of what is counted after the simulation: a film, friction when warm.

    A rise at friction 1 [K] that friction may ignite has no known error, unless it is solved.
    """
    if (parts := conditions.corrections) is None:
        return error
    law = conditions.friction_law
    film = _OF_FILM if parts.film_resistance else 0.0
    if is_solved or not (law.by_temperature and law.coefficient):
        return replace(error, counted=film)
    if rise is not None and conditions.may_ignite(rise):
        return replace(error, counted=None)
    bulk = conditions.coldest_bulk_temperature
    change = law.spread(bulk, conditions.critical_temperature or bulk)
    return replace(error, counted=math.hypot(film, _OF_FRICTION * change))


def _preset(velocity_error: float | None) -> float | None:
    return None if velocity_error is None else SHARE * velocity_error


def _neighbours(x: Array, is_done: Mask, place: float) -> Indices:
    """Indices of the done abscissa at a place, of both beside it, or of the last two."""
    (done,) = np.nonzero(is_done)
    same: Indices = done[x[done] == place]
    if same.size:
        return same
    above = int(np.clip(np.searchsorted(x[done], place), 1, max(len(done) - 1, 1)))
    either_side: Indices = done[above - 1 : above + 1]
    return either_side


def _interpolation(
    grid: RisePlane, rows: list[tuple[int, Indices]], load: float, velocities: Array
) -> Array | float | None:
    """Error of interpolating, or of continuing beyond the points; None if that is unknown.

    Velocities lie between the same points.
    """
    gaps = [grid.velocities[places] for _, places in rows if len(places) > 1]
    if not rows or any(gap[0] < 0 for gap in gaps):
        return None
    parts: list[Array | float | None] = []
    loads = grid.loads[[row for row, _ in rows]]
    if not loads[0] <= load <= loads[-1]:  # no rise is known beyond the loads
        return None
    if len(loads) > 1:
        parts.append(_gap_error(grid, "load", loads))
    if gaps and all(0 < gap[0] < velocities[0] < gap[-1] for gap in gaps):
        parts.append(_gap_error(grid, "velocity", max(gaps, key=lambda gap: gap[-1] / gap[0])))
    elif gaps:
        beyond = [_extrapolation_errors(grid, gap, velocities) for gap in gaps]
        parts.append(np.max(beyond, axis=0))
    squares = [part**2 for part in parts if part is not None]
    return np.sqrt(sum(squares)) if len(squares) == len(parts) else None


def _gap_error(grid: RisePlane, axis: str, gap: Array) -> float | None:
    """Error of interpolating in a gap along an axis, by what leaving out points has missed."""
    missed = _missed(grid, axis)
    return None if missed is None else BETWEEN * missed * math.log(gap[-1] / gap[0])


@functools.lru_cache(maxsize=1024)  # many places lie between the same points
def _missed(grid: RisePlane, axis: str) -> float | None:
    """Root mean square of what interpolation misses left-out points by, over ln of the gap."""
    lines = (grid.velocities, grid.rises) if axis == "velocity" else (grid.loads, grid.rises.T)
    missed = [np.empty(0)]
    for x, y in _powers(*lines):
        for place in range(1, len(x) - 1):
            others = np.delete(np.arange(len(x)), place)
            found = np.log(Curve(np.exp(x[others]), np.exp(y[:, others]))(np.exp(x[[place]])))
            missed.append((found[:, 0] - y[:, place]) / (x[place + 1] - x[place - 1]))
    every = np.concatenate(missed)
    return float(np.sqrt(np.mean(every**2))) if every.size else None


def _extrapolation_errors(grid: RisePlane, nearest: Array, velocities: Array) -> Array:
    """Errors of extrapolating from the nearest velocities: the exponent changes with distance."""
    way = np.maximum(np.log(nearest[0] / velocities), np.log(velocities / nearest[-1]))
    further = way + math.log(nearest[-1] / nearest[0])
    return np.asarray(way * np.hypot(_slope_spread(grid), BEYOND * further))


@functools.lru_cache(maxsize=1024)  # many places lie beyond the same points
def _slope_spread(grid: RisePlane) -> float:
    """Standard deviation of the exponent of the velocity between neighbouring points."""
    lines = _powers(grid.velocities, grid.rises)
    slopes = np.concatenate([(np.diff(y) / np.diff(x)).ravel() for x, y in lines])
    return float(np.std(slopes)) if slopes.size else 0.0


def _powers(x: Array, rows: Array) -> Iterator[tuple[Array, Array]]:
    """Logarithms of abscissae and of the lines whose rises are known at the same ones."""
    is_known = np.isfinite(rows) & (rows > 0) & (x > 0)
    for mask in np.unique(is_known, axis=0):
        yield np.log(x[mask]), np.log(rows[(is_known == mask).all(axis=1)][:, mask])


def warned_error(points: Iterable[tuple[int, float]]) -> float | None:
    """Error that warnings of points stand for, by flags and durations [s]; None if unknown."""
    errors = [0.0]
    for flags, duration in points:
        if not flags:
            continue
        kinds = {kind for kind in WarningKind if kind & flags}
        if WarningKind.PRESENT_HEAT in kinds:
            errors.append(float(np.interp(math.log(duration), np.log(_DURATIONS), _TOO_WARM)))
            kinds.remove(WarningKind.PRESENT_HEAT)
        if kinds - _OF_WARNED.keys():
            return None
        errors += [_OF_WARNED[kind] for kind in kinds]
    return max(errors)

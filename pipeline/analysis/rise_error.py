"""Numerical error of a temperature rise at any load and velocity of a sweep, in independent parts.

The rise is that of the contact temperature which the criterion compares with the critical
temperature. The parts are due to:

- Interpolation: the error is 0 only at a computed point.
- The preset's numerical choices: from the promised error of the critical velocity.
- Warnings: those of the points between which the rise is interpolated.
- The surface: another part of the same surface has other summits (`pipeline.analysis.specimen`).

Each part is a bound that holds for at least 95 % of operating points. The parts are independent,
so that their squares add. An unknown part is None, and makes the total None.
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
from pipeline.analysis.left_out import Alignment, gap_bounds
from pipeline.analysis.rises import Places, Rises, places_of
from pipeline.constants import BETWEEN, BETWEEN_LOADS, BEYOND, OF_WARNED, RISE_SHARE
from tribo import WarningKind
from tribo.types import Array, Indices

_DURATIONS, _TOO_WARM = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and the largest relative error of rises with the heat model "elapsed".

This model lets the present friction heat act since the start. 5 % is for loads that jump late, also
in longer tests. On ramps of seconds the error was 1 %. Judged by
`python -m tests.promises.past_heat`.
"""


_BESIDE = 1.01  # ratio of velocities between which an exponent is taken

_PARTS = (
    "interpolation",
    "preset",
    "warned points",
    "surface",
)
INTERPOLATION, PRESET, WARNED, SURFACE = range(len(_PARTS))
"""Places of the parts among the parts of an error."""


@dataclass(frozen=True, slots=True)
class RiseError:
    """Numerical error of a temperature rise, split into four parts by cause.

    The parts are relative to the rise; `times` converts them to K. A part is None if unknown.
    """

    interpolation: float | None
    preset: float | None
    warned: float | None  # for points with a warning
    surface: float | None  # of the patches that were computed

    @classmethod
    def of(cls, parts: Array) -> RiseError:
        """Make an error from its parts (4,), in the order of the attributes; NaN if unknown."""
        return cls(*(None if math.isnan(part) else part for part in parts.tolist()))

    @property
    def parts(self) -> Array:
        """The parts as an array (4,), in the order of the attributes; NaN if unknown."""
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
            return RiseError(0.0, 0.0, 0.0, 0.0)
        return RiseError(*(None if part is None else factor * part for part in astuple(self)))


def totals(errors: Array) -> Array:
    """Total errors: root of the sum of squares over parts, the first axis of `errors`.

    A total is NaN if a part is unknown.
    """
    return np.asarray(np.sqrt(np.square(errors).sum(axis=0)))


def rise_errors(rises: Rises, loads: Places, velocities: Places) -> Array:
    """Relative errors of the temperature rises at k pairs of load and velocity, (4, k).

    The first axis has the causes: interpolation between points, the preset (grid and load steps),
    warnings of the simulation, and the choice of patches. An unknown error is NaN.
    """
    loads, velocities = places_of(loads, velocities)
    rows, columns = rises.rests_on(loads, velocities)
    warned = warned_errors(rises.flags, rises.durations)[rows[..., None], columns].max(axis=(1, 2))
    between = _interpolation(rises, rows, columns, loads, velocities)
    surface = np.sqrt(np.square(rises.surface)[rows[..., None], columns].mean(axis=(1, 2)))
    return np.stack(np.broadcast_arrays(between, preset_error(rises.promised), warned, surface))


def velocity_errors(rises: Rises, loads: Array, velocities: Array) -> Array:
    """Relative errors of the critical velocities at k loads by cause (4, k); see `rise_errors`.

    An error of the rise moves them by this error over the exponent d ln(rise)/d ln(velocity); what
    a preset promises is an error of the velocity. An unknown error is NaN.
    """
    ahead, behind = (rises.y(loads, velocities * _BESIDE**way) for way in (1, -1))
    exponents = np.abs(ahead - behind) / (2 * math.log(_BESIDE))
    parts = rise_errors(rises, loads, velocities)
    parts /= np.where(exponents > 0, exponents, math.nan)
    promised = math.nan if rises.promised is None else rises.promised
    parts[PRESET] = np.where(np.isnan(velocities), math.nan, promised)
    return parts


def preset_error(velocity_error: float | None) -> float:
    """Relative error of a temperature rise due to the preset, which sets the grid and load steps.

    It is `velocity_error`, the relative error of the critical velocity due to the preset, times
    the measured ratio `RISE_SHARE`. The result is NaN if `velocity_error` is None (unknown).
    """
    return math.nan if velocity_error is None else RISE_SHARE * velocity_error


def _interpolation(
    rises: Rises, rows: Indices, columns: Indices, loads: Array, velocities: Array
) -> Array:
    """Relative errors (k,) of rises interpolated between the points that `Rises.rests_on` names."""
    lowest, highest = rises.loads[rows].T
    along = _along_velocity(rises, loads, velocities)
    errors = np.hypot(along, _between_loads(rises, np.log(highest / lowest)))
    # Rises are not extrapolated beyond the loads.
    is_known = (rows[:, 0] >= 0) & (lowest <= loads) & (loads <= highest)
    return np.where(is_known, errors, math.nan)


def _between_loads(rises: Rises, gaps: Array) -> Array:
    """Relative errors (k,) along load, across `gaps` of ln(load); NaN with too few loads."""
    factor, power = (BETWEEN_LOADS, 2) if rises.is_left_out.any() else (BETWEEN, 1)
    return np.where(gaps > 0, factor * _left_out_error(rises) * gaps**power, 0.0)


def _along_velocity(rises: Rises, loads: Array, velocities: Array) -> Array:
    """Relative errors (k,) of rises between or beyond the computed velocities."""
    aligned = Alignment.of(rises.loads, rises.velocities, rises.plane)
    errors = np.full(len(loads), math.nan)
    for load in np.unique(loads):
        here, rows, shifts = loads == load, np.flatnonzero(rises.loads == load), np.zeros(1)
        if not (rows.size and np.isfinite(rises.plane[rows[0]]).any()):
            if len(aligned.rows) < 2:
                continue
            above = int(np.searchsorted(rises.loads[aligned.rows], load))
            beside = np.clip(above, 1, len(aligned.rows) - 1) + np.array([-1, 0])
            rows, shifts = aligned.rows[beside], aligned.shifts(np.array([load]))[beside, 0]
        errors[here] = np.max(
            [
                _along_row(rises, int(row), velocities[here] * math.exp(shift))
                for row, shift in zip(rows, shifts, strict=True)
            ],
            axis=0,
        )
    return errors


def _along_row(rises: Rises, row: int, places: Array) -> Array:
    """Relative errors (k,) at velocities of one computed load."""
    known = np.flatnonzero(np.isfinite(rises.plane[row]) & (rises.plane[row] > 0))
    if not known.size:
        return np.full(len(places), math.nan)
    x, at = np.log(rises.velocities[known]), np.log(places)
    bounds = gap_bounds(x, np.log(rises.plane[row, known]))
    after = np.searchsorted(x, at)
    within = np.where(np.isin(places, rises.velocities[known]), 0.0, np.append(bounds, 0.0)[
        np.clip(after - 1, 0, len(bounds))
    ])  # fmt: skip
    way = np.maximum(x[0] - at, at - x[-1])
    gap = np.where(at < x[0], *(x[[min(1, len(x) - 1), -1]] - x[[0, max(len(x) - 2, 0)]]))
    beyond = way * np.hypot(_slope_spread(rises), BEYOND * (way + gap))
    return np.where(way > 0, beyond, within)


@functools.lru_cache(maxsize=1024)  # many places are between the same points
def _left_out_error(rises: Rises) -> float:
    """RMS of error of ln(rise) over gap of ln(load), or over gap², leaving loads out in turn."""
    if rises.is_left_out.any():
        every = _left_out_loads(rises)
        return float(np.sqrt(np.mean(every**2))) if every.size else math.nan
    room = (0, 0), (1, 1)
    # The cubic at a place is made of two points on either side.
    x, y = (
        sliding_window_view(np.pad(part, room, constant_values=math.nan), 5, axis=1)
        for part in _logarithms(rises.loads, rises.plane.T)
    )
    curves = Curve(*(np.exp(np.delete(part, 2, axis=-1)) for part in (x, y)))
    gaps = x[..., 3] - x[..., 1]
    missed = (np.log(curves(np.exp(x[..., [2]]))[..., 0]) - y[..., 2]) / gaps
    every = missed[np.isfinite(missed)]
    return float(np.sqrt(np.mean(every**2))) if every.size else math.nan


def _left_out_loads(rises: Rises) -> Array:
    """(Error of ln(rise))/gap² of each inner load, along lines of equal rise as after a search."""
    aligned, found = Alignment.of(rises.loads, rises.velocities, rises.plane), []
    for number in range(1, len(aligned.rows) - 1):
        load, known_here = rises.loads[aligned.rows[number]], rises.plane[aligned.rows[number]]
        known = np.isfinite(known_here) & (known_here > 0)
        told = aligned.without(number).at(load, rises.velocities[known])
        before, after = rises.loads[aligned.rows[[number - 1, number + 1]]]
        found.append(np.log(told / known_here[known]) / np.log(after / before) ** 2)
    return np.concatenate(found) if found else np.empty(0)


@functools.lru_cache(maxsize=1024)  # many places are beyond the same points
def _slope_spread(rises: Rises) -> float:
    """Standard deviation of d ln(rise)/d ln(velocity) between neighbours; 0 without any."""
    x, y = _logarithms(rises.velocities, rises.plane)
    slopes = np.diff(y) / np.diff(x)
    slopes = slopes[np.isfinite(slopes)]
    return float(np.std(slopes)) if slopes.size else 0.0


def _logarithms(x: Array, rows: Array) -> tuple[Array, Array]:
    """Logarithms of curves' known, positive points: abscissae `x`, ordinates `rows`, then NaN."""
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
        errors = np.where(is_kind, np.maximum(errors, OF_WARNED.get(kind, math.nan)), errors)
    return errors

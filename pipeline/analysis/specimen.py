"""A specimen from its patches: its rise at each place, and how far its patches may mislead.

Each surface of a sweep is a patch of one specimen. Patches differ by nearly a constant along
velocity, so a patch that lacks a place counts by its difference from the first patch at the nearest
place of that load that both have. At each load those patches count that have a point there. Loads
that the first patch has alone, between loads of several patches, are not counted: a single patch is
up to some percent off there, and the specimen's rises follow from the loads beside.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np
from scipy.special import stdtrit

from pipeline.analysis.results import Results
from pipeline.constants import ALONE_IN_LOCAL_WEAR
from pipeline.store.schema import FAILED, SAMPLING
from pipeline.sweep.conditions import Conditions
from tribo import Scene
from tribo.simulation.severity import relative_sampling
from tribo.thermal.sampling import GROUPS
from tribo.types import Array, Mask

_COLDEST = 1e-9  # least rise per unit friction coefficient [K], whose logarithm is taken
_FEWEST = 4  # patches that must stay, so that one that failed is left out
_BOUND = 0.975  # quantile of Student's t whose two sides bound 95 %


class Alone(NamedTuple):
    """What a patch alone tells of how patches differ, by its jackknife."""

    degrees: int  # of freedom
    factor: float  # of the deviation of patches over that which one states

    @classmethod
    def of(cls, scene: Scene) -> Alone:
        """What a patch of a scene tells."""
        return LOCAL if scene.wear is not None and scene.wear.pattern == "local" else SWEPT


SWEPT, LOCAL = Alone(GROUPS - 1, 1.0), Alone(*ALONE_IN_LOCAL_WEAR)


@dataclass(frozen=True, eq=False)
class Specimen:
    """ln(rise) of the patches of one specimen at its points, from which that of all follows.

    Attributes
    ----------
    loads, velocities : ndarray
        Loads [N] and velocities [m/s] of the points.
    first : ndarray, shape (n_load, n_velocity)
        ln(rise) on the level of the first patch; NaN where no patch has a result.
    differences : ndarray, shape (m, n_load, n_velocity)
        ln(rise) of each patch minus that of the first one; NaN at loads where it has no point.
    sampling : ndarray, shape (n_load,)
        Standard deviation of ln(rise) from patch to patch that the patches state themselves.
    is_alone : ndarray of bool, shape (n_load,)
        Loads of the first patch alone, between loads of several; its points there do not count.
    is_highest : bool
        True if the highest temperature decides. Then the specimen's is that of its hottest patch;
        the mean would be 4 to 8 % too low.
    alone : Alone
        What a patch alone tells of how patches differ.
    """

    loads: Array
    velocities: Array
    first: Array
    differences: Array
    sampling: Array
    is_alone: Mask
    is_highest: bool = False
    alone: Alone = SWEPT

    @classmethod
    def of(
        cls,
        loads: Array,
        velocities: Array,
        y: Array,
        sampling: Array,
        is_highest: bool = False,
        alone: Alone = SWEPT,
    ) -> Self:
        """Specimen from ln(rise) of its patches (m, n_load, n_velocity); NaN without a result.

        `sampling` has the deviations that the points state, of the same shape. The first patch,
        too, counts on its own level where only others have a result.
        """
        level, differences = y[0], [np.zeros_like(y[0])]
        for own in y[1:]:
            differences.append(_extended(own - y[0], loads))
            level = np.where(np.isnan(level), own - differences[-1], level)
        has_point = np.asarray(np.isfinite(y).any(axis=2))
        has_point[0] = has_point.any(axis=0)
        is_alone = _alone(has_point)
        known = np.where((has_point & ~is_alone)[..., None], np.array(differences), np.nan)
        level = np.where(is_alone[:, None], np.nan, level)
        states = _mean_square(sampling)
        return cls(loads, velocities, level, known, states, is_alone, is_highest, alone)

    @functools.cached_property
    def _counts(self) -> Array:
        """Number of patches with a point at each load (n_load,)."""
        return np.asarray(np.isfinite(self.differences[..., 0]).sum(axis=0))

    def _along_load(self, values: Array) -> Array:
        """Values (n_load, n_velocity), at loads without a point interpolated in ln(load)."""
        rows, x = self._counts > 0, np.log(self.loads)
        if rows.all() or not rows.any():
            return values
        return np.transpose([np.interp(x, x[rows], column) for column in values[rows].T])

    @functools.cached_property
    def apart(self) -> Array:
        """ln(rise) of the specimen minus that of the first patch (n_load, n_velocity)."""
        known = np.isfinite(self.differences)
        if self.is_highest:
            merged = np.where(known, self.differences, -np.inf).max(axis=0)
        else:
            total = np.where(known, self.differences, 0.0).sum(axis=0)
            merged = total / np.maximum(self._counts, 1)[:, None]
        return self._along_load(np.where(self._counts[:, None] > 0, merged, 0.0))

    @property
    def rises(self) -> Array:
        """Rises of the specimen per unit friction coefficient (n_load, n_velocity) [K]."""
        return np.asarray(np.exp(self.first + self.apart))

    def apart_at(self, load: float, velocity: float) -> float:
        """`apart` at a load [N] and a velocity [m/s], beyond the points that of the nearest."""
        along = [np.interp(velocity, self.velocities, row) for row in self.apart]
        return float(np.interp(math.log(load), np.log(self.loads), along))

    @functools.cached_property
    def error(self) -> Array:
        """Bound of ln(rise) at 95 % due to the choice of patches (n_load, n_velocity).

        At loads without a point it is interpolated. See `patches_bound`.
        """
        counts = self._counts[:, None]
        known = np.isfinite(self.differences)
        mean = np.where(known, self.differences, 0.0).sum(axis=0) / np.maximum(counts, 1)
        squares = np.where(known, (self.differences - mean) ** 2, 0.0).sum(axis=0)
        bound = patches_bound(counts, squares, self.sampling[:, None], self.is_highest, self.alone)
        return self._along_load(bound)


def patches_bound(
    count: Array | int,
    squares: Array | float,
    sampling: Array | float,
    is_highest: bool = False,
    alone: Alone = SWEPT,
) -> Array:
    """Bound of ln(rise) at 95 % due to the choice of `count` patches.

    The deviation s of a patch has the patches' own estimates J (`sampling`) and their spread, the
    sum of `squares` of the differences from their mean: s² = (7 J² + squares)/(6 + P). The bound of
    the mean of P patches is t s/√P, with Student's t of 6 + P degrees; the highest of them is as
    uncertain as one. It is NaN for a single patch that states nothing. With local wear a patch
    tells less, see `ALONE_IN_LOCAL_WEAR`.

    Examples
    --------
    >>> float(patches_bound(1, 0.0, 0.02).round(4)), float(patches_bound(16, 0.006, 0.02).round(4))
    (0.0473, 0.0104)
    """
    own = np.where(np.isnan(sampling), 0, alone.degrees)
    freedom = own + count - 1
    known = own * (alone.factor * np.nan_to_num(sampling)) ** 2 + squares
    deviation = np.sqrt(known / np.where(freedom > 0, freedom, np.nan))
    reduced = 1.0 if is_highest else np.sqrt(np.maximum(count, 1))
    return np.asarray(stdtrit(freedom, _BOUND) * deviation / reduced)


def patches_needed(
    count: int, ratio: float, most: int, is_highest: bool = False, alone: Alone = SWEPT
) -> int:
    """Number of patches, `most` at most, whose bound is that of `count` patches over `ratio`.

    It is taken that further patches differ as those that there are. The highest of them is as
    uncertain as one, so that no number suffices.

    Examples
    --------
    >>> patches_needed(1, 0.9, 256), patches_needed(1, 4.0, 256), patches_needed(8, 2.0, 20)
    (1, 13, 20)
    """
    if ratio <= 1:
        return count
    numbers = np.arange(1, most + 1)
    shares = patches_share(numbers, is_highest, alone)
    enough = numbers[shares <= shares[count - 1] / ratio]
    return int(enough[0]) if enough.size else most


def patches_share(count: Any, is_highest: bool = False, alone: Alone = SWEPT) -> Array:
    """Bound by `count` patches over the deviation of one; all state their own deviation."""
    bound = stdtrit(alone.degrees - 1 + count, _BOUND)
    return np.asarray(bound / (1.0 if is_highest else np.sqrt(count)))


def specimen_at(data: Results, conditions: Conditions) -> Specimen:
    """Specimen of one scene at its points, without the effect of velocity on friction."""
    plain = data.rises(conditions) / conditions.friction_factor(data.velocities)
    return specimen_of(data, plain, conditions)


def specimen_of(data: Results, rises: Array, conditions: Conditions) -> Specimen:
    """Specimen of one scene from rises at its points; NaN where a point has no result."""
    shape, counts = (-1, len(data.loads), len(data.velocities)), counted(data)
    rises = rises.reshape(shape)[counts]
    y = np.log(np.where(rises < _COLDEST, _COLDEST, rises))
    sampling = _sampling(data, conditions).reshape(shape)[counts]
    is_highest = conditions.criterion.is_highest
    alone = Alone.of(data.sweep.scene)
    return Specimen.of(data.loads, data.velocities, y, sampling, is_highest, alone)


def _alone(has_point: Mask) -> Mask:
    """Mask of the loads (n_load,) of one patch (m, n_load) between loads of several."""
    counts = has_point.sum(axis=0)
    several = np.flatnonzero(counts > 1)
    number = np.arange(len(counts))
    first, last = several[[0, -1]] if several.size else (0, 0)
    return np.asarray((counts == 1) & (first < number) & (number < last))


def _mean_square(sampling: Array) -> Array:
    """Root of the mean square over the points of each load (n_load,), where any is known."""
    known = np.isfinite(sampling)
    total = np.square(np.where(known, sampling, 0.0)).sum(axis=(0, 2))
    count = known.sum(axis=(0, 2))
    return np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def _sampling(data: Results, conditions: Conditions) -> Array:
    """`relative_sampling` at each point; NaN at a point that is not done."""
    data.require("rise_quantile", "mean_rise", *SAMPLING)
    relative = relative_sampling(data.columns, conditions, data.shares)
    return np.where(data.done, relative, np.nan)


def _extended(difference: Array, loads: Array) -> Array:
    """Differences from the first patch at all places, from those that both have."""
    known = np.isfinite(difference)
    rows = np.asarray(known.any(axis=1))
    number = np.arange(difference.shape[1])
    away = np.where(known[:, None, :], np.abs(number[:, None] - number), np.inf)
    # At each place the nearest known one of its load; NaN at a load without any.
    nearest = np.take_along_axis(difference, away.argmin(axis=-1), axis=1)
    between = [np.interp(np.log(loads), np.log(loads[rows]), one) for one in nearest[rows].T]
    return np.where(rows[:, None], nearest, np.transpose(between))


def counted(data: Results) -> Mask:
    """Mask of the patches of one scene that count, by their index (m,).

    A patch that failed somewhere is left out of the whole plane, if at least 4 others have each of
    its places. One that shares no place with the first patch waits, too.
    """
    done = data.done.reshape(-1, len(data.loads) * len(data.velocities))
    failed = failed_patches(data)
    others = done[~failed].sum(axis=0)
    replaced = failed & (~done | (others >= _FEWEST)).all(axis=1)
    counts: Mask = np.asarray(done.any(axis=1) & ~replaced)
    if not counts.any():
        counts[0] = True
    first = done[counts.argmax()]
    shares = (done & first).any(axis=1) | (not first.any())
    return np.asarray(counts & shares)


def note_on_failed(data: Results) -> str:
    """Which patches of one scene failed and are left out, in words; empty if there are none."""
    gone = failed_patches(data) & ~counted(data)
    if "realization" not in data.front or not gone.any():
        return ""
    seeds = ", ".join(map(str, data.rows["realization"].values[gone].tolist()))
    return f"left out as they failed at some point: the patches of seeds {seeds} (irg status STORE)"


def failed_patches(data: Results) -> Mask:
    """Mask of the patches of one scene that failed at a point (m,)."""
    shape = -1, len(data.loads) * len(data.velocities)
    return np.asarray((data.columns["status"] == FAILED).reshape(shape).any(axis=1))

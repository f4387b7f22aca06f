"""A specimen from its patches: its rise at each place, and how far its patches may mislead.

Each surface of a sweep is a patch of one specimen. Patches differ by nearly a constant along
velocity, so a patch that lacks a place counts by its difference from the first patch at the nearest
place of that load that both have, interpolated in ln(load) between loads. Places with few and with
many patches stand on one level.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from pipeline.analysis.results import Results
from pipeline.store.schema import FAILED
from pipeline.sweep.conditions import Conditions
from tribo.thermal.sampling import GROUPS
from tribo.types import Array, Mask

_COLDEST = 1e-9  # least rise per unit friction coefficient [K], whose logarithm is taken
_FEWEST = 4  # patches that must stay, so that one that failed is left out
_BOUND = 0.975  # quantile of Student's t whose two sides bound 95 %


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
        ln(rise) of each patch minus that of the first one.
    sampling : ndarray, shape (n_load, n_velocity)
        Standard deviation of ln(rise) from patch to patch that the patches state themselves.
    is_highest : bool
        True if the highest temperature decides. Then the specimen's is that of its hottest patch;
        the mean would be 4 to 8 % too low.
    """

    loads: Array
    velocities: Array
    first: Array
    differences: Array
    sampling: Array
    is_highest: bool = False

    @property
    def apart(self) -> Array:
        """ln(rise) of the specimen minus that of the first patch (n_load, n_velocity)."""
        merge = np.max if self.is_highest else np.mean
        return np.asarray(merge(self.differences, axis=0))

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

        The deviation s of a patch has the patches' own estimates J and their spread: s² = (7 J² +
        Σ(d − mean of d)²)/(6 + P). The bound of the mean of P patches is t s/√P, with Student's t
        of 6 + P degrees; the highest of them is as uncertain as one.
        """
        count, own = len(self.differences), np.where(np.isnan(self.sampling), 0, GROUPS - 1)
        spread = ((self.differences - self.differences.mean(axis=0)) ** 2).sum(axis=0)
        freedom = own + count - 1
        stated = np.nan_to_num(self.sampling)
        deviation = np.sqrt((own * stated**2 + spread) / np.where(freedom > 0, freedom, np.nan))
        reduced = 1.0 if self.is_highest else math.sqrt(count)
        return np.asarray(stdtrit(freedom, _BOUND) * deviation / reduced)


def specimen_at(data: Results, conditions: Conditions) -> Specimen:
    """Specimen of one scene at its points, without the effect of velocity on friction."""
    plain = data.rises(conditions) / conditions.friction_factor(data.velocities)
    return specimen_of(data, plain, conditions)


def specimen_of(data: Results, rises: Array, conditions: Conditions) -> Specimen:
    """Specimen of one scene from rises at its points; NaN where a point has no result.

    The first patch, too, counts on its own level where only others have a result.
    """
    shape, counts = (-1, len(data.loads), len(data.velocities)), counted(data)
    rises = rises.reshape(shape)[counts]
    y = np.log(np.where(rises < _COLDEST, _COLDEST, rises))
    level, differences = y[0], [np.zeros_like(y[0])]
    for own in y[1:]:
        differences.append(_extended(own - y[0], data.loads))
        level = np.where(np.isnan(level), own - differences[-1], level)
    sampling = data.sampling(conditions).reshape(shape)[counts]
    return Specimen(
        data.loads,
        data.velocities,
        level,
        np.array(differences),
        _mean_square(sampling),
        conditions.criterion.is_highest,
    )


def _mean_square(sampling: Array) -> Array:
    """Root of the mean square over patches, where any is known; else NaN."""
    known = np.isfinite(sampling)
    total = np.square(np.where(known, sampling, 0.0)).sum(axis=0)
    return np.sqrt(np.where(known.any(axis=0), total / np.maximum(known.sum(axis=0), 1), np.nan))


def _extended(difference: Array, loads: Array) -> Array:
    """Differences from the first patch at all places, from those that both have."""
    known = np.isfinite(difference)
    rows = np.asarray(known.any(axis=1))
    nearest = np.where(known, difference, _nearest_known(difference, known))
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


def _nearest_known(values: Array, is_known: Mask) -> Array:
    """For each element the nearest known value of its row, by index; NaN in an unknown row."""
    number = np.arange(values.shape[1])
    away = np.where(is_known[:, None, :], np.abs(number[:, None] - number), np.inf)
    found: Array = np.take_along_axis(values, away.argmin(axis=-1), axis=1)
    return found

"""A measured load over time (Bosman & de Rooij, Fig. 8)."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tribo.constants import EQUAL_TIME_LIMIT, FITTED_SHARES, LOAD_NOISE
from tribo.errors import InputError, real_array, require_number, require_positive
from tribo.loading.ramp import LoadStep
from tribo.types import Array

_MAX_COURSE_ROWS = 500  # rows that take about 20 kB in a store


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredLoad:
    """A record of the load, from its first row to where it first reaches its reference load.

    The loading is cut into as many steps as the scene has increments. If the load grows about
    evenly, all steps take the same time. Otherwise steps are shorter where the load changes fast:
    every step has the same sum of its share of the duration and its share of the load's travel.
    Travel is the total change of load, up and down, without noise below 2 % of the reference load.
    So a jump gets half of the steps, however short it is.

    A point at another load has the same times, with all loads scaled in proportion. Points
    therefore share no load steps, and each is simulated from the start of the record. The load may
    fall during the record. A negative load, which can only be noise, counts as 0.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing times of the readings [s].
    loads : ndarray, shape (n,)
        Load on the whole pin at these times [N].
    reference_load : float, optional
        Load at which the loading ends [N]; the record's maximum if not given. Give it for a record
        with a long, noisy plateau; otherwise the loading ends at the highest peak of the noise.

    Raises
    ------
    InputError
        If there are fewer than two rows, a number is not finite, the time does not increase, or
        the record does not rise to its reference load. The message names the row.

    Examples
    --------
    >>> record = MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 100.0]))
    >>> for load_step in record.load_steps(50.0, increments=4):
    ...     print(f"{load_step.normal_load:.1f} N at {load_step.time:.2f} s")
    17.7 N at 0.44 s
    35.4 N at 0.89 s
    44.3 N at 1.85 s
    50.0 N at 3.00 s
    """

    times: Array
    loads: Array
    reference_load: float | None = None
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        times = real_array("times of a load record", self.times)
        loads = real_array("loads of a load record", self.loads)
        if self.reference_load is not None:
            require_number(reference_load=self.reference_load)
        if times.ndim != 1 or times.shape != loads.shape or len(times) < 2:
            raise InputError(
                f"a load record has times of shape {times.shape} and loads of shape {loads.shape}; "
                "it must have two columns of equal length, and at least two rows"
            )
        if defect := find_fault(times, loads):
            row, reason = defect
            raise InputError(f"load record, row {row} (counted from 0): {reason}")
        content = np.array([times, loads]).tobytes() + repr(self.reference_load).encode()
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "loads", loads)
        object.__setattr__(self, "digest", hashlib.sha256(content).hexdigest())
        if not max(0.0, loads[0]) < self.peak <= loads.max():
            raise InputError(
                f"the load record begins at {loads[0]:g} N and reaches {loads.max():g} N; its "
                f"reference load, {self.peak:g} N, must be positive, above the first load, and at "
                "most the highest load"
            )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeasuredLoad) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    @property
    def peak(self) -> float:
        """Load at which the loading ends [N]: the reference load if given, else the highest."""
        return float(self.loads.max()) if self.reference_load is None else self.reference_load

    def time_at(self, share: float) -> float:
        """Time at which the record first reaches a share, from 0 to 1, of its peak [s]."""
        load = share * self.peak
        row = int(np.argmax(self.loads >= load))
        if row == 0:
            return float(self.times[0])
        (t0, t1), (F0, F1) = self.times[row - 1 : row + 1], self.loads[row - 1 : row + 1]
        return float(t0 + (load - F0) / (F1 - F0) * (t1 - t0))

    def load_steps(
        self, normal_load: float, increments: int, hold_increments: int = 0
    ) -> Iterator[LoadStep]:
        """Times at which the contact is solved, with their loads, up to `normal_load` [N].

        The loading is divided into `increments` steps; the times are the ends of these steps,
        counted from the record's first row. All loads of the record are scaled so that the last is
        `normal_load`. A record has no hold, so that `hold_increments` is not used.
        """
        require_positive(normal_load=normal_load)
        begin, scale = float(self.times[0]), normal_load / self.peak
        times = self._step_ends(increments)
        loads = scale * np.maximum(0.0, np.interp(begin + times, self.times, self.loads))
        loads[-1] = normal_load
        impulses = scale * self._impulses(begin + times)
        for index in range(increments):
            load, time, impulse = (float(values[index]) for values in (loads, times, impulses))
            yield LoadStep(load, time, on_trunk=False, index=index + 1, impulse=impulse)

    @property
    def course(self) -> tuple[tuple[float, float], ...]:
        """Pairs (time since the record's first row [s], load as a share of the peak).

        Each row until the loading ends has a pair. If there are more than 500 rows, each of 500
        steps has a pair instead: the middle of the step, and its mean load. The last pair is the
        end of the loading, with the share 1.

        Examples
        --------
        >>> MeasuredLoad(np.array([2.0, 3.0, 5.0]), np.array([0.0, 80.0, 100.0])).course
        ((0.0, 0.0), (1.0, 0.8), (3.0, 1.0))
        """
        return _course(self)

    def _step_ends(self, count: int) -> Array:
        """End times (count,) of the steps [s], from the first row to the peak."""
        begin, end = float(self.times[0]), self.time_at(1.0)
        shares = np.arange(1, count + 1) / count
        if (share_times := _step_times(self)) is None:
            return (end - begin) * shares
        times: Array = np.interp(shares, *share_times) - begin
        times[-1] = end - begin
        return times

    def _impulses(self, ends: Array) -> Array:
        """Impulses ∫F dt [N s] from the first row to `ends` [s]; a negative load counts as 0."""
        t, F = self.times, self.loads
        crossings = np.flatnonzero(F[:-1] * F[1:] < 0)  # rows after which F changes sign
        zero_times = t[crossings] - F[crossings] * (t[crossings + 1] - t[crossings]) / (
            F[crossings + 1] - F[crossings]
        )
        times = np.union1d(np.concatenate((t, zero_times)), ends)
        load = np.maximum(0.0, np.interp(times, t, F))
        cumulative = np.concatenate(([0.0], np.cumsum((load[1:] + load[:-1]) / 2 * np.diff(times))))
        return np.asarray(cumulative[np.searchsorted(times, ends)])

    def linear_fit(self) -> tuple[float, float]:
        """Rate [N/s] and onset [s] of the straight line through the rise, F = rate·(t − onset).

        The line fits, by least squares, the rows from 10 % to 90 % of the peak, like the dashed
        line in Fig. 8 of Bosman & de Rooij.

        Examples
        --------
        >>> t = np.linspace(0.0, 6.0, 13)
        >>> rate, onset = MeasuredLoad(t, np.clip(150.0 * (t - 0.5), 0.0, 750.0)).linear_fit()
        >>> f"{rate:.1f} N/s from {onset:.2f} s"
        '150.0 N/s from 0.50 s'
        """
        begin, end = (self.time_at(share) for share in FITTED_SHARES)
        inside = (self.times > begin) & (self.times < end)
        t = np.concatenate(([begin], self.times[inside], [end]))
        F = np.interp(t, self.times, self.loads)
        rate = float(np.sum((t - t.mean()) * (F - F.mean())) / np.sum((t - t.mean()) ** 2))
        return rate, float(t.mean() - F.mean() / rate)


@functools.lru_cache(maxsize=4)  # called for each scene of a sweep
def _course(record: MeasuredLoad) -> tuple[tuple[float, float], ...]:
    """Compute and cache `MeasuredLoad.course`: pairs of time [s] and share of the load."""
    begin, end = float(record.times[0]), record.time_at(1.0)
    rows = record.times < end
    times, loads = record.times[rows] - begin, np.maximum(0.0, record.loads[rows])
    if len(times) > _MAX_COURSE_ROWS:
        edges = np.append(0.0, record._step_ends(_MAX_COURSE_ROWS))
        times = (edges[1:] + edges[:-1]) / 2
        loads = np.diff(record._impulses(begin + edges)) / np.diff(edges)
    shares = (loads / record.peak).tolist()
    return (*zip(times.tolist(), shares, strict=True), (end - begin, 1.0))


@functools.lru_cache(maxsize=4)  # called for every point of a sweep
def _step_times(record: MeasuredLoad) -> tuple[Array, Array] | None:
    """Completed share of the steps at each reading, and its time [s]; None for equal steps."""
    begin, end = float(record.times[0]), record.time_at(1.0)
    rows = record.times < end
    times = np.append(record.times[rows], end)
    loads = np.maximum(0.0, np.append(record.loads[rows], record.peak))
    backlash = LOAD_NOISE * record.peak
    filtered, travel = loads[0], [0.0]
    for load in loads[1:].tolist():
        clamped = min(max(filtered, load - backlash), load + backlash)
        travel.append(travel[-1] + abs(clamped - filtered))
        filtered = clamped
    # Shares of the load's travel and of time. Noise within the dead band adds no travel.
    travel_share, time_share = np.array(travel) / travel[-1], (times - begin) / (end - begin)
    if np.abs(travel_share - time_share).max() < EQUAL_TIME_LIMIT:
        return None
    return (travel_share + time_share) / 2, times


def find_fault(times: Array, loads: Array) -> tuple[int, str] | None:
    """Find the first reading that is not finite, or not later than the one before it.

    Returns its index and the reason, or None. `times` are in s, `loads` in N.
    """
    nonfinite = np.flatnonzero(~(np.isfinite(times) & np.isfinite(loads)))
    first = int(nonfinite[0]) if nonfinite.size else len(times)
    not_increasing = np.flatnonzero(np.diff(times[:first]) <= 0)
    if not_increasing.size:
        row = int(not_increasing[0]) + 1
        return row, f"time {times[row]:g} s after {times[row - 1]:g} s; it must increase"
    if nonfinite.size:
        return first, f"{times[first]:g} s, {loads[first]:g} N; both must be finite"
    return None

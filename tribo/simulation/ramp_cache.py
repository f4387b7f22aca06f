"""States along ramps of the load, cached for the points that continue these ramps.

Points at several loads share the first steps of one ramp, its trunk; see `tribo.loading.ramp`. So a
point begins at the last cached step below its load, and the steps that it adds are cached for the
next point. The results of a point are bit for bit the same whatever steps are cached.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from tribo.loading import LoadStep
from tribo.simulation.state import State

MOST_BYTES = 2**28
"""Default limit of the total size of the states in a cache [B]."""


@dataclass(slots=True, eq=False)
class Recorder:
    """Records a value of the state at the end of each increment of a ramp, under a name."""

    name: Hashable
    record: Callable[[State], Any]
    course: tuple[Any, ...] = ()  # values along the ramp of the last point


class SharedStep(NamedTuple):
    """A step of a shared ramp."""

    end: State  # on the finest grid if its temperature is requested
    history: State  # from which the ramp continues, on the coarsest grid


@dataclass(slots=True, eq=False)
class PointMemo:
    """Results of the last point, for scenes that differ from its scene in thermal constants only.

    The cache fills none of them: `ends` and `shared_end` are of `contacts`, `results` of callers.
    """

    ends: list[State] | None = None  # requested states after the shared steps
    shared_end: State | None = None  # end of the shared steps, at all positions of the disk
    results: dict[Hashable, Any] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class _Trunk:
    """Steps of a shared ramp (trunk) so far, or only the last if their states need much memory."""

    steps: list[SharedStep] = field(default_factory=list)  # of the last increments
    count: int = 0  # increments so far
    nbytes: int = 0
    records: dict[Hashable, list[Any]] = field(default_factory=dict)  # by name, one per increment
    lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def dropped(self) -> int:
        """Number of increments whose states were dropped, counted from the first."""
        return self.count - len(self.steps)

    def clear_if_dropped(self, increments: int, recorded: int) -> None:
        """Forget all states and recorded values if a state that the caller needs was dropped.

        The caller needs the state after `increments` steps. If values are recorded for fewer steps,
        `recorded`, it needs the states after all later steps, too.
        """
        if increments and self.dropped >= min(increments, recorded + 1):
            self.steps, self.count, self.nbytes, self.records = [], 0, 0, {}

    def add(self, step: SharedStep, limit: int) -> None:
        """Keep the next step; drop older steps if their memory exceeds `limit` [B]."""
        self.nbytes += _size(step)
        self.steps.append(step)
        self.count += 1
        if self.nbytes > limit:
            self.steps = [step]
            self.nbytes = _size(step)


class RampCache:
    """A cache of the states along ramps of the load, by mechanics, velocity and increment.

    The total size of the states is at most `limit` [B]. The least recently used ramps are dropped
    first. If a single ramp is larger than the limit, only its last state is kept.

    Examples
    --------
    The ramp grows by 1.25 N a step. The second load continues from the cached state at 3.75 N:

    >>> import tribo
    >>> from dataclasses import replace
    >>> scene = replace(scene, wear=tribo.Wear(1e-15))
    >>> ramp, fine = tribo.Ramp(1.0, 10.0), replace(scene.fidelity, increments=8)
    >>> scene = replace(scene, loading=ramp, fidelity=fine)
    >>> ramp_cache = RampCache()
    >>> for load in (5.0, 9.0):
    ...     print(sum(1 for state in tribo.simulate(scene, load, 0.065, ramp_cache)))
    4
    5
    """

    def __init__(self, limit: int = MOST_BYTES) -> None:
        self._limit = limit
        self._trunks: OrderedDict[Hashable, _Trunk] = OrderedDict()
        self._lock = threading.Lock()
        self._last: tuple[Hashable, PointMemo] = None, PointMemo()

    def memo(self, key: Hashable) -> PointMemo:
        """Memo of the most recent point; a new one when `key` changes."""
        with self._lock:
            if self._last[0] != key:
                self._last = key, PointMemo()
            return self._last[1]

    def has_room_for(self, states: Sequence[State]) -> bool:
        """True if the size of `states` is at most the limit of all ramps together."""
        return _size(states) <= self._limit

    def reach(
        self,
        key: Hashable,
        begin: State,
        load_steps: Sequence[LoadStep],
        advance: Callable[[State, LoadStep], SharedStep],
        recorder: Recorder | None = None,
    ) -> Iterator[tuple[SharedStep, bool]]:
        """Continue a cached ramp up to the last of its `load_steps`; yield its steps.

        With each step it yields whether the step was computed now. The ramp starts from the state
        `begin`, and is cached by `key`. `load_steps` are the ends of its steps: times with their
        loads. `advance` computes a step from the history of the step before.
        """
        with self._lock:
            trunk = self._trunks.setdefault(key, _Trunk())
            self._trunks.move_to_end(key)
        with trunk.lock:  # wait for a ramp that another thread computes
            recorded = len(trunk.records.get(recorder.name, ())) if recorder else len(load_steps)
            trunk.clear_if_dropped(len(load_steps), recorded)
            records: list[Any] = trunk.records.setdefault(recorder.name, []) if recorder else []
            step = SharedStep(begin, begin)
            for index, load_step in enumerate(load_steps, 1):
                is_new = index > trunk.count
                if is_new:
                    step = advance(step.history, load_step)
                    trunk.add(step, self._limit)
                elif index > trunk.dropped:
                    step = trunk.steps[index - trunk.dropped - 1]
                if recorder and len(records) < index:
                    records.append(recorder.record(step.end))
                yield step, is_new
            if recorder:
                recorder.course = tuple(records[: len(load_steps)])
        self._drop_oldest()

    def _drop_oldest(self) -> None:
        with self._lock:
            size = sum(trunk.nbytes for trunk in self._trunks.values())
            while size > self._limit and len(self._trunks) > 1:
                size -= self._trunks.popitem(last=False)[1].nbytes


def _size(states: Iterable[State]) -> int:
    """Size of the arrays of states [B], without those that they share with a step before."""
    arrays = {
        id(array): array.nbytes
        for state in states
        for array in (state.pressure, state.wear_depth, state.displacement, *state.passing)
        if array is not None
    }
    return sum(arrays.values())

"""States along ramps of the load, cached for the points that continue these ramps.

Points at several loads share the first steps of one ramp, its trunk; see `tribo.loading.ramp`. So a
point begins at the last cached step below its load, and the steps that it adds are cached for the
next point. The results of a point are bit for bit the same whatever steps are cached.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from tribo.loading import LoadStep
from tribo.simulation.state import State
from tribo.types import Array

MOST_BYTES = 2**28
"""Default limit of the total size of the states in a cache [B]."""


class Recorder(NamedTuple):
    """Records a value of the state after each increment of a ramp, under a name."""

    name: Hashable
    record: Callable[[State], Any]


class Reached(NamedTuple):
    """A step of a shared ramp: its state, and what was recorded at all steps up to it."""

    state: State
    is_new: bool  # not cached before
    course: tuple[Any, ...] = ()  # empty without a recorder


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
    """States of a shared ramp (trunk) so far, or only the last state if they need much memory."""

    states: list[State] = field(default_factory=list)  # at the last increments
    count: int = 0  # increments so far
    nbytes: int = 0
    records: dict[Hashable, list[Any]] = field(default_factory=dict)  # by name, one per increment
    lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def dropped(self) -> int:
        """Number of increments whose states were dropped, counted from the first."""
        return self.count - len(self.states)

    def clear_if_dropped(self, increments: int, recorded: int) -> None:
        """Forget all states and recorded values if a state that the caller needs was dropped.

        The caller needs the state after `increments` steps. If values are recorded for fewer steps,
        `recorded`, it needs the states after all later steps, too.
        """
        if increments and self.dropped >= min(increments, recorded + 1):
            self.states, self.count, self.nbytes, self.records = [], 0, 0, {}

    def add(self, state: State, limit: int) -> None:
        """Keep the state after the next step; drop older states if memory exceeds `limit` [B]."""
        self.nbytes += sum(array.nbytes for array in _arrays(state))
        self.states.append(state)
        self.count += 1
        if self.nbytes > limit:
            self.states = [state]
            self.nbytes = sum(array.nbytes for array in _arrays(state))


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
        return sum(array.nbytes for state in states for array in _arrays(state)) <= self._limit

    def reach(
        self,
        key: Hashable,
        begin: State,
        load_steps: Sequence[LoadStep],
        advance: Callable[[State, LoadStep], State],
        recorder: Recorder | None = None,
    ) -> Iterator[Reached]:
        """Continue a cached ramp up to the last of its `load_steps`, and yield each of them.

        The ramp starts from the state `begin`, and is cached by `key`. `load_steps` are the ends of
        its steps: times with their loads. `advance` computes a state from the state one step
        earlier.
        """
        with self._lock:
            trunk = self._trunks.setdefault(key, _Trunk())
            self._trunks.move_to_end(key)
        with trunk.lock:  # wait for a ramp that another thread computes
            recorded = len(trunk.records.get(recorder.name, ())) if recorder else len(load_steps)
            trunk.clear_if_dropped(len(load_steps), recorded)
            records: list[Any] = trunk.records.setdefault(recorder.name, []) if recorder else []
            state = begin
            for index, load_step in enumerate(load_steps, 1):
                is_new = index > trunk.count
                if is_new:
                    state = advance(state, load_step)
                    trunk.add(state, self._limit)
                elif index > trunk.dropped:
                    state = trunk.states[index - trunk.dropped - 1]
                if recorder and len(records) < index:
                    records.append(recorder.record(state))
                yield Reached(state, is_new, tuple(records[:index]))
        self._drop_oldest()

    def _drop_oldest(self) -> None:
        with self._lock:
            size = sum(trunk.nbytes for trunk in self._trunks.values())
            while size > self._limit and len(self._trunks) > 1:
                size -= self._trunks.popitem(last=False)[1].nbytes


def _arrays(state: State) -> Iterator[Array]:
    """Arrays of a state, without the arrays that it shares with the state one step earlier."""
    yield from (state.pressure, state.wear_depth, *state.passing)
    if state.history is not None:
        yield from _arrays(state.history)
    if state.displacement is not None:
        yield state.displacement

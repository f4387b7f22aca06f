"""Which worker computes a task: if possible one that has cached the task's loading ramp."""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Callable, Hashable, Iterable
from typing import Any

from pipeline.sweep.plan import Task
from pipeline.sweep.sweep import Point


class TaskQueue:
    """Waiting tasks by loading ramp, and the ramps that each worker has cached.

    A worker gets the next load of a ramp that it has cached; else the lowest load of a ramp that no
    worker has begun, if possible on its last surface, or on one that no other worker has; else the
    next load of the ramp with most points left.
    """

    def __init__(self, tasks: Iterable[Task]) -> None:
        # Points of each ramp, the next one last.
        self._left: dict[tuple[Any, ...], list[Point]] = {}
        for task in tasks:
            self._left.setdefault(task.ramp, []).append(task.point)
        for ones in self._left.values():
            ones.reverse()
        # Ramps that nobody has begun, by their mechanics; mechanics begun last are at the end.
        self._fresh: dict[Any, deque[tuple[Any, ...]]] = {}
        for ramp in self._left:
            self._fresh.setdefault(ramp[0], deque()).append(ramp)
        self._has: defaultdict[Hashable, dict[tuple[Any, ...], None]] = defaultdict(dict)
        self._last: dict[Hashable, Any] = {}  # mechanics of each worker's last ramp

    def __len__(self) -> int:
        return sum(map(len, self._left.values()))

    def __bool__(self) -> bool:
        return bool(self._left)

    def take(self, worker: Hashable) -> Task:
        """Remove and return the next task for a worker; the queue must not be empty."""
        ramp = self._ramp(worker, has := self._has[worker])
        self._last[worker] = ramp[0]
        left = self._left[ramp]
        point = left.pop()
        if not left:
            del self._left[ramp]
        has.pop(ramp, None)
        has[ramp] = None  # moved to the end: its trunk is the last to be dropped
        return Task(point, ramp)

    def put_back(self, task: Task) -> None:
        """Put a task that was not computed back into the queue, as the next task of its ramp."""
        self._left.setdefault(task.ramp, []).append(task.point)

    def _ramp(self, worker: Hashable, has: dict[tuple[Any, ...], None]) -> tuple[Any, ...]:
        while has:
            if (ramp := next(reversed(has))) in self._left:
                return ramp
            has.popitem()
        if self._fresh:
            last = self._last.get(worker)
            mechanics = last if last in self._fresh else next(iter(self._fresh))
            ramps = self._fresh.pop(mechanics)
            ramp = ramps.popleft()
            if ramps:
                self._fresh[mechanics] = ramps
            return ramp
        return max(self._left, key=lambda ramp: len(self._left[ramp]))


def makespan(
    tasks: Iterable[Task], workers: int, cost: Callable[[Task, dict[Any, Any]], float]
) -> tuple[float, float]:
    """Predict the time in which workers compute tasks, and the sum of the task times [s].

    ``cost(task, kept)`` returns the time of a task [s]. `kept` is a dictionary of the worker that
    computes the task, in which the function may note what this worker has cached.
    """
    waiting = TaskQueue(tasks)
    has: defaultdict[int, dict[Any, Any]] = defaultdict(dict)
    free, wall, total = [(0.0, worker) for worker in range(workers)], 0.0, 0.0
    while waiting:
        now, worker = heapq.heappop(free)
        seconds = cost(waiting.take(worker), has[worker])
        wall, total = max(wall, now + seconds), total + seconds
        heapq.heappush(free, (now + seconds, worker))
    return wall, total

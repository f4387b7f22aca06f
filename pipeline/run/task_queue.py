"""Which worker computes a task: if possible the one that has cached its loading ramp."""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Callable, Hashable, Iterable
from typing import Any

from pipeline.sweep.plan import Task


class TaskQueue:
    """Waiting tasks by loading ramp, and the ramp that each worker had last.

    A worker gets the next load of the ramp that it had last; else the lowest load of a ramp that
    nobody has begun; else the next load of the ramp with most points left.
    """

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._left: dict[tuple[Any, ...], deque[Task]] = {}
        for task in tasks:
            self._left.setdefault(task.ramp, deque()).append(task)
        self._fresh = dict.fromkeys(self._left)
        self._last: dict[Hashable, tuple[Any, ...]] = {}

    def __len__(self) -> int:
        return sum(map(len, self._left.values()))

    def __bool__(self) -> bool:
        return bool(self._left)

    def take(self, worker: Hashable) -> Task:
        """Remove and return the next task for a worker; the queue must not be empty."""
        ramp = self._last.get(worker)
        if ramp is None or ramp not in self._left:
            ramp = next(iter(self._fresh), None)
            ramp = ramp or max(self._left, key=lambda one: len(self._left[one]))
        self._fresh.pop(ramp, None)
        self._last[worker] = ramp
        task = self._left[ramp].popleft()
        if not self._left[ramp]:
            del self._left[ramp]
        return task

    def put_back(self, task: Task) -> None:
        """Put a task that was not computed back into the queue, as the next task of its ramp."""
        self._left.setdefault(task.ramp, deque()).appendleft(task)


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

"""Which worker computes a task: if possible the one that has cached its loading ramp."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable
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

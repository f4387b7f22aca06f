"""A Dask client without a cluster, which does its tasks here and at once."""

from collections import deque
from concurrent.futures import Future

from distributed.scheduler import KilledWorker

from pipeline.run.work import compute_points


class LocalClient:
    """The part of a client that a sweep needs, with a number of workers of one thread each.

    `is_deadly` tells if a worker dies of computing a point, `is_hit` if one is killed from outside
    before it begins with the task of a number. `tasks` has the arguments of each function that was
    submitted, `pinned` the worker to which it was pinned.
    """

    def __init__(self, workers=1, is_deadly=lambda _: False, is_hit=lambda _: False):
        self._workers, self._is_deadly, self._is_hit = workers, is_deadly, is_hit
        self.tasks, self.pinned = [], []

    @property
    def scheduler(self):
        return self

    def sync(self, function, *_, **__):
        return function()

    def run(self):
        return {}

    def nthreads(self, **_):
        return {f"here {number}": 1 for number in range(self._workers)}

    def processing(self):
        return dict.fromkeys(self.nthreads(), ())

    def submit(self, function, *arguments, workers=None, **_):
        ended = Ended()
        ended.key = f"{function.__name__}-{len(self.tasks)}"
        arguments = tuple(
            tuple(argument) if isinstance(argument, deque) else argument for argument in arguments
        )
        if function is compute_points:
            self.tasks.append(arguments)
            self.pinned.append(workers)
        try:
            values = [
                argument.result() if isinstance(argument, Future) else argument
                for argument in arguments
            ]
            if function is compute_points:
                self._kill(values, ended.key)
            ended.set_result(function(*values))
            ended.status = "finished"
        except Exception as error:
            ended.set_exception(error)
            ended.status = "error"
        return ended

    def _kill(self, values, key):
        """Raise as Dask does if the worker dies of the task, and with it all that it has done."""
        _, points, _, seconds = values
        begun = points if seconds else points[:1]
        if self._is_hit(len(self.tasks) - 1) or any(map(self._is_deadly, begun)):
            raise KilledWorker(key, None, 0)


class Ended(Future):
    """A task that has ended, with what Dask's futures have besides."""

    key = ""
    status = "pending"

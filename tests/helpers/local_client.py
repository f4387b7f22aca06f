"""A Dask client without a cluster, which does its tasks here and at once."""

from concurrent.futures import Future
from types import SimpleNamespace

from distributed.scheduler import KilledWorker

from pipeline.run import work


class LocalClient:
    """The part of a client that a sweep needs, with a number of workers of one thread each.

    `is_deadly` tells if a worker dies of computing a point, `is_hit` if one is killed from outside
    before it begins with the task of a number. `tasks` has the points of each task that was
    submitted, `pinned` the worker to which it was pinned.
    """

    def __init__(self, workers=1, is_deadly=lambda _: False, is_hit=lambda _: False):
        self._workers, self._is_deadly, self._is_hit = workers, is_deadly, is_hit
        self.tasks, self.pinned, self.results = [], [], {}
        self.cancelled = []

    def sync(self, function, *arguments, callback_timeout=None, **options):
        return function(*arguments, **options)

    def run(self, function, *arguments, workers, **_):
        if function is not work.records_here:
            return {}
        there = SimpleNamespace(data=self.results)
        return {
            worker: self.answer(worker, work.records_here(*arguments, there)) for worker in workers
        }

    def answer(self, worker, report):
        """What a worker answers, of which tests make something else."""
        return report

    def nthreads(self, **_):
        return {f"here {number}": 1 for number in range(self._workers)}

    def submit(self, function, *arguments, key, workers=None, **_):
        ended = Ended()
        ended.key = key
        _, _, points, *_ = arguments
        self.tasks.append(points)
        self.pinned.append(workers)
        try:
            values = [
                argument.result() if isinstance(argument, Future) else argument
                for argument in arguments
            ]
            if self._is_hit(len(self.tasks) - 1) or any(map(self._is_deadly, points)):
                raise KilledWorker(key, None, 0)
            self.results[key] = function(*values)
            ended.status = "finished"
            ended.set_result(self.results[key])
        except Exception as error:
            ended.status = "error"
            ended.set_exception(error)
        return ended

    def cancel(self, futures):
        self.cancelled += futures


class Ended(Future):
    """A task that has ended, with what Dask's futures have besides."""

    key = ""
    status = "pending"

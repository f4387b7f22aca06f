"""A Dask client without a cluster: what it is given is done here and at once."""

from concurrent.futures import Future


class Here:
    """What a sweep needs of a client, with one thread.

    Attributes
    ----------
    tasks : list of tuple
        The arguments of each function that was submitted.
    """

    def __init__(self):
        self.tasks = []

    def nthreads(self):
        return {"here": 1}

    def wait_for_workers(self, *_, **__):
        pass

    def submit(self, function, *arguments, **_):
        self.tasks.append(arguments)
        ended = _Ended()
        ended.key = id(ended)
        values = (each.result() if isinstance(each, Future) else each for each in arguments)
        try:
            ended.set_result(function(*values))
            ended.status = "finished"
        except Exception as error:
            ended.set_exception(error)
            ended.status = "error"
        return ended


class _Ended(Future):
    pass

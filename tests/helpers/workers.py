"""Workers that stay from one sweep to the next, which a suite of short sweeps starts once.

A plugin of pytest, so that it reaches the examples of the packages, too.
"""

from contextlib import ExitStack

import pytest


class Workers:
    """Clusters of this machine, one for each number of workers."""

    def __init__(self):
        self._stack, self._clients = ExitStack(), {}

    def connected(self, client, workers, *options):
        """As `pipeline.run.cluster.connected`, which would start a cluster for each sweep."""
        from pipeline.run.cluster import connected

        return connected(client or self._client(workers), workers, *options)

    def _client(self, workers):
        import dask
        from distributed import Client

        from pipeline.run.cluster import CONFIGURATION, processes

        if workers not in self._clients:
            self._stack.enter_context(dask.config.set(CONFIGURATION))
            cluster = self._stack.enter_context(processes(workers))
            client = Client(cluster, set_as_default=False)
            self._clients[workers] = self._stack.enter_context(client)
        return self._clients[workers]

    def end(self):
        self._clients.clear()
        self._stack.close()


@pytest.fixture(scope="session")
def _workers():
    workers = Workers()
    yield workers
    workers.end()


@pytest.fixture(scope="module", autouse=True)
def _sweeps_share_workers(request, _workers):
    """Not in a file that says ``OWN_WORKERS = True``, whose tests count them or kill some."""
    with pytest.MonkeyPatch.context() as patched:
        if getattr(getattr(request.node, "obj", None), "OWN_WORKERS", False):
            _workers.end()
        elif "tribo" not in request.path.parts:  # which has no sweeps
            patched.setattr("pipeline.run.sweep.connected", _workers.connected)
        yield

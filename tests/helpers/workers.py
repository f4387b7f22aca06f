"""Workers that stay from one sweep to the next, which a suite of short sweeps starts once.

A plugin of pytest, so that it reaches the examples of the packages, too.
"""

from contextlib import ExitStack

import pytest


class Workers:
    """Local Dask clusters that tests share, one for each number of workers."""

    def __init__(self):
        self._stack, self._clients = ExitStack(), {}

    def connected(self, client, workers, *options):
        """Replacement of `pipeline.run.cluster.connected` that reuses a cluster."""
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
    """Share clusters between sweeps, except in modules with ``OWN_WORKERS = True``."""
    with pytest.MonkeyPatch.context() as patched:
        if getattr(getattr(request.node, "obj", None), "OWN_WORKERS", False):
            _workers.end()
        elif "tribo" not in request.path.parts:  # tests of tribo have no sweeps
            patched.setattr("pipeline.run.run_sweep.connected", _workers.connected)
        yield

"""Workers that stay from one sweep to the next, which a suite of short sweeps starts once."""

from contextlib import ExitStack

import dask
from distributed import Client

from pipeline.run.cluster import CONFIGURATION, connected, processes


class Workers:
    """Clusters of this machine, one for each number of workers."""

    def __init__(self):
        self._stack, self._clients = ExitStack(), {}

    def connected(self, client, workers, *options):
        """As `pipeline.run.cluster.connected`, which would start a cluster for each sweep."""
        return connected(client or self._client(workers), workers, *options)

    def _client(self, workers):
        if workers not in self._clients:
            self._stack.enter_context(dask.config.set(CONFIGURATION))
            cluster = self._stack.enter_context(processes(workers))
            client = Client(cluster, set_as_default=False)
            self._clients[workers] = self._stack.enter_context(client)
        return self._clients[workers]

    def end(self):
        self._clients.clear()
        self._stack.close()

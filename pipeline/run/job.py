"""A worker in a job of a batch system: Dask's, with the settings of this package.

A job script runs it as ``python -m pipeline.run.job ADDRESS …``, with options as ``dask worker``.
"""

import logging
import os

from pipeline.run.source import CONFIGURATION

# At the normal end of a job, these would show tracebacks of connections that are closed. Its worker
# processes import this module, too.
os.environ["DASK_LOGGING"] = repr(
    {"distributed": "info", "distributed.batched": "error", "distributed.comm.tcp": "error"}
)
logging.getLogger("distributed.worker").addFilter(
    lambda record: "ConnectionPool is closed" not in record.getMessage()
)

if __name__ == "__main__":
    import dask
    from distributed.cli.dask_worker import main

    dask.config.set(CONFIGURATION)
    main()

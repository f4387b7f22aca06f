"""A worker in a job of a batch system: Dask's, with the settings of this package.

A job script runs it as ``python -m pipeline.run.job ADDRESS …``, with options as ``dask worker``.
"""

import os

from pipeline.run.source import CONFIGURATION

# At the normal end of a job, these two would show tracebacks of connections that are closed.
os.environ["DASK_LOGGING"] = repr(
    {"distributed": "info", "distributed.batched": "error", "distributed.comm.tcp": "error"}
)

if __name__ == "__main__":
    import dask
    from distributed.cli.dask_worker import main

    dask.config.set(CONFIGURATION)
    main()

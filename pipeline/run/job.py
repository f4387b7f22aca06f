"""A worker in a job of a batch system: Dask's, with the settings of this package.

A job script runs it as ``python -m pipeline.run.job ADDRESS …``, with options as ``dask worker``.
"""

import os

from pipeline.run.source import CONFIGURATION

_LOGGING = {
    "version": 1,
    "disable_existing_loggers": False,
    "filters": {"farewell": {"()": "pipeline.run.source.Farewell"}},
    "formatters": {"dask": {"format": "%(asctime)s - %(name)s - %(levelname)s - %(message)s"}},
    "handlers": {
        "stderr": {
            "class": "logging.StreamHandler",
            "filters": ["farewell"],
            "formatter": "dask",
        }
    },
    "root": {"level": "WARNING", "handlers": ["stderr"]},
    "loggers": {
        "distributed": {"level": "INFO"},
        # These two log connections that are closed.
        "distributed.batched": {"level": "ERROR"},
        "distributed.comm.tcp": {"level": "ERROR"},
    },
}

if __name__ == "__main__":
    os.environ["DASK_LOGGING"] = repr(_LOGGING)  # also for the worker that the nanny starts
    import dask
    from distributed.cli.dask_worker import main

    dask.config.set(CONFIGURATION)
    main()

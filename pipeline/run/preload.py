"""Imports of every worker, made by the process from which workers are forked.

An error in Dask's files is left to the driver, which imports the same and reports it.
"""

from contextlib import suppress

with suppress(ValueError):
    import distributed  # noqa: F401
    import scipy.fft
    import scipy.special  # noqa: F401

    import pipeline.run.work  # noqa: F401

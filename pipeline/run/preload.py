"""Imports of every worker, by the process that workers are forked from.

The driver imports the same, and names what is wrong in Dask's files.
"""

from contextlib import suppress

with suppress(ValueError):
    import distributed  # noqa: F401
    import scipy.fft
    import scipy.special  # noqa: F401

    import pipeline.run.work  # noqa: F401

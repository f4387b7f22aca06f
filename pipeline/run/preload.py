"""Imports of every worker, made by the process from which workers are forked.

An error in Dask's files is left to the driver, which imports the same and reports it.
"""

import gc
from contextlib import suppress

gc.disable()  # modules stay, and looking through them for garbage takes 0.1 s
with suppress(ValueError):
    import distributed  # noqa: F401
    import scipy.fft
    import scipy.special  # noqa: F401

    import pipeline.run.work  # noqa: F401
gc.freeze()
gc.enable()

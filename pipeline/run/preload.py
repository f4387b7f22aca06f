"""Imports of every worker, by the process that workers are forked from.

The driver imports the same, and names what is wrong in Dask's files.
"""

from contextlib import suppress
from importlib import import_module

# SciPy would load the former two at their first use, in each worker.
_MODULES = ("scipy.fft", "scipy.special", "distributed", "pipeline.run.work")

with suppress(ValueError):
    for _name in _MODULES:
        import_module(_name)

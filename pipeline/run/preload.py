"""What the forkserver imports for all workers, and then leaves alone.

Once frozen, none of it is searched for garbage: the memory stays shared between the processes, and
the end of a process does not take 0.2 s.
"""

import gc
import importlib
import os

from pipeline.run.forkserver import PRELOADING

# SciPy would load the former two when they are first used, in each worker.
MODULES = ("scipy.fft", "scipy.special", "distributed", "pipeline.run.work")


def preload() -> None:
    """Import all of it, and freeze it."""
    gc.disable()  # there is no garbage yet
    for name in MODULES:
        importlib.import_module(name)
    gc.freeze()
    gc.enable()


if PRELOADING in os.environ:  # whoever else imports this is not to be frozen
    preload()

"""What the forkserver imports for all workers, and then leaves alone.

Frozen, none of it is looked through for garbage: its memory stays shared between the processes,
and its end does not take 0.2 s.
"""

import gc
import importlib
import os

from pipeline.run.forkserver import PRELOADING

# SciPy would load the former two when they are first used, in each worker.
MODULES = ("scipy.fft", "scipy.special", "pipeline.run.schedule")


def preload() -> None:
    """Import and freeze."""
    gc.disable()  # there is no garbage yet
    for name in MODULES:
        importlib.import_module(name)
    gc.freeze()
    gc.enable()


if PRELOADING in os.environ:  # whoever else imports this is not to be frozen
    preload()

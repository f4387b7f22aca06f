"""What the forkserver imports for all workers, and then leaves alone.

Frozen, none of it is looked through for garbage: its memory stays shared between the processes,
and its end does not take 0.2 s.
"""

import gc
import importlib

gc.disable()  # there is no garbage yet
# SciPy would load the former two when they are first used, in each worker.
for name in ("scipy.fft", "scipy.special", "pipeline.run.schedule"):
    importlib.import_module(name)
gc.freeze()
gc.enable()

"""The process from which workers are forked: it imports their packages once for all of them.

The boundary of first_try at `standard` takes 2.4 s with it, 4.4 s with Dask's method `spawn`.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver, resource_tracker
from pathlib import Path

WORKER_ENVIRONMENT = {
    # Dask's own thresholds return the memory of each FFT to the kernel, which takes longer than
    # the FFT. These settings replace all of Dask's, so the threads are stated again.
    "MALLOC_TRIM_THRESHOLD_": "268435456",
    "MALLOC_MMAP_THRESHOLD_": "67108864",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
"""Environment of the workers, also of those that are started elsewhere."""


def start() -> None:
    """Start the process from which workers are forked, unless it already runs."""
    main = vars(sys.modules["__main__"])
    if not Path(main.get("__file__", "")).is_file():
        main.pop("__file__", None)  # "<stdin>" of python -, which workers would try to import
    multiprocessing.set_forkserver_preload(["pipeline.run.preload"])
    before = dict(os.environ)
    # The fork server imports from the folders of this process, not from the current folder.
    os.environ.update(WORKER_ENVIRONMENT, PYTHONSAFEPATH="1", PYTHONPATH=os.pathsep.join(sys.path))
    try:
        with block_interrupts():
            forkserver.ensure_running()
    finally:
        os.environ.clear()
        os.environ.update(before)


@contextmanager
def block_interrupts() -> Iterator[None]:
    """Context manager: delay a Ctrl-C to the end of the block.

    A terminal sends Ctrl-C to every process in the foreground. Threads and processes begun in the
    block never receive it, so that it stops only the driver.
    """
    # Before Python 3.13, starting the tracker unblocks SIGINT: start it before SIGINT is blocked.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_if_imported() -> None:
    """Exit silently if this process is a worker that imports, and so runs, the driver's script."""
    # A worker imports the driver's script under this name, and afterwards knows its parent process.
    script = sys.modules.get("__mp_main__")
    if script and script.__name__ == "__mp_main__" and not multiprocessing.parent_process():
        os._exit(1)  # an exception would show a traceback for each worker

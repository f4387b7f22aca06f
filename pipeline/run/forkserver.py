"""The process that workers are forked from: it imports once what all of them need.

It is started ahead of the cluster, so that it imports while this process does so, too.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import forkserver, resource_tracker
from typing import Any

from pipeline.run.leftovers import remove_dead_folders

METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
"""Start method of `multiprocessing` for the workers."""

WORKER_ENVIRONMENT = {
    # Dask's own thresholds return each FFT's memory to the kernel, which takes longer than the
    # FFT. What is set in Dask's configuration replaces all of it, so the threads are stated again.
    "MALLOC_TRIM_THRESHOLD_": "268435456",
    "MALLOC_MMAP_THRESHOLD_": "67108864",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
"""Environment of the workers, also of those that are started elsewhere."""


PRELOADING = "IRG_PRELOADING"
"""Variable that only the forkserver, and so all that it starts, has in its environment."""

UNGUARDED = 'in a script, call run_sweep under if __name__ == "__main__":, since workers import it'
_UNGUARDED = 71  # exit code of a worker that was about to run a sweep
_IMPORT = 60.0  # [s] that a script may take until it is about to


def start() -> None:
    """Start the process, unless it runs; then let it go on if it was stopped."""
    if METHOD != "forkserver":
        return
    # It imports from where this process does, and not from the folder where a user works.
    path = os.pathsep.join(folder or os.curdir for folder in sys.path)
    settings = {"PYTHONSAFEPATH": "1", "PYTHONPATH": path, PRELOADING: "1", **WORKER_ENVIRONMENT}
    before = {name: os.environ.get(name) for name in settings}
    multiprocessing.set_forkserver_preload(["pipeline.run.preload"])
    try:
        os.environ.update(settings)
        with interrupts_put_off():
            forkserver.ensure_running()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
    remove_dead_folders()  # while that imports
    wake()


def wake() -> None:
    """Let the process go on if it was stopped, since whoever waits for workers waits for it.

    It is not asked first whether it is stopped: it says so only some time after it was told to.
    """
    import psutil  # which takes 0.03 s, while the process imports

    for child in psutil.Process().children():
        with suppress(psutil.NoSuchProcess):
            if any("multiprocessing.forkserver" in word for word in child.cmdline()):
                child.resume()


def end_if_imported() -> None:
    """End this process, without a word, if it is a worker that imports the script of its driver."""
    script = sys.modules.get("__mp_main__")  # under this name, and before the worker has a parent
    if script and script.__name__ == "__mp_main__" and not multiprocessing.parent_process():
        os._exit(_UNGUARDED)  # an exception would show a traceback for each worker


def script_starts_sweeps() -> bool:
    """Whether the script of this process starts a sweep when a worker imports it."""
    context: Any = multiprocessing.get_context(METHOD)
    process = context.Process(target=_nothing)
    process.start()
    process.join(_IMPORT)
    process.kill()  # or Python would wait for it in the end
    return bool(process.exitcode == _UNGUARDED)


def _nothing() -> None:
    pass


@contextmanager
def interrupts_put_off() -> Iterator[None]:
    """Put off Ctrl-C until the end of the block.

    Threads that begin in here, and the processes that these start, inherit that SIGINT is
    blocked. So a Ctrl-C in a terminal, which goes to every process of the foreground, stops the
    driver alone, and not a worker that may be just starting.
    """
    waiting: list[int] = []
    in_main_thread = threading.current_thread() is threading.main_thread()
    resource_tracker.ensure_running()  # unblocks SIGINT where it is started, before Python 3.13
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    if in_main_thread:
        handler = signal.signal(signal.SIGINT, lambda number, _: waiting.append(number))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if in_main_thread:
            signal.signal(signal.SIGINT, handler)
        if waiting:
            signal.raise_signal(signal.SIGINT)

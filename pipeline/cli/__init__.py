"""The command ``irg``.

Results go to stdout, as text or with ``--json`` as one document; progress and messages to stderr.
Exit codes: 0 done, 1 some points failed, 2 wrong use or scene, 3 the store belongs to another
scene, 130 interrupted.
"""

from __future__ import annotations

import argparse
import atexit
import gc
import io
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from contextlib import chdir, suppress
from pathlib import Path
from traceback import walk_tb
from typing import Any

import pipeline
from pipeline import interrupts
from pipeline.cli.parser import function_of, parse
from pipeline.run import forkserver
from pipeline.sweep.remarks import remarks

_SETTINGS = {
    "matplotlib": "the variable MPLBACKEND (irg needs no backend)",
    "dask.config": "a setting of Dask (~/.config/dask, DASK_CONFIG or DASK_…)",
    "dask.utils": "a setting of Dask (~/.config/dask, DASK_CONFIG or DASK_…)",
}
"""Settings of others that a user may have wrong, by the module whose error says so."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    # One thread of BLAS, as workers have: a point alone has the bits of the same point in a sweep.
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    atexit.register(gc.freeze)  # saves 0.3 s of searching imported modules for garbage at the end
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # rather than to fail in ASCII
    if Path("matplotlibrc").exists():  # which may name programs to run, and others may have written
        with chdir(Path(__file__).parent):
            import matplotlib  # noqa: F401
    try:
        options = parse(arguments)
        return carried_out(options, _begun)
    except KeyboardInterrupt:  # before a command began
        return 130


def _begun(options: argparse.Namespace) -> Any:
    """Run a command, whose module is imported only now, and return its result."""
    if options.command == "sweeps:run" and not (options.scheduler or options.scheduler_file):
        forkserver.start()  # imports for the workers what is imported here meanwhile
    function = function_of(options)
    with interrupts.raised():
        return function(options)


def carried_out(options: argparse.Namespace, function: Callable[[argparse.Namespace], Any]) -> int:
    """Exit code of a command, after a line on the error that may have ended it."""
    # Here, since they import NumPy, which --help needs not and cannot do with little memory.
    from pipeline.cli import output
    from pipeline.store.place import is_lack_of_memory
    from tribo import TriboError
    from tribo.errors import shortened

    if options.quiet:
        output.QUIET.set()
    # Of what is computed, no other command keeps anything before its end.
    safe = "; finished points are safe" if getattr(options, "command", "") == "sweeps:run" else ""
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: output.tell(*remarks("note", str(message)))
            result = function(options)
            output.show(options, result)
            if sys.stdout is not None:
                sys.stdout.flush()  # here, where it can be said that it fails
            return int(result.code)
    except KeyboardInterrupt:
        with suppress(OSError):  # the terminal may be closed
            output.complain(f"interrupted{safe}{safe and ': run the same command again to go on'}")
        return output.INTERRUPTED
    except TriboError as error:
        output.complain(str(error))
        is_of_other = isinstance(error, pipeline.StoreMismatchError)
        return output.OTHER_SCENE if is_of_other else output.WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return output.DONE
    except (MemoryError, OSError, RuntimeError, ImportError) as error:
        if not is_lack_of_memory(error):
            # Zarr says so of a damaged chunk of a copy.
            if not isinstance(error, OSError) and "decompress" not in str(error):
                raise
            output.complain(f"cannot go on: {error}{safe}")
            with suppress(OSError, ValueError, AttributeError):
                # Python is not to try again, at its end, to print what could not be printed.
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return output.WRONG_USE
        output.complain(
            "out of memory, or of the threads and processes that this user may start (ulimit -a)"
            f"{safe}: take fewer workers or a coarser grid"
        )
        return output.WRONG_USE
    except (ValueError, KeyError, TypeError) as error:
        *_, (frame, _) = walk_tb(error.__traceback__)
        if (setting := _SETTINGS.get(frame.f_globals["__name__"])) is None:
            raise
        reason = shortened(" ".join(str(error.args[0] if error.args else error).split()))
        output.complain(f"{setting} is wrong: {reason}{safe}")
        return output.WRONG_USE
    finally:
        output.QUIET.clear()

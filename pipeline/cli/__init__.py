"""The command ``irg``.

Results go to stdout, as text or with ``--json`` as one document; progress and messages to stderr.
Exit codes: 0 done, 1 some points failed, 2 wrong use or scene, 3 the store belongs to another
scene, 130 interrupted.
"""

from __future__ import annotations

import argparse
import functools
import io
import os
import pkgutil
import sys
import warnings
from collections.abc import Callable, Sequence
from contextlib import chdir, suppress
from pathlib import Path
from typing import Any

import pipeline
from pipeline import interrupts
from pipeline.cli.parser import parse


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that `arguments` name, by default `sys.argv`; return its exit code."""
    # One BLAS thread, as in workers: a single point is then bit for bit as in a sweep.
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    os.environ["MPLBACKEND"] = "agg"  # figures are files; Matplotlib fails on an unknown backend
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # so that an ASCII terminal does not fail
    if Path("matplotlibrc").exists():  # untrusted: it may name programs to run
        with chdir(Path(__file__).parent):
            import matplotlib  # noqa: F401
    try:
        options = parse(arguments)
        return exit_code_of(options, _run_command)
    except KeyboardInterrupt:  # before a command began
        return 130


def _run_command(options: argparse.Namespace) -> Any:
    """Import the command's module, run the command and return its result."""
    function = pkgutil.resolve_name(options.function)
    with interrupts.keyboard_interrupts():
        return function(options)


def exit_code_of(options: argparse.Namespace, function: Callable[[argparse.Namespace], Any]) -> int:
    """Run the `function` of a command, print its result or its error, and return the exit code."""
    # Imported here, as they import NumPy, which --help does not need.
    from pipeline.cli import output
    from pipeline.store.location import is_lack_of_memory
    from tribo import TriboError

    if options.quiet:
        output.QUIET.set()
    saved, interrupted = "", "interrupted"
    if options.command == "run":  # only this command stores results before its end
        saved = "; finished points are saved"
        interrupted = f"interrupted{saved}: run the same command again to continue"
    try:
        with warnings.catch_warnings():
            note = functools.cache(lambda text: output.print_note(f"note: {text}"))  # once each
            warnings.showwarning = lambda message, *_: note(str(message))
            result = function(options)
            output.print_result(options, result)
            if sys.stdout is not None:
                sys.stdout.flush()  # here, so that a failure is reported
            return int(result.code)
    except KeyboardInterrupt:
        with suppress(OSError):  # the terminal may be closed
            output.print_error(interrupted)
        return output.INTERRUPTED
    except TriboError as error:
        output.print_error(str(error))
        is_other_scene = isinstance(error, pipeline.StoreMismatchError)
        return output.OTHER_SCENE if is_other_scene else output.WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return output.DONE
    except (MemoryError, OSError, RuntimeError, ImportError) as error:
        if is_lack_of_memory(error):
            output.print_error(
                "out of memory, or at the limit of threads and processes for this user (ulimit -a)"
                f"{saved}: use fewer workers or a coarser grid"
            )
            return output.WRONG_USE
        # Zarr raises a RuntimeError for a damaged chunk.
        if not isinstance(error, OSError) and "decompress" not in str(error):
            raise
        output.print_error(f"cannot continue: {error}{saved}")
        with suppress(OSError, ValueError, AttributeError):
            # Python would flush stdout at exit, which would fail a second time.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return output.WRONG_USE
    finally:
        output.QUIET.clear()

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
from collections.abc import Callable, Iterator, Sequence
from contextlib import chdir, contextmanager, suppress
from pathlib import Path
from traceback import walk_tb
from typing import Any

import pipeline
from pipeline import interrupts
from pipeline.cli.parser import function_of, parse
from pipeline.words import remarks

_SETTINGS = {
    "matplotlib": "the variable MPLBACKEND (irg needs no backend)",
    "dask.config": "a setting of Dask (~/.config/dask, DASK_CONFIG or DASK_…)",
    "dask.utils": "a setting of Dask (~/.config/dask, DASK_CONFIG or DASK_…)",
}
"""Settings of other programs that may be wrong, by the module that raises the error."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that `arguments` name, by default `sys.argv`; return its exit code."""
    # One BLAS thread, as in workers: a single point is then bit for bit as in a sweep.
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    atexit.register(gc.freeze)  # saves 0.3 s of garbage collection at exit
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # so that an ASCII terminal does not fail
    if Path("matplotlibrc").exists():  # untrusted: it may name programs to run
        with chdir(Path(__file__).parent):
            import matplotlib  # noqa: F401
    try:
        options = parse(arguments)
        options.owns_process = arguments is None
        return exit_code_of(options, _run_command)
    except KeyboardInterrupt:  # before a command began
        return 130


def _run_command(options: argparse.Namespace) -> Any:
    """Import the command's module, run the command and return its result."""
    function = _load(options)
    with interrupts.keyboard_interrupts():
        return function(options)


def _load(options: argparse.Namespace) -> Callable[[argparse.Namespace], Any]:
    """Import the command's module, and return the function of the command."""
    gc.disable()  # modules stay, and looking through them for garbage takes 0.1 s
    try:
        # When it is loaded, and with its first variable, xarray looks for libraries of arrays and
        # imports those that it finds, dask.array and pint: 0.3 s. A command has none of their
        # arrays. Extras may load Dask itself.
        if "." in options.command or "xarray" in sys.modules:
            return function_of(options)
        with _hidden("dask", "pint"):
            function = function_of(options)
            if xarray := sys.modules.get("xarray"):
                xarray.Variable((), 0.0).to_numpy()
            return function
    finally:
        gc.freeze()
        gc.enable()


@contextmanager
def _hidden(*names: str) -> Iterator[None]:
    """Context manager: modules that cannot be imported, unless they are loaded."""
    hidden = {*names} - sys.modules.keys()
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


def _has_folder() -> bool:
    """True if the working folder exists."""
    try:
        return Path.cwd().is_dir()
    except OSError:
        return False


def exit_code_of(options: argparse.Namespace, function: Callable[[argparse.Namespace], Any]) -> int:
    """Run the `function` of a command, print its result or its error, and return the exit code."""
    # Imported here, as they import NumPy, which --help does not need.
    from pipeline.cli import output
    from pipeline.store.place import is_lack_of_memory
    from tribo import TriboError
    from tribo.errors import shortened

    if options.quiet:
        output.QUIET.set()
    # Only irg run keeps results before its end.
    safe = "; finished points are saved" if getattr(options, "command", "") == "sweeps:run" else ""
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: output.print_note(
                *remarks("note", str(message))
            )
            result = function(options)
            output.show(options, result)
            if sys.stdout is not None:
                sys.stdout.flush()  # here, so that a failure is reported
            return int(result.code)
    except KeyboardInterrupt:
        with suppress(OSError):  # the terminal may be closed
            output.print_error(
                f"interrupted{safe}{safe and ': run the same command again to continue'}"
            )
        return output.INTERRUPTED
    except TriboError as error:
        output.print_error(str(error))
        is_of_other = isinstance(error, pipeline.StoreMismatchError)
        return output.OTHER_SCENE if is_of_other else output.WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return output.DONE
    except (MemoryError, OSError, RuntimeError, ImportError) as error:
        if not is_lack_of_memory(error):
            # Zarr raises a RuntimeError for a damaged chunk.
            if not isinstance(error, OSError) and "decompress" not in str(error):
                raise
            reason = (
                error
                if _has_folder()
                else "the working directory was deleted; change to another one"
            )
            output.print_error(f"cannot continue: {reason}{safe}")
            with suppress(OSError, ValueError, AttributeError):
                # Keep Python from flushing stdout again at exit.
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return output.WRONG_USE
        output.print_error(
            "out of memory, or at the limit of threads and processes for this user (ulimit -a)"
            f"{safe}: use fewer workers or a coarser grid"
        )
        return output.WRONG_USE
    except (ValueError, KeyError, TypeError) as error:
        *_, (frame, _) = walk_tb(error.__traceback__)
        if (setting := _SETTINGS.get(frame.f_globals["__name__"])) is None:
            raise
        reason = shortened(" ".join(str(error.args[0] if error.args else error).split()))
        output.print_error(f"{setting} is wrong: {reason}{safe}")
        return output.WRONG_USE
    finally:
        output.QUIET.clear()

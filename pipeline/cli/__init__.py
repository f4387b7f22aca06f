"""The command ``irg``.

Results go to stdout, as text or with ``--json`` as one document; progress and messages to stderr.
Exit codes: 0 done, 1 some points failed, 2 wrong use or scene, 3 the store belongs to another
scene, 130 interrupted.
"""

from __future__ import annotations

import atexit
import gc
import io
import sys
import warnings
from collections.abc import Sequence

import pipeline
from pipeline.cli.output import DONE, INTERRUPTED, OTHER_SCENE, WRONG_USE, tell
from pipeline.cli.parser import function_of, parse
from tribo import TriboError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    # Imported modules stay: looking for garbage among them takes 0.1 s now and 0.2 s at the end.
    gc.set_threshold(100_000)
    atexit.register(gc.freeze)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # rather than to fail in ASCII
    options = parse(arguments)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: tell(f"note: {message}")
            return int(function_of(options)(options))
    except KeyboardInterrupt:
        tell("interrupted; finished points are safe: run the same command again to go on")
        return INTERRUPTED
    except pipeline.StoreMismatchError as error:
        tell(str(error))
        return OTHER_SCENE
    except TriboError as error:
        tell(str(error))
        return WRONG_USE
    except MemoryError:
        tell("out of memory; finished points are safe: take fewer workers or a coarser grid")
        return WRONG_USE
    except BrokenPipeError:
        sys.stderr.close()
        return DONE

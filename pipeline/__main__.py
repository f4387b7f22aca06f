"""``python -m pipeline``: the process of ``irg``, which signals end without a traceback."""

from __future__ import annotations

import os
import sys
from typing import Any

from pipeline import interrupts


def run() -> None:
    """Run the command line of this process, and exit with its code."""
    sys.unraisablehook = _report
    _open_streams()
    interrupts.handle(lambda number, frame: _end_process(130, "irg: interrupted\n"))
    from pipeline.cli import main  # takes 0.3 s

    code = main()
    interrupts.handle(lambda number, frame: _end_process(code))
    if code == 130:  # an exit would wait for threads that wait for a disk
        _end_process(code)
    sys.exit(code)


def _open_streams() -> None:
    """Open closed standard streams on the null device, or the next file would get their number."""
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def _end_process(code: int, line: str = "") -> None:
    """Print a line on stderr, and end the process at once with exit code `code`."""
    os.write(2, line.encode())
    os._exit(code)


def _report(dropped: Any) -> None:
    if issubclass(dropped.exc_type, KeyboardInterrupt):  # as during the import of a module
        interrupts.resend_interrupt()
    else:
        sys.__unraisablehook__(dropped)


if __name__ == "__main__":
    run()

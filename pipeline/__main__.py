"""``python -m pipeline``: the process of ``irg``, which signals end without a traceback."""

from __future__ import annotations

import os
import sys
from typing import Any

from pipeline import interrupts


def run() -> None:
    """Run the command line of this process, and exit with its code."""
    sys.unraisablehook = _report
    interrupts.handle(lambda number, frame: _end_process(130, "irg: interrupted\n"))
    from pipeline.cli import main  # takes 0.3 s

    code = main()
    interrupts.handle(lambda number, frame: _end_process(code))
    sys.exit(code)


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

"""``python -m pipeline``: the process of ``irg``, which signals end without a traceback."""

from __future__ import annotations

import os
import sys

from pipeline import interrupts


def run() -> None:
    """Run the command line of this process, and exit with its code."""
    interrupts.handle(lambda number, frame: _end_process(130, "irg: interrupted\n"))
    from pipeline.cli import main  # takes 0.3 s

    code = main()
    interrupts.handle(lambda number, frame: _end_process(code))
    if code == 130:  # an exit would wait for threads that wait for a disk
        _end_process(code)
    sys.exit(code)


def _end_process(code: int, line: str = "") -> None:
    """Print a line on stderr, and end the process at once with exit code `code`."""
    os.write(2, line.encode())
    os._exit(code)


if __name__ == "__main__":
    run()

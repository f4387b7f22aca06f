"""The command ``irg``, whose name alone is loaded before an interrupt can end it in a line."""

import sys


def run() -> None:
    """Run the command of this process, and exit."""
    try:
        from pipeline.__main__ import run as begin
    except KeyboardInterrupt:
        print("irg: interrupted", file=sys.stderr)
        sys.exit(130)
    begin()

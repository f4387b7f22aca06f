"""``python -m workflows.paper NAME``, for `irg paper NAME`."""

import sys

from pipeline.cli import main

if __name__ == "__main__":
    sys.exit(main(["paper", *sys.argv[1:]]))

"""``python -m workflows.paper NAME``, the same as ``irg reproduce NAME``."""

import sys

from pipeline.cli import main

sys.exit(main(["reproduce", *sys.argv[1:]]))

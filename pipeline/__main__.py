"""``python -m pipeline``: the command ``irg``."""

import sys

from pipeline.cli import main

sys.exit(main())

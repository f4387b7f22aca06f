"""The command that computes a sweep, begun before all that it needs is imported."""

from __future__ import annotations

import argparse

from pipeline.run import forkserver


def run(options: argparse.Namespace) -> object:
    """Run or resume a sweep, or the part of it that the boundary needs."""
    if options.scheduler is None and options.scheduler_file is None:
        forkserver.start()  # imports for the workers what is imported here meanwhile
    from pipeline.cli.sweeps import computed

    return computed(options)

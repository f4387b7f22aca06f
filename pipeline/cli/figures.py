"""The command ``irg plot``."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result


def plot(options: argparse.Namespace) -> Result:
    """Answer ``irg plot``: draw a figure of a store, and print its path."""
    look = given.values_in(options, *given.PLACE, "log", "show", "width", "plain")
    ds = given.dataset_in(options)
    out = options.output or given.path_beside(options.store, f"_{options.kind}.png")
    written = str(pipeline.plot(ds, options.kind, out, **look))
    return Result({"kind": options.kind, "file": written}, [written], pipeline.warned(ds))

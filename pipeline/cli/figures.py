"""The command that draws a figure of a store."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result


def plot(options: argparse.Namespace) -> Result:
    """Draw a figure of a store."""
    look = given.values_in(options, *given.PLACE, "log", "show", "width", "plain")
    ds = given.dataset_in(options)
    out = options.output or given.path_beside(options.store, f"_{options.kind}.png")
    written = str(pipeline.plot(ds, options.kind, out, **look))
    return Result({"kind": options.kind, "file": written}, [written], pipeline.warned(ds))

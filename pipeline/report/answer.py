"""The report of the command."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, working


def report(options: argparse.Namespace) -> Result:
    """Write a report of a store."""
    ds = given.dataset_in(options)
    out = options.output or given.beside(options.store, "_report.html")
    with working("writing the report"):
        written = pipeline.report(ds, out, given.table_in(options))
    warned = pipeline.warned(ds)
    return Result({"file": str(written)}, [str(written)], warned)

"""The commands ``irg plot`` and ``irg report``."""

from __future__ import annotations

import argparse
import shlex
import sys

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, working


def plot(options: argparse.Namespace) -> Result:
    """Answer ``irg plot``: draw a figure of a store, and print its path."""
    names = "log", "show", "step", "width", "plain", "title", "dpi"
    look = given.values_in(options, *given.PLACE, *names)
    ds = given.dataset_in(options)
    out = options.output or given.path_beside(options.store, f"_{options.kind or 'diagram'}.png")
    written = str(pipeline.plot(ds, options.kind, out, **look, **given.conditions_in(options)))
    return Result(
        {"kind": options.kind, "file": written}, [written], pipeline.points_with_warnings(ds)
    )


def report(options: argparse.Namespace) -> Result:
    """Answer ``irg report``: write a page on a store, and print its path."""
    asked = given.values_in(options, "load", "velocity", "title", "author")
    if options.points is not None:
        asked["points"] = given.operating_points_in(options)
    ds = given.dataset_in(options)
    out = options.output or given.path_beside(options.store, ".html")
    command = shlex.join(["irg", *sys.argv[1:]])
    with working("writing the report"):
        conditions = given.conditions_in(options)
        written = str(pipeline.report(ds, out=out, command=command, **asked, **conditions))
    return Result({"file": written}, [written], pipeline.points_with_warnings(ds))

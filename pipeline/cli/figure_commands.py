"""The commands ``irg plot``, ``irg report`` and ``irg surface``."""

from __future__ import annotations

import argparse
import shlex
import sys
from functools import partial

import pipeline
from pipeline.cli import inputs
from pipeline.cli.output import Result, working, wrapped
from tribo import InputError

_SHIPPED_PIXEL = 0.95e-6  # side of a pixel of the shipped scenes [m]


def plot(options: argparse.Namespace) -> Result:
    """Answer ``irg plot``: draw a figure of a store, and print its path."""
    names = "load", "velocity", "realization", "log", "step", "width", "plain", "title", "dpi"
    figure_options = inputs.values_in(options, *names)
    ds = inputs.dataset_in(options)
    out = options.output or inputs.path_beside(options.store, f"_{options.kind or 'diagram'}.png")
    path = str(
        pipeline.plot(ds, options.kind, out, **figure_options, **inputs.conditions_in(options))
    )
    document = {"kind": options.kind, "file": path}
    return Result(document, [path], pipeline.points_with_warnings(ds))


def report(options: argparse.Namespace) -> Result:
    """Answer ``irg report``: write a page on a store, and print its path."""
    report_options = inputs.values_in(options, "load", "velocity", "title", "author")
    report_options["points"] = inputs.operating_points_in(options)
    ds, conditions = inputs.dataset_in(options), inputs.conditions_in(options)
    out = options.output or inputs.path_beside(options.store, ".html")
    command = shlex.join(["irg", *sys.argv[1:]])
    with working("writing the report"):
        path = str(pipeline.report(ds, out=out, command=command, **report_options, **conditions))
    return Result({"file": path}, [path], pipeline.points_with_warnings(ds))


def surface(options: argparse.Namespace) -> Result:
    """Answer ``irg surface``: roughness of a scan, or Ra and RSm, and the table of a scene."""
    if (options.ra is None) != (options.rsm is None) or (options.ra is None) == (not options.scan):
        raise InputError("give a SCAN, or --ra RA and --rsm RSM of a profile, each with its unit")
    if options.scan is None:
        return _data_sheet(options)
    with working("fitting a random surface"):
        statistics = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.missing
        )
    tables = statistics.tables.splitlines()  # TOML is not wrapped
    text = [*wrapped(statistics.lines()), "", *tables]
    return Result(statistics.as_dict(), text, draw=partial(pipeline.plot, statistics))


def _data_sheet(options: argparse.Namespace) -> Result:
    from pipeline.surface.data_sheet import data_sheet_toml

    if options.output:
        raise InputError("a figure needs a SCAN; leave -o out")
    pixel = min(options.pixel_size) if options.pixel_size else _SHIPPED_PIXEL
    with working("seeking the correlation length"):
        toml, assumptions = data_sheet_toml(options.ra, options.rsm, pixel)
    document = {"ra": options.ra, "rsm": options.rsm, "assumed": assumptions, "random_tables": toml}
    return Result(document, [*assumptions, "", *toml.splitlines()])

"""The command ``irg surface``."""

from __future__ import annotations

import argparse
from functools import partial

import pipeline
from pipeline.cli.output import Result, working, wrapped
from pipeline.surface.data_sheet import data_sheet_toml
from tribo import InputError

_USUAL_PIXEL = 0.95e-6  # [m], of the shipped scenes


def surface(options: argparse.Namespace) -> Result:
    """Answer ``irg surface``: roughness of a scan, or Ra and RSm, and the table of a scene."""
    if (options.ra is None) != (options.rsm is None) or (options.ra is None) == (not options.scan):
        raise InputError("give a SCAN, or --ra RA and --rsm RSM of a profile, each with its unit")
    if options.scan is None:
        return _of_profile(options)
    with working("fitting a random surface"):
        found = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.missing
        )
    text = [*wrapped(found.lines()), "", *found.tables.splitlines()]  # TOML is not wrapped
    return Result(found.as_dict(), text, draw=partial(pipeline.plot, found))


def _of_profile(options: argparse.Namespace) -> Result:
    if options.output:
        raise InputError("a figure needs a SCAN; leave -o out")
    pixel = min(options.pixel_size) if options.pixel_size else _USUAL_PIXEL
    with working("seeking the correlation length"):
        toml, assumed = data_sheet_toml(options.ra, options.rsm, pixel)
    document = {"ra": options.ra, "rsm": options.rsm, "assumed": assumed, "random_tables": toml}
    return Result(document, [*assumed, "", *toml.splitlines()])

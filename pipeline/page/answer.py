"""The command ``irg explore``."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, working
from pipeline.page.content import MOST_FIELDS


def explore(options: argparse.Namespace) -> Result:
    """Answer ``irg explore``: write a page of a store for a browser."""
    ds = given.dataset_in(options)
    out = options.output or given.path_beside(options.store, ".html")
    fields, points = 0 if options.no_fields else MOST_FIELDS, given.operating_points_in(options)
    with working("writing the page"):
        page = pipeline.explore(ds, out, fields, points)
    return Result(page.as_dict(), [str(page)], pipeline.warned(ds))

"""The commands on several stores: their differences, and a list of them."""

from __future__ import annotations

import argparse
from math import isfinite

import pipeline
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import show, table_path

_MOST_POINTS = 10  # that are printed; files have all


def diff(options: argparse.Namespace) -> int:
    """Print the differences between two stores."""
    out = table_path(options)
    found = pipeline.diff(options.store, options.other)
    text = [f"A {options.store}", f"B {options.other}", ""]
    if found.entries.rows:
        text += [*found.entries.lines(), ""]
    else:
        text += ["their scenes are equal", ""]
    if found.boundary.rows:
        text += [*found.boundary.without_empty().lines(), ""]
    else:
        text += [
            "no boundaries to compare: no common load, no critical temperature, or samples",
            "",
        ]
    differing = len(found.points.rows)
    changes = [abs(change) for change in found.points.as_dict()["change"] if isfinite(change)]
    unlike = f" (by up to {100 * max(changes):.2g} % of the rise)" if changes else ""
    text.append(
        f"points: {found.alike} alike, {len(changes)} unlike{unlike}, "
        f"{differing - len(changes)} done in one alone"
    )
    if differing:
        most = pipeline.Table(found.points.columns, found.points.rows[:_MOST_POINTS])
        text += most.without_empty().lines()
    if differing > _MOST_POINTS:
        text.append(f"and {differing - _MOST_POINTS} more, which -o TABLE.csv writes")
    if differing:
        text.append("rise: the highest of the contact at the end of the point, at friction 1")
    tables = [found.entries, found.boundary, found.points]
    show(options, found.as_dict(), text, out=out, tables=tables)
    return DONE


def listing(options: argparse.Namespace) -> int:
    """List the stores and scenes below a folder."""
    out = table_path(options)
    table = pipeline.listing(options.folder)
    text = list(table.without({"points", "done", "failed"}).lines())
    if not table.rows:
        text = [f"{options.folder} holds no stores and no scenes"]
    show(options, table.as_dict(), text, out=out, tables=[table])
    return DONE

"""The commands that measure the tool itself: its speed, its errors, and the paper beside it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import is_table
from pipeline.cli.output import DONE, show, table_path, tell, written
from pipeline.cli.scenes import given, scene_of

if TYPE_CHECKING:
    from pipeline.tradeoff.table import Trade


def trade(options: argparse.Namespace) -> int:
    """Measure speed against accuracy on a scene."""
    wants_table = is_table(options.output)
    table = table_path(options) if wants_table else None
    out = pipeline.figure_path(options.output) if options.output and not wants_table else None
    found = pipeline.trade(
        scene_of(options), base=options.base, diagram=options.diagram, progress=tell
    )
    document, text = found.as_dict(), [str(found)]
    if out:
        pipeline.save_figure(pipeline.draw_trade(found), out)
        document["figure"] = str(out)
        text.append(f"figure: {out}")
    text += written(table, _choices(found), document)
    show(options, document, text)
    return DONE


def _choices(found: Trade) -> Iterator[dict[str, Any]]:
    """Rows of a table, one for each choice."""
    for choice in found.choices:
        yield {
            "choice": choice.name,
            "error of the boundary velocity": choice.velocity_error,
            "error of the rise": choice.rise_error,
            "error of the contact width": choice.width_error,
            "times less work": choice.saving,
            "processor time [s]": choice.seconds,
            "memory [MB]": choice.peak_bytes and choice.peak_bytes / 1e6,
        }


def reproduce(options: argparse.Namespace) -> int:
    """Recompute a figure or table of the paper, all of them, or list them."""
    if options.list or options.name is None:
        results = pipeline.RESULTS
        show(options, results, [f"{name:12} {what}" for name, what in results.items()])
        return DONE
    chosen = given(options, "preset", "surfaces", "workers")
    if options.name == "all":
        reports = pipeline.write_gallery(options.output or Path("results"), progress=tell, **chosen)
        text = [line for report in reports for line in (*report.lines(), "")]
        show(options, {report.name: report.as_dict() for report in reports}, text)
        return DONE
    report = pipeline.reproduce(options.name, options.output, progress=tell, **chosen)
    show(options, report.as_dict(), report.lines())
    return DONE

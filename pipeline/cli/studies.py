"""The commands that measure the tool itself: its speed, its errors, and the paper beside it."""

from __future__ import annotations

import argparse
from pathlib import Path

import pipeline
from pipeline.cli.output import DONE, show, tell
from pipeline.cli.scenes import given, scene_of


def trade(options: argparse.Namespace) -> int:
    """Measure speed against accuracy on a scene."""
    out = pipeline.figure_path(options.output) if options.output else None
    found = pipeline.trade(
        scene_of(options), base=options.base, diagram=options.diagram, progress=tell
    )
    document, text = found.as_dict(), [str(found)]
    if out:
        pipeline.save_figure(pipeline.draw_trade(found), out)
        document["figure"] = str(out)
        text.append(f"figure: {out}")
    show(options, document, text)
    return DONE


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

"""The commands that measure the tool itself: its speed, its errors, and the paper beside it."""

from __future__ import annotations

import argparse
import importlib
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import Column, Table
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import output_path, show, tell
from pipeline.cli.scenes import given, scene_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.tradeoff.table import Trade


def trade(options: argparse.Namespace) -> int:
    """Measure speed against accuracy on a scene."""
    out = output_path(options)
    measured = pipeline.trade(
        scene_of(options), base=options.base, diagram=options.diagram, progress=tell
    )
    draw, tables = partial(pipeline.draw_trade, measured), [_choices(measured)]
    show(options, measured.as_dict(), [str(measured)], out=out, tables=tables, draw=draw)
    return DONE


def _choices(measured: Trade) -> Table:
    """Table with a row for each choice."""
    columns = (
        Column("name", "choice"),
        Column("velocity_error", "error of the boundary velocity"),
        Column("rise_error", "error of the rise"),
        Column("width_error", "error of the contact width"),
        Column("saving", "times less work"),
        Column("seconds", "processor time", "s"),
        Column("peak_bytes", "memory", "MB"),
    )
    rows = (
        tuple(getattr(choice, column.name) for column in columns) for choice in measured.choices
    )
    return Table(columns, tuple(rows))


def _study_of_the_paper() -> Any:
    """The package of the source that recomputes the paper, which no installed one depends on."""
    try:
        return importlib.import_module("workflows.paper")
    except ModuleNotFoundError as error:
        if error.name not in ("workflows", "workflows.paper"):
            raise
        raise InputError(
            "the figures and tables of the paper are recomputed by workflows/paper of the source, "
            "which is not installed with the command; run irg reproduce in a checkout"
        ) from error


def reproduce(options: argparse.Namespace) -> int:
    """Recompute a figure or table of the paper, all of them, or list them."""
    paper = _study_of_the_paper()
    if options.list or options.name is None:
        results, others = paper.RESULTS, paper.NOT_REPRODUCED
        text = [f"{name:12} {summary}" for name, summary in results.items()]
        text += ["", "not recomputed", *(f"{name:12} {reason}" for name, reason in others.items())]
        show(options, results | {"not_recomputed": others}, text)
        return DONE
    chosen = given(options, "preset", "surfaces", "workers")
    if options.name == "all":
        reports = paper.write_gallery(options.output or Path("results"), tell=tell, **chosen)
        text = [line for report in reports for line in (*report.lines(), "")]
        show(options, {report.name: report.as_dict() for report in reports}, text)
        return DONE
    report = paper.reproduce(options.name, options.output, tell=tell, **chosen)
    show(options, report.as_dict(), report.lines())
    return DONE

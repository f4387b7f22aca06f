"""Answer of the command of the paper."""

from __future__ import annotations

import argparse
from pathlib import Path

from pipeline.cli.inputs import values_in
from pipeline.cli.output import Result, print_note

from .. import paper
from .recomputed import WORDS


def recompute(options: argparse.Namespace) -> Result:
    """Answer ``irg paper``: compute a figure or table of the paper, all of them, or list them."""
    if options.list or options.name is None:
        results, not_recomputed = paper.RESULTS, paper.NOT_REPRODUCED
        numbers = {name: WORDS[name]["paper"] for name in results}
        text = [f"{numbers[name]:9} {name:9} {summary}" for name, summary in results.items()]
        text += [
            "",
            "not recomputed",
            *(f"{name:9} {reason}" for name, reason in not_recomputed.items()),
        ]
        return Result(results | {"not_recomputed": not_recomputed}, text)
    chosen = values_in(options, "preset", "surfaces", "workers")
    if options.name == "all":
        reports = paper.write_gallery(
            options.output or Path("results"), progress=print_note, **chosen
        )
        text = [line for report in reports for line in (*report.lines(), "")]
        return Result({report.name: report.as_dict() for report in reports}, text)
    report = paper.reproduce(options.name, options.output, progress=print_note, **chosen)
    return Result(report.as_dict(), report.lines())

"""``python -m workflows.paper NAME``: a figure or table of the paper, beside what it prints."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pipeline.cli import carried_out
from pipeline.cli import options as o
from pipeline.cli.given import values_in
from pipeline.cli.output import Result, tell
from workflows import paper

_OPTIONS = (
    *o.OF_ALL,
    o.Option("name", metavar="NAME", nargs="?", help="one of --list, or all"),
    o.LIST.but(help="list the figures and tables"),
    o.output("FILE.png", "figure to draw; for all, the folder of their common page"),
    o.PRESET.but(help="preset of the numerical choices, or as-published"),
    o.Option("--surfaces", metavar="N", type=int, help="number of random surfaces"),
    o.WORKERS.but(help="workers for the diagram"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Recompute a result as the arguments say; return the exit code."""
    parser = argparse.ArgumentParser(
        "python -m workflows.paper", description="Recompute a figure or table of the paper."
    )
    for option in _OPTIONS:
        parser.add_argument(*option.names, **option.settings)
    return carried_out(parser.parse_args(arguments), _recomputed)


def _recomputed(options: argparse.Namespace) -> Result:
    """A figure or table of the paper, all of them, or a list."""
    if options.list or options.name is None:
        results, others = paper.RESULTS, paper.NOT_REPRODUCED
        text = [f"{name:12} {summary}" for name, summary in results.items()]
        text += ["", "not recomputed", *(f"{name:12} {reason}" for name, reason in others.items())]
        return Result(results | {"not_recomputed": others}, text)
    chosen = values_in(options, "preset", "surfaces", "workers")
    if options.name == "all":
        reports = paper.write_gallery(options.output or Path("results"), progress=tell, **chosen)
        text = [line for report in reports for line in (*report.lines(), "")]
        return Result({report.name: report.as_dict() for report in reports}, text)
    report = paper.reproduce(options.name, options.output, progress=tell, **chosen)
    return Result(report.as_dict(), report.lines())


if __name__ == "__main__":
    sys.exit(main())

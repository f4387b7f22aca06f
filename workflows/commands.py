"""The command of the paper, and its options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli.options import Command, Option

COMMANDS = (
    Command(
        "paper", f"{__package__}.paper.answer:recompute",
        "recompute a figure or table of the paper, beside what it prints",
        "table4 --surfaces 2",
        (
            Option("name", metavar="NAME", nargs="?", help="one of --list, or all"),
            o.LIST.but(help="list the figures and tables"),
            o.output("PATH", "figure to draw, or the folder for it; all results need a folder"),
            o.PRESET.but(help="preset of the numerical choices, or as-published"),
            o.value("--surfaces N", "number of random surfaces", o.values.count),
            o.WORKERS.but(help="workers for the diagram"),
        ),
    ),
)  # fmt: skip

"""The command of the paper, and its options."""

from __future__ import annotations

from pipeline.cli import values
from pipeline.cli.command_table import Command, flag, with_value
from pipeline.paths import user_path

PAPER = Command(
    "paper",
    f"{__package__}.paper.answer:recompute",
    "recompute a figure or table of the paper, and compare it with the print",
    "table4 --surfaces 2",
    [
        with_value("name NAME", "one of --list, or all", nargs="?"),
        flag("--list", "list the figures and tables"),
        with_value(
            "-o --output PATH",
            "figure to draw, or the folder for it; all results need a folder",
            user_path,
        ),
        with_value("--preset NAME", "preset of the numerical choices"),
        with_value("--surfaces N", "number of random surfaces", values.count),
        with_value("-j --workers N", "workers for the diagram", values.count),
    ],
)

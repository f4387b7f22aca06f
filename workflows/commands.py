"""The command of the paper, and its options."""

from __future__ import annotations

from pipeline.cli import values
from pipeline.cli.command_table import Command, flag, value
from pipeline.paths import user_path

# fmt: off
PAPER = Command("paper", f"{__package__}.paper.answer:recompute",
    "recompute a figure or table of the paper, and compare it with the print",
    "table4 --surfaces 2", [
    value("name NAME", None, "one of --list, or all", nargs="?"),
    flag("--list", "list the figures and tables"),
    value("-o --output PATH", user_path,
        "figure to draw, or the folder for it; all results need a folder"),
    value("--preset NAME", None, "preset of the numerical choices"),
    value("--surfaces N", values.count, "number of random surfaces"),
    value("-j --workers N", values.count, "workers for the diagram"),
])
# fmt: on

"""The command of the paper, and its options."""

from __future__ import annotations

from typing import Any

from pipeline.cli import values
from pipeline.cli.parser import add_command
from pipeline.paths import user_path


def add_paper(commands: Any) -> None:
    """Add the command ``irg paper`` to the `commands` of the parser."""
    paper = add_command(
        commands, "paper", f"{__package__}.paper.answer:recompute",
        "recompute a figure or table of the paper, and compare it with the print",
        "table4 --surfaces 2",
    )  # fmt: skip
    paper.add_argument("name", metavar="NAME", nargs="?", help="one of --list, or all")
    paper.add_argument("--list", action="store_true", help="list the figures and tables")
    paper.add_argument(
        "-o", "--output", metavar="PATH", type=user_path,
        help="figure to draw, or the folder for it; all results need a folder",
    )  # fmt: skip
    paper.add_argument("--preset", metavar="NAME", help="preset of the numerical choices")
    paper.add_argument(
        "--surfaces", metavar="N", type=values.count, help="number of random surfaces"
    )
    paper.add_argument(
        "-j", "--workers", metavar="N", type=values.count, help="workers for the diagram"
    )

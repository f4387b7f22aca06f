"""The command ``irg explore`` and its options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli.options import Command, Option

COMMANDS = (
    Command(
        "explore", "pipeline.page.answer:explore",
        "write a page to explore a store in a browser, which prints it as a report",
        "results/scene.zarr --points duty.csv -o page.html",
        (
            o.STORE, o.output("PAGE.html", "file of the page; default: beside the store"),
            Option("--no-fields", action="store_true", help="leave all fields out"),
            *o.POINTS, *o.JUDGED,
        ),
    ),
)  # fmt: skip

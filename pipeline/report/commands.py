"""The command of the extra, and its options."""

from __future__ import annotations

from pipeline.cli import options as o
from pipeline.cli.options import Command

COMMANDS = (
    Command(
        "report", "pipeline.report.answer:report",
        "write a report for people without the tool, as HTML that a browser prints",
        "results/scene.zarr --points duty.csv -o report.html",
        (
            o.STORE, o.output("REPORT.html", "file to write; default: beside the store"),
            *o.POINTS, o.AT, *o.WEIGHED, o.CONDITIONS_AT_FRICTIONS,
        ),
    ),
)  # fmt: skip

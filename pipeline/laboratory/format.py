"""The form of a test of a scene that names a log."""

from __future__ import annotations

from pipeline.scene.compounds import ByPath, Entry, Optional, Table
from pipeline.scene.kinds import OneOf, Scalar, Text
from pipeline.sweep.about import OUTCOMES

# fmt: off
LOG = Table({
    "file": Entry(Text(),
        "Log with a row for each test, CSV or Excel, with columns such as `load [N]`; relative to "
        "the folder of the scene. `irg tests LOG` prints these lines."),
    "columns": Optional(ByPath(Text(), "entries of a test"),
        "Heading of the column of an entry, if it is not recognized.",
        example={"load": "Kraft / N"}),
    "words": Optional(ByPath(OneOf(OUTCOMES), "words of the log"),
        "Outcome that a word of the log means.", example={"Fresser": "severe"}),
    "where": Optional(ByPath(Scalar(), "headings of the log"),
        "Rows to take: those with this value in a column, such as the name of one oil.",
        example={"oil": "FVA 3"}),
    "skip": Optional(ByPath(Scalar(), "headings of the log, or entries"),
        "Rows to leave out: those with this value in a column, such as an aborted run.",
        example={"outcome": "aborted"}),
    "given": Optional(ByPath(Scalar(), "quantities"),
        "Quantities that the log does not say, the same in each row.",
        example={"track_radius": "20 mm"}),
    "form": Optional(Text(),
        "Export of a machine, if it is not recognized; `irg tests --help` lists them.",
        example="rtec"),
    "sheet": Optional(Text(),
        "Sheet of a workbook; by default the first with columns of a test."),
    "decimal": Optional(OneOf((".", ",")),
        "Decimal mark; by default as its numbers show."),
}, form="log")
# fmt: on

ENTRIES: dict[str, Entry] = {}
FORMS = {"measured": LOG, "tested": LOG}
"""By the list of tests."""

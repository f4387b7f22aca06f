"""Scene entry for tests that are read from a log file."""

from __future__ import annotations

from typing import Annotated as A
from typing import Any

from pipeline.scene.declare import ByPath, Declared, Example
from pipeline.scene.kinds import OneOf, Scalar, Text
from pipeline.sweep.measurement import OUTCOMES
from pipeline.sweep.tables import Entries


# fmt: off
class LogTable(Declared):
    file: A[str,
        "Log with a row for each test, CSV or Excel, with columns such as `load [N]`; relative to "
        "the folder of the scene. `irg tests LOG` prints these lines."]
    columns: A[dict[str, str] | None, ByPath(Text(), "entries of a test"),
        "Heading of the column of an entry, if it is not recognized.",
        Example({"load": "Kraft / N"})] = None
    words: A[dict[str, str] | None, ByPath(OneOf(OUTCOMES), "words of the log"),
        'Outcome that a word of the log means; "" is that of an empty cell.',
        Example({"Fresser": "severe"})] = None
    where: A[dict[str, Any] | None, ByPath(Scalar(), "headings of the log"),
        "Rows to take: those with this value in a column, such as the name of one oil.",
        Example({"oil": "FVA 3"})] = None
    skip: A[dict[str, Any] | None, ByPath(Scalar(), "headings of the log, or entries"),
        "Rows to leave out: those with this value in a column, such as an aborted run.",
        Example({"outcome": "aborted"})] = None
    given: A[dict[str, Any] | None, ByPath(Scalar(), "quantities"),
        "Quantities that the log does not say, the same in each row.",
        Example({"track_radius": "20 mm"})] = None
    form: A[str | None,
        "Export of a machine, if it is not recognized; `irg tests --help` lists them.",
        Example("rtec")] = None
    sheet: A[str | None,
        "Sheet of a workbook; by default the first with columns of a test."] = None
    decimal: A[str | None, OneOf((".", ",")),
        "Decimal mark; by default as its numbers show."] = None
# fmt: on

FORMS = (LogTable,)
"""Forms that an entry of a scene's list of tests may take, besides a single test."""


def find(entries: Entries) -> list[str]:
    """Paths of the entries ``measured`` and ``tested`` if their lists of tests name a log file."""
    lists = ((path, entries.get(path)) for path in ("measured", "tested"))
    listed = ((path, tests) for path, tests in lists if isinstance(tests, list))
    return [
        path
        for path, tests in listed
        if any(isinstance(test, dict) and "file" in test for test in tests)
    ]

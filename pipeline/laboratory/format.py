"""Scene entry for tests that are read from a log file."""

from __future__ import annotations

from typing import Annotated as A

from pipeline.scene.choices import TableFile
from pipeline.scene.declare import ByPath, Declared
from pipeline.scene.kinds import OneOf
from pipeline.sweep.measurement import OUTCOMES
from pipeline.sweep.tables import Entries


# fmt: off
class LogTable(Declared):
    file: A[str | TableFile,
        "Log with a row for each test, CSV or Excel, with columns such as `load [N]`; relative to "
        "the folder of the scene. Or a table that also says how to read it, such as `{ path = "
        '"log.csv", decimal = "," }`. `irg tests LOG` prints these lines.']
    words: A[dict[str, str] | None, ByPath(OneOf(OUTCOMES), "words of the log"),
        'Outcome that a word of the log means; "" is that of an empty cell.'] = None
    form: A[str | None,
        "Export of a machine, if it is not recognized; `irg tests --help` lists them."] = None
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

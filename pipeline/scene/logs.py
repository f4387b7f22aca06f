"""Lists of tests in a scene that name a file: each row of the file is a test."""

from __future__ import annotations

from typing import Any

from pipeline.paths import user_path
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.scene.format_of_tests import StagedRunTable, Test, TransitionTable
from pipeline.scene.table import read_columns, rows_of
from pipeline.sweep.limits import MOST_ROWS

LISTS = {"measured": TransitionTable, "tested": Test}


def begin(document: Document, faults: Faults) -> tuple[Document, None]:
    """Replace entries that name a file by the tests in it."""
    for key, declared in LISTS.items():
        listed = document.entries().get(key)
        if not isinstance(listed, list):
            continue
        rows = list[Any]()
        for number, entry in enumerate(listed):
            if not (isinstance(entry, dict) and "file" in entry):
                rows.append(entry)
                continue
            with faults.at(f"{key}[{number}].file"):
                folder = document.file_of(key).parent
                columns = read_columns(folder / user_path(entry["file"]), MOST_ROWS)
                has_outcome = any(one.name == "outcome" for one in columns)
                staged = key == "tested" and not has_outcome
                rows += rows_of(columns, StagedRunTable if staged else declared)
        document = document.replaced(key, rows or None)
    return document, None

"""Read the log files that a scene names in its lists of tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.laboratory.format import LogTable
from pipeline.laboratory.logs import read_log
from pipeline.paths import user_path
from pipeline.scene.choices import choices_of
from pipeline.scene.declare import table_of
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults


def begin(document: Document, faults: Faults) -> tuple[Document, None]:
    """Replace entries that name log files by the tests in these files.

    Faults of a log are reported. Returns the changed document, and None because no variants are
    added to the sweep.
    """
    for key in ("measured", "tested"):
        listed, folder = document.entries().get(key), document.file_of(key).parent
        if not isinstance(listed, list) or not listed:
            continue
        rows: list[Any] = []
        count = sum(isinstance(entry, dict) and "file" in entry for entry in listed)
        for number, entry in enumerate(listed):
            if isinstance(entry, dict) and "file" in entry:
                rows += _read_tests(entry, key, number, folder, faults, is_alone=count == 1)
            else:
                rows.append(entry)
        # No row is left only if all are faulty, and that is reported already.
        document = document.replaced(key, rows or None)
    return document, None


def _read_tests(
    entry: dict[str, Any], key: str, number: int, folder: Path, faults: Faults, is_alone: bool
) -> list[dict[str, Any]]:
    """Read the tests of the log that a table names; faults name row and column."""
    before, place = len(faults), f"{key}[{number}]"
    read = table_of(LogTable).read(entry, place, faults)
    if len(faults) > before:
        return []
    file, choices = choices_of(read.file)
    place, path = f"{place}.file", folder / user_path(file)
    with faults.at(place):
        log = read_log(path, choices, read.form, read.words or {}, key)
        log.sheet.written = "scene"
        for problem in log.sheet.told_faults:
            faults.refuse(place, f"{path.name}, {problem}")
        if log.sheet.faults and not log.tests:
            faults.refuse(place, f"what is understood of it is printed by: irg tests {path}")
        for note in filter(None, (log.sheet.counted, *log.sheet.remarks)):
            faults.note(place, note)
        if is_alone:
            return log.tests
        # Several logs may each count from 1.
        labels = ("number", "run")
        return [test | {k: f"{file} {test[k]}" for k in labels if k in test} for test in log.tests]
    return []

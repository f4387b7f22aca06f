"""Logs of a laboratory in the place of tests of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.laboratory.format import LOG
from pipeline.laboratory.logs import read_log
from pipeline.scene.compounds import Table
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.scene.format import TEST, TRANSITION
from pipeline.scene.headings import numbered
from tribo import InputError


def begin(document: Document, faults: Faults) -> tuple[Document, None]:
    """The document with the rows of log files in the place of the tests that name them."""
    for key, row_of in (("measured", TRANSITION), ("tested", TEST)):
        listed, folder = document.entries().get(key), document.file_of(key).parent
        if not isinstance(listed, list) or not listed:
            continue
        rows: list[Any] = []
        count = sum(isinstance(entry, dict) and "file" in entry for entry in listed)
        for number, entry in enumerate(listed):
            if isinstance(entry, dict) and isinstance(entry.get("file"), str):
                found = _read_tests(entry, f"{key}[{number}]", folder, row_of, faults)
                rows += found if count == 1 else [_name_log(one, entry) for one in found]
            else:
                rows.append(entry)
        # Without any row all are faulty, which is said already.
        document = document.replaced(key, rows or None)
    return document, None


def _name_log(test: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any]:
    """A test of one log of several, which all begin to count anew."""
    return test | {k: f"{entry['file']} {test[k]}" for k in ("number", "run") if k in test}


def _read_tests(
    entry: dict[str, Any], place: str, folder: Path, row_of: Table, faults: Faults
) -> list[dict[str, Any]]:
    """Tests of a file as tables of a scene; faults are named by row and column."""
    before = len(faults)
    entries = LOG.read(entry, place, faults)
    if len(faults) > before:
        return []
    place, path = f"{place}.file", folder / entry["file"]
    try:
        log = read_log(path, entries, row_of)
    except InputError as error:
        faults.refuse(place, str(error))
        return []
    for problem in log.faults:
        faults.refuse(place, f"{path.name}, {problem}")
    if log.is_unclear:
        faults.refuse(place, f"what is understood of it is printed by: irg tests {path}")
    if log.unused:
        faults.note(place, f"columns not used: {', '.join(log.unused)}")
    if log.guessed:
        faults.note(place, f"read {', '.join(log.guessed)}")
    for rows, said in (
        (log.twice, "the same as rows before, and not counted"),
        (log.left_out, "without load and velocity left out"),
    ):
        if rows:
            faults.note(place, f"{numbered(rows)} {said}")
    return log.tests

"""Read the tests of a laboratory's log: single outcomes, stepwise runs, or transitions."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.laboratory.exports import Export
from pipeline.laboratory.reading import OF_TRACE, Read, add_hints, is_one_run, read_table
from pipeline.laboratory.tables import vocabulary
from pipeline.scene.choices import Choices
from pipeline.scene.declare import table_of
from pipeline.scene.faults import quoted, row_text
from pipeline.scene.format_of_tests import StagedRunTable, Test, TransitionTable
from pipeline.scene.sheet import EMPTY, Sheet
from pipeline.sweep.measurement import OUTCOMES

MAY_LACK = (
    "friction", "mild_up_to", "severe_at", "number", "load", "velocity",
)  # fmt: skip
"""Entries of a test whose cells may be empty; a test without load or velocity is left out."""
_DISTINGUISHING = "number", "run", "friction"  # entries that tell a repeated test from a copy


@functools.cache
def outcome_of(word: str, heading: str) -> str | None:
    """Outcome, "mild" or "severe", that a word means in a column headed `heading`; None if unknown.

    Words such as "yes" mean what the heading says, such as "scuffed".
    """
    listed = vocabulary()
    words = {name: {*listed[name].split()} for name in ("mild", "severe", "yes", "no")}
    if re.search(listed["asks_severe"], heading.lower()):
        words["mild"], words["severe"] = words["mild"] | words["no"], words["severe"] | words["yes"]
    elif re.search(listed["asks_mild"], heading.lower()):
        words["mild"], words["severe"] = words["mild"] | words["yes"], words["severe"] | words["no"]
    bare = re.sub(listed["negation"], "", word.lower())
    plain = re.sub(r"[\W_]+", "", bare).replace("ß", "ss")
    found = next((name for name in OUTCOMES if plain in words[name]), None)
    if bare == word.lower() or found is None:
        return found
    is_clear = plain not in words["yes"] | words["no"]  # "not 1" may be anything
    return {"mild": "severe", "severe": "mild"}[found] if is_clear else None


@dataclass(slots=True)
class Log:
    """Tests of a log file, and how its columns and words were read.

    `tests` are tables of a scene, `in_si` the same tests in SI. `words` has the outcome meant by
    each word.
    """

    sheet: Sheet
    export: Export
    row_class: type  # what a row is: `Test`, `StagedRunTable` of a run, or `Transition`
    words: dict[str, str] = field(default_factory=dict)  # outcome meant by each word
    tests: list[dict[str, Any]] = field(default_factory=list)  # as tables of a scene
    in_si: list[dict[str, Any]] = field(default_factory=list)  # the same tests in SI

    @property
    def key(self) -> str:
        """Name of the scene's list to which the tests belong: "measured" or "tested"."""
        return "measured" if self.row_class is TransitionTable else "tested"

    @property
    def renamed(self) -> dict[str, str]:
        """Headings by entry of the scene, if the heading is not the entry's name."""
        heads = {name: self.sheet.heading(name) for name in self.sheet.places}
        known = table_of(self.row_class).keys
        return {name: x.text for name, x in heads.items() if name in known and x.name != name}


def read_log(
    path: Path, choices: Choices, form: str | None, words: Mapping[str, str], key: str
) -> Log:
    """Read the tests of a log for the scene's list `key`; faults are listed in the result's sheet.

    `form` is the name of the export that it is, and `words` has the outcomes that the user gives to
    words.
    """
    read = read_table(path, choices, form)
    if is_one_run(read_table(path, choices, form, OF_TRACE).sheet):
        read.sheet.faults.append(
            "this is a record of friction over time: one run, no list of tests"
        )
        return Log(read.sheet, read.export, Test)
    return log_of(read, words, key)


def log_of(read: Read, words: Mapping[str, str], key: str | None = None) -> Log:
    """Find the tests in a table; faults are listed in the sheet of the result.

    `words` has the outcome that the user gives to words such as "ok". Other words have their usual
    meaning; an unknown word is a fault. `key` is the scene's list that needs the tests ("measured"
    or "tested"); if it is None, the log's columns tell which list.
    """
    sheet, export, missing = read
    row_class = TransitionTable if key == "measured" else _row_class(sheet)
    if row_class is None or (key == "tested" and row_class is TransitionTable):
        sheet.require(["load", "velocity"])
        if not sheet.faults:
            sheet.faults.append(
                'no column says whether wear was mild or severe; name it by --column "outcome='
                'HEADING", or give --given "outcome=mild"; if each row is a transition, call its '
                'load by --column "transition_load=HEADING"'
            )
        return Log(sheet, export, Test)
    log = Log(sheet, export, row_class)
    if row_class is TransitionTable:
        named = [name for name in ("transition_load", "severe_at") if name in sheet.places]
        sheet.places |= {"load": sheet.places[named[0]]} if named else {}
    sheet.faults += [missing[name] for name in ("load", "velocity") if name in missing]
    needed = [name for name in ("load", "velocity") if name in table_of(row_class).needed]
    sheet.require(needed, ["load", "velocity"])
    if row_class is Test:
        _read_outcomes(log, words)
    elif row_class is StagedRunTable:
        ends = [sheet.places[name] for name in ("mild_up_to", "severe_at") if name in sheet.places]
        no_end = [row.number for row in sheet.rows if not any(row.cells[k] for k in ends)]
        sheet.leave_out(dict.fromkeys(no_end, "has neither end"))
    _leave_out_copies(sheet)
    log.tests, log.in_si = sheet.entries(row_class, log.words, MAY_LACK)
    add_hints(sheet)
    sheet.faults += _double_transitions(log)
    sheet.require_rows("load [N],velocity [m/s],outcome")
    return log


def _row_class(sheet: Sheet) -> type | None:
    """Class of a table's rows, from its columns: `Test`, `StagedRunTable`, `Transition` or None."""
    if "outcome" in sheet.places:
        return Test
    if "mild_up_to" in sheet.places:
        return StagedRunTable
    return TransitionTable if {"severe_at", "transition_load"} & sheet.places.keys() else None


def _read_outcomes(log: Log, words: Mapping[str, str]) -> None:
    """Find what the words for outcomes mean, given by `words`, and store it in ``log.words``."""
    sheet, place, title = log.sheet, log.sheet.places["outcome"], log.sheet.heading("outcome").title
    empty = [row for row in sheet.rows if row.cells[place].lower() in EMPTY]
    for _, cells in empty if "" in words else ():
        cells[place] = ""
    found_cells = dict.fromkeys(row.cells[place] for row in sheet.rows)
    found = {cell: words.get(cell) or outcome_of(cell, title) for cell in found_cells}
    log.words = {cell: one for cell, one in found.items() if one and cell not in OUTCOMES}
    meanings = {cell: one or cell for cell, one in found.items() if cell.lower() not in EMPTY}
    # An empty cell may mean the opposite of the only outcome, which the user must say.
    if empty and "" not in words and len({*meanings.values()}) == 1:
        word, outcome = next(iter(meanings.items()))
        other = "severe" if outcome == "mild" else "mild"
        sheet.faults.append(
            f"{row_text([row.number for row in empty])}: no outcome, where all others are {outcome}"
            f'; say what it is by --word "={other}", or leave them out by --where "outcome={word}"'
        )
    if "" not in words:
        sheet.require(["outcome"])
    unknown = dict[str, list[int]]()
    for number, cells in sheet.rows:
        if found[cells[place]] is None:
            unknown.setdefault(cells[place], []).append(number)
    for cell, numbers in unknown.items():
        word = cell.replace('"', '\\"')
        sheet.faults.append(
            f"{row_text(numbers)}, outcome: {quoted(cell)} is unknown; say what it means by --word "
            f'"{word}=mild" or --word "{word}=severe", or leave it out by --skip "outcome={word}"'
        )
        sheet.leave_out(dict.fromkeys(numbers, f"has the unknown outcome {quoted(cell)}"))


def _leave_out_copies(sheet: Sheet) -> None:
    """Leave out rows that are copies of earlier rows."""
    used = {k for name, k in sheet.places.items() if name not in _DISTINGUISHING} | sheet.sources
    distinguishing = {
        k
        for k in range(len(sheet.headings))
        if k not in used and len({row.cells[k] for row in sheet.rows}) > 1
    }
    first, twice = dict[tuple[str, ...], int](), dict[int, str]()
    for number, cells in sheet.rows:
        # Equal rows without a number, date or the like of their own are repeated tests.
        is_distinct = any(cells[k] for k in distinguishing)
        if is_distinct and first.setdefault((*cells,), number) != number:
            twice[number] = "repeats an earlier row"
    sheet.leave_out(twice)


def _double_transitions(log: Log) -> list[str]:
    """Faults, in words, of specimens with more than one transition, which is impossible."""
    place = log.sheet.places.get("run")
    if log.row_class is not TransitionTable or place is None:
        return []
    runs = [row.cells[place] for row in log.sheet.rows]
    twice = {run: runs.count(run) for run in runs if run and runs.count(run) > 1}
    return [
        f'{log.sheet.headings[place].text} "{run}" has {count} transitions, and a specimen has '
        "one; name the outcomes of its rows, or leave rows out by --skip"
        for run, count in twice.items()
    ]

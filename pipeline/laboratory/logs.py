"""Tests of a laboratory's log in place of tables of the scene, and the transition in a trace."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.scene.compounds import Table
from pipeline.scene.faults import Fault
from pipeline.scene.format import TEST
from pipeline.scene.headings import UNITS, Row, Sheet, listed_faults, read_sheet
from pipeline.scene.units import UnitError, to_si
from pipeline.sweep.about import OUTCOMES
from tribo import InputError
from tribo.types import Array

_MILD = "mild ok okay io pass passed bestanden gut good leicht keinfresser"
_SEVERE = (
    "severe fresser gefressen fressen scuff scuffed scuffing seizure seized fail failed nio schwer "
    "notok niok weld welded welding verschweisst verschweissung score scored scoring"
)
_NEGATION = re.compile(r"^\s*(not|no|non|nicht|keine?r?|ohne|without)[\s_-]+")
_NEAR = re.compile(r" \(did you mean [^)]*\)")  # the word may mean the contrary
_MEASURED_WEAR = re.compile(r"brugger|\b(area|scar)\b|fläche|kalotte|narbe", re.IGNORECASE)
_TRANSITIONS = re.compile(
    r"transition|critical|kritisch|übergang|scuff|fress|seiz|fail|limit|grenz", re.IGNORECASE
)
_TELLING = "number", "run", "friction"  # entries by which a row is told from a repeat of it
_YES, _NO = "yes ja y j true wahr 1 x", "no nein n false falsch 0"


def outcome_of(word: str, heading: str) -> str | None:
    """Outcome that a word below a heading means, None if it is not known."""
    mild, severe, asked = set(_MILD.split()), set(_SEVERE.split()), heading.lower()
    if re.search(r"scuff|fress|seiz|sever", asked):
        mild, severe = mild | set(_NO.split()), severe | set(_YES.split())
    elif re.search(r"pass|bestanden", asked):
        mild, severe = mild | set(_YES.split()), severe | set(_NO.split())
    said = _NEGATION.sub("", word.lower())
    plain = re.sub(r"[\W_]+", "", said).replace("ß", "ss")
    found = "mild" if plain in mild else "severe" if plain in severe else None
    if said == word.lower() or found is None:
        return found
    is_plain = plain not in f"{_YES} {_NO}".split()  # "not 1" may be anything
    return {"mild": "severe", "severe": "mild"}[found] if is_plain else None


@dataclass(slots=True)
class Log:
    """Tests of a log, and how it is understood."""

    path: Path
    sheet: Sheet  # its rows of tests, and the columns for the entries of one
    words: dict[str, str]  # outcome for each word of the log that is not one itself
    left_out: list[int]  # numbers of rows without load and velocity
    tests: list[dict[str, Any]]  # as tables of a scene
    faults: list[str]
    is_unclear: bool  # as a whole, and not in cells alone
    twice: list[int]  # numbers of rows that are the same as one before, and not counted
    in_si: list[dict[str, Any]]  # the tests, in SI

    @property
    def unused(self) -> list[str]:
        """Titles of the columns that are not used."""
        return [self.sheet.headings[place].text for place in self.sheet.others]

    @property
    def is_only_wear(self) -> bool:
        """Rows tell a measured wear, and no heading says that they are transitions."""
        heads = [heading.text for heading in self.sheet.headings]
        named = any(map(_TRANSITIONS.search, [*heads, self.path.stem]))
        return any(map(_MEASURED_WEAR.search, heads)) and not named

    @property
    def renamed(self) -> dict[str, str]:
        """Headings of entries that they do not name exactly."""
        headings = {name: self.sheet.heading(name) for name in self.sheet.places}
        return {name: one.text for name, one in headings.items() if one.name != name}

    @property
    def guessed(self) -> list[str]:
        """Headings and words that were recognised, though not exact names."""
        meant = [*((text, name) for name, text in self.renamed.items()), *self.words.items()]
        return [f'"{said}" as {name}' for said, name in meant]


def read_log(path: Path, entries: Mapping[str, Any] | None = None, row_of: Table = TEST) -> Log:
    """Read the tests of a log by its columns, words and decimal mark, as a scene gives them."""
    given = entries or {}
    named, words = given.get("columns") or {}, dict[str, str]()
    sheet = read_sheet(
        path, row_of.keys, row_of.needed, named, given.get("decimal"),
        sheet_name=given.get("sheet"), given=given.get("given") or {},
    )  # fmt: skip
    faults, places = [*sheet.faults], sheet.places
    if faults and sheet.headings and not named:
        lacks = next((name for name in row_of.needed if name not in places), "load")
        faults[-1] += (
            f'; name one by columns = {{ {lacks} = "HEADING" }} or --column "{lacks}=HEADING"'
        )
    _take_rows(sheet, given.get("where") or {}, faults)
    twice = _drop_repeats(sheet)
    needed = [places[name] for name in ("load", "velocity") if name in places]
    tested, left_out = list[Row](), list[int]()
    for row in sheet.rows:
        if not needed or any(row.cells[k] for k in needed):
            tested.append(row)
        else:
            left_out.append(row.number)
    sheet.rows = tested
    faults += sheet.of_rows
    if not tested and not faults:
        faults = [f'{path} has no rows; begin it with a line such as "load [N],velocity [m/s]"']
    if "outcome" in places:
        own, title = given.get("words") or {}, sheet.heading("outcome").title
        for word in dict.fromkeys(row.cells[places["outcome"]] for row in tested):
            if word not in OUTCOMES and (outcome := own.get(word) or outcome_of(word, title)):
                words[word] = outcome
    _part_runs(sheet, words)
    tests, in_si, wrong = sheet.entries(row_of, words)
    return Log(
        path, sheet, words, left_out, tests, [*faults, *listed_faults(map(_hinted, wrong))],
        is_unclear=bool(faults), twice=twice, in_si=in_si,
    )  # fmt: skip


def _take_rows(sheet: Sheet, where: Mapping[str, Any], faults: list[str]) -> None:
    """Keep the rows asked for."""
    heads = [heading.text for heading in sheet.headings]
    for head, value in where.items():
        if head not in heads:
            faults.append(f'where: there is no column "{head}"; give one of {", ".join(heads)}')
            continue
        column, wanted = heads.index(head), str(value)
        found = dict.fromkeys(row.cells[column] for row in sheet.rows)
        if wanted not in found:
            listed = ", ".join(filter(None, found))
            faults.append(f'where: no row has "{wanted}" as {head}; give one of {listed}')
        sheet.rows = [row for row in sheet.rows if row.cells[column] == wanted]


def _drop_repeats(sheet: Sheet) -> list[int]:
    """Keep each row once; return the numbers of those that stand there twice.

    Rows that say nothing but what was set and what came out are repeats, and all count.
    """
    telling = {sheet.places[name] for name in _TELLING if name in sheet.places}
    telling |= {k for k in sheet.others if len({row.cells[k] for row in sheet.rows}) > 1}
    first = dict[tuple[str, ...], int]()
    twice = [
        row.number
        for row in sheet.rows
        if any(row.cells[k] for k in telling)
        and first.setdefault((*row.cells,), row.number) != row.number
    ]
    sheet.rows = [row for row in sheet.rows if row.number not in twice]
    return twice


def _part_runs(sheet: Sheet, words: Mapping[str, str]) -> None:
    """Begin a run of a form's stages anew with another oil, and after a severe row."""
    made = [name for name in ("run", "outcome") if sheet.places.get(name) in sheet.sure]
    # With outcomes of its own a form makes a run of each row.
    if made != ["run"] or sheet.heading("run").text == "run, given":
        return
    place, run, before = sheet.places["run"], 0, list[str]()
    for _, cells in sheet.rows:
        now = [cells[sheet.places[name]] for name in ("run", "oil") if name in sheet.places]
        run += now != before
        cells[place] = str(run)
        outcome = cells[sheet.places["outcome"]] if "outcome" in sheet.places else ""
        before = [] if words.get(outcome, outcome) == "severe" else now


def _hinted(fault: Fault) -> Fault:
    """A fault with how to say what an unknown word means."""
    word, is_unknown, _ = fault.problem.partition(" is unknown")
    if fault.key != "outcome" or not is_unknown:
        return fault
    problem = _NEAR.sub("", fault.problem) if " " in word else fault.problem
    return fault._replace(
        problem=f"{problem}; or say what it means, mild or severe, as "
        f'words = {{ {word} = "OUTCOME" }}'
    )


_OF_TRACE = ("time", "friction", "load", "velocity", "friction_force")
_LEAST_ROWS = 20
_STANDARD_DEVIATIONS = 4.0  # standard deviations of friction before, below which a rise is scatter
_STEP_APART = 0.02  # share of the highest load by which the loads of two steps differ
_LEAST_OF_STEP = 5  # rows
_LEAST_RISE = 0.2  # share of friction before; less is running-in or a warmer film


@dataclass(frozen=True)
class Trace:
    """Friction over time."""

    time: Array  # [s]
    friction: Array
    load: Array | None = None  # [N], where it was recorded
    velocity: Array | None = None  # [m/s]

    @cached_property
    def row(self) -> int | None:
        """Row from which on friction is high, by least squares of one step upwards, if any is."""
        friction, count = self.friction, len(self.friction)
        if count < _LEAST_ROWS:
            return None
        before = np.arange(1, count)
        sums = np.cumsum(friction)
        low, high = sums[:-1] / before, (sums[-1] - sums[:-1]) / (count - before)
        gain = np.where(high > low, before * (count - before) * (high - low) ** 2, 0.0)
        row = 1 + int(np.argmax(gain))
        level = float(np.median(friction[:row]))
        scatter = 1.4826 * float(np.median(np.abs(friction[:row] - level)))
        step = float(np.median(friction[row:])) - level
        return row if step > max(_STANDARD_DEVIATIONS * scatter, _LEAST_RISE * level) else None

    def lines(self) -> Iterator[str]:
        """Say where friction rises, or that it does not."""
        if self.row is None:
            middle = float(np.median(self.friction))
            yield f"no transition: friction stays about {middle:.3g} for {self.time[-1]:.4g} s"
            return
        before, after = (float(np.median(part)) for part in np.split(self.friction, [self.row]))
        load = "" if self.load is None else f", at a load of {self.load[self.row]:.4g} N"
        yield (
            f"transition: friction rises from {before:.3g} to {after:.3g} at "
            f"{self.time[self.row]:.4g} s{load}; confirm it in the trace and on the surface"
        )

    @cached_property
    def stepped(self) -> tuple[str, Array | None]:
        """What rises in steps, the load, or at a constant load the velocity; the step of a row."""
        load, velocity = _steps_of(self.load), _steps_of(self.velocity)
        return ("velocity", velocity) if load is None else ("load", load)

    def _stages(self) -> Iterator[str]:
        """Highest step that stayed mild, and the one that turned severe."""
        name, steps = self.stepped
        if steps is None:
            return
        end = len(steps) if self.row is None else self.row
        severe = math.inf if self.row is None else steps[self.row]
        if (mild := steps[:end][steps[:end] < severe]).any():  # not at rest
            yield f'mild_up_to = "{mild.max():.4g} {UNITS[name]}"'
        if self.row is not None:
            yield f'severe_at = "{severe:.4g} {UNITS[name]}"'

    @property
    def _end(self) -> int:
        """Row of the transition, or the last before a mild test ran down."""
        if self.row is not None:
            return self.row
        both = [column for column in (self.load, self.velocity) if column is not None]
        full = [column >= (1 - _STEP_APART) * column.max() for column in both]
        return int(max(np.flatnonzero(np.all(full, axis=0)), default=len(self.time) - 1))

    def toml(self) -> Iterator[str]:
        """Lines of a scene: a run by its steps, a transition, or a test that stayed mild."""
        end, stages = self._end, [*self._stages()]
        yield "[[tested]]" if self.row is None or stages else "[[measured]]"
        yield from stages
        for name in ("load", "velocity"):
            column = getattr(self, name)
            if stages and name == self.stepped[0]:
                continue
            if column is None:
                yield f'{name} = "... {UNITS[name]}"  # not in the trace'
            else:
                yield f'{name} = "{column[end]:.4g} {UNITS[name]}"'
        yield f"friction = {float(np.median(self.friction[: self.row])):.3g}"
        if self.row is None and not stages:
            yield 'outcome = "mild"'


def _steps_of(column: Array | None) -> Array | None:
    """Step of each row of a load or a velocity, if it rises in steps and not all the time."""
    if column is None or not np.isfinite(column).all():
        return None
    order, number = np.argsort(column, kind="stable"), np.empty(len(column), int)
    apart = np.diff(column[order], prepend=column[order[0]])
    number[order] = np.cumsum(apart > _STEP_APART * column.max())
    counts = np.bincount(number)
    levels = np.array([np.median(column[number == k]) for k in range(len(counts))])
    is_rest = levels <= _STEP_APART * column.max()
    return levels[number] if (~is_rest).sum() > 1 and counts.min() >= _LEAST_OF_STEP else None


def read_trace(path: Path, entries: Mapping[str, Any] | None = None) -> Trace | None:
    """Read a trace of friction over time with the entries of a log; None if it is no trace."""

    def is_trace(found: Collection[str]) -> bool:
        return {"time", "friction"} <= {*found} or {"time", "friction_force", "load"} <= {*found}

    given, wanted = entries or {}, (*_OF_TRACE, "outcome")
    named = {name: head for name, head in given.get("columns", {}).items() if name in wanted}
    sheet = read_sheet(
        path, wanted, (), named, given.get("decimal"), is_trace, given.get("sheet"),
        given.get("given") or {},
    )  # fmt: skip
    if not is_trace(sheet.places) or len(sheet.rows) < _LEAST_ROWS:
        return None
    place, words = sheet.places.pop("outcome", None), given.get("words", {})
    if place is not None and any(
        words.get(row.cells[place]) or outcome_of(row.cells[place], sheet.headings[place].title)
        for row in sheet.rows
    ):
        return None  # a row for each test
    faults = list[str]()
    _take_rows(sheet, given.get("where") or {}, faults)
    if faults:
        raise InputError(f"{path}: {'; '.join(faults)}")
    columns = {}
    for name, place in sheet.places.items():
        unit, usual = sheet.headings[place].unit or UNITS[name], UNITS[name]
        try:
            factor = to_si(f"1 {unit}", f"1 {usual}") if usual else 1.0
            columns[name] = factor * np.array(
                [
                    to_si(cell, "1 m/s") if "rpm" in cell else float(cell or "nan")
                    for cell in (row.cells[place] for row in sheet.rows)
                ]
            )
        except (UnitError, ValueError):
            return None
    force = columns.pop("friction_force", None)
    if force is not None and "friction" not in columns:
        with np.errstate(divide="ignore", invalid="ignore"):
            columns["friction"] = force / columns["load"]
    for name in ("friction", "velocity"):  # whose signs turn with the stroke
        if name in columns:
            columns[name] = np.abs(columns[name])
    known = np.logical_and.reduce([np.isfinite(column) for column in columns.values()])
    numbers = np.array([row.number for row in sheet.rows])[known].tolist()
    for number, (before, time) in zip(numbers[1:], pairwise(columns["time"][known]), strict=True):
        if time < before:
            raise InputError(
                f"{path}, row {number}: time falls from {before:.4g} to {time:.4g} s, and a trace "
                "is one run; give each run in a file of its own, or by --where, in the order of "
                "time"
            )
    for name in columns.keys() & {"load", "velocity"}:  # at rest there is no friction
        known &= columns[name] > _STEP_APART * columns[name][known].max(initial=0.0)
    columns = {name: column[known] for name, column in columns.items()}
    return Trace(**columns) if known.sum() >= _LEAST_ROWS else None

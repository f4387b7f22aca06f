"""Duty spectrum: rows of torque and speed with hours, simulated and judged together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Annotated as A
from typing import Any

import pandas as pd

from pipeline.analysis.margin import NOT_DECIDED
from pipeline.gears.contact import mesh
from pipeline.gears.judge import judge, worst_row
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.pairfile import LOAD_FACTOR, SPEED, TORQUE
from pipeline.gears.rules import warm_duty
from pipeline.scene.along import columns_of, lines_of
from pipeline.scene.declare import Declared
from pipeline.scene.faults import Fault, listed_faults
from pipeline.scene.format import BULK
from pipeline.scene.kinds import Number
from pipeline.scene.sheet import Sheet, read_sheet
from tribo import InputError


class _Row(Declared):
    torque: A[float, TORQUE]
    speed: A[float, SPEED]
    hours: A[float | None, Number(at_least=0)] = None
    bulk_temperature: A[float | None, BULK] = None
    oil_temperature: A[float | None, BULK] = None
    load_factor: A[float | None, LOAD_FACTOR] = None


_UNITS = {"torque": "N m", "speed": "rpm", "hours": "", "bulk_temperature": "K",
          "oil_temperature": "K", "load_factor": ""}  # fmt: skip
_DUTY = "torque", "speed", "bulk_temperature", "load_factor", "oil_temperature"
_FIRST_LINE = "torque [N m],speed [rpm],hours"
_OPENINGS = {"mild": "No scuffing", NOT_DECIDED: "Scuffing is not decided", "severe": "Scuffing"}


def read_spectrum(
    source: str | PathLike[str] | Mapping[str, Sequence[Any]], pair: Pair, sheet: str | None = None
) -> tuple[list[tuple[float | None, Duty]], Sheet]:
    """Read a table of duties; return (hours or None, duty) of each row, and the table itself.

    Columns are ``torque`` and ``speed``, and optionally ``hours``, ``load factor``, and ``bulk
    temperature`` or ``oil temperature``, which replace the pair's values; see `warm_duty`. The
    `source` is a file, or columns by heading; `sheet` is the name of a sheet in a workbook. Raises
    an `InputError` that names the faults of the table.
    """
    given = Path(source) if isinstance(source, str | PathLike) else lines_of(columns_of(source))
    read = read_sheet(given, _UNITS, _DUTY[:2], _DUTY[:2], sheet)
    _, rows = read.entries(_Row)
    if {"bulk_temperature", "oil_temperature"} <= {*read.places}:
        read.faults.append("the table has bulk and oil temperatures; give only one column")
    read.refuse_faults(_FIRST_LINE)
    duties, faults = [], list[Fault]()
    for number, row in zip((row.number for row in read.rows), rows, strict=True):
        try:
            duties.append((row["hours"], warm_duty(pair, *(row[name] for name in _DUTY))))
        except InputError as error:
            faults.append(Fault("bulk_temperature", str(error), row=number))
    read.faults += listed_faults(faults)
    read.refuse_faults(_FIRST_LINE)
    return duties, read


def judge_spectrum(
    pair: Pair,
    points: str | PathLike[str] | Mapping[str, Sequence[Any]],
    sheet: str | None = None,
    **choices: Any,
) -> pd.DataFrame:
    """Simulate and judge each row of a duty spectrum.

    Parameters
    ----------
    pair : Pair
        The pair, with a critical temperature.
    points : path or mapping of str to sequence
        A .csv or .xlsx file of duties, or columns by heading; see `read_spectrum`.
    sheet : str, optional
        Sheet of a workbook.
    **choices
        Preset, workers and progress of `judge`.

    Returns
    -------
    DataFrame
        The frame of `judge`, with the number and hours of each row. The frame's attribute
        ``remarks`` lists rows and columns that were not used.

    Raises
    ------
    InputError
        If the table has faults; the message names them all.
    TriboError
        If a place cannot be simulated.
    """
    duties, read = read_spectrum(points, pair, sheet)
    table = judge([mesh(pair, duty=duty) for _, duty in duties], **choices)
    table.insert(0, "row", [row.number for row in read.rows])
    table.insert(3, "hours", [hours for hours, _ in duties])
    table.attrs["remarks"] = [*filter(None, [read.counted]), *read.remarks]
    return table


def conclusion(table: pd.DataFrame) -> str:
    """Sentence on the worst row of a duty spectrum, from the frame of `judge_spectrum`.

    The worst row decides: damage does not accumulate.
    """
    decisive = worst_row(table)
    is_same = table["verdict"] == decisive["verdict"]
    sentence = f"{_OPENINGS[decisive['verdict']]} in {is_same.sum()} of {len(table)} rows"
    hours = table["hours"]
    if hours.notna().all() and hours.sum():
        sentence += f", {hours[is_same].sum():.6g} of {hours.sum():.6g} h"
    return f"{sentence}. Row {decisive['row']} decides. {decisive['sentence']}."

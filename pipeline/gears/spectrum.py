"""A duty spectrum: rows of torque and speed with their hours, and one verdict on all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated as A
from typing import Any

from pipeline.analysis.margin import NOT_DECIDED, percent
from pipeline.gears.contact import mesh
from pipeline.gears.model import MILD, SEVERE, Simulated, simulate
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.reading import LOAD_FACTOR, SPEED, TORQUE
from pipeline.gears.rules import warm_duty
from pipeline.quantities import display
from pipeline.scene.along import columns_of, lines_of
from pipeline.scene.declare import declared
from pipeline.scene.faults import Fault, Faults, listed_faults
from pipeline.scene.format import BULK
from pipeline.scene.kinds import Quantity
from pipeline.scene.sheet import Sheet, read_sheet
from tribo import InputError


class _Hours(Quantity):
    """A duration in hours; a bare number is one of hours."""

    def _read(self, value: Any, place: str, faults: Faults) -> float:
        if isinstance(value, int | float) and not isinstance(value, bool):
            value = f"{value} h"
        return super()._read(value, place, faults) / 3600


@declared
class _Row:
    torque: A[float, TORQUE]
    speed: A[float, SPEED]
    hours: A[float | None, _Hours("100 h", zero=True)] = None
    bulk_temperature: A[float | None, BULK] = None
    oil_temperature: A[float | None, BULK] = None
    load_factor: A[float | None, LOAD_FACTOR] = None


_UNITS = {"torque": "N m", "speed": "rpm", "hours": "s", "bulk_temperature": "K",
          "oil_temperature": "K", "load_factor": ""}  # fmt: skip
_DUTY = "torque", "speed", "bulk_temperature", "load_factor", "oil_temperature"


@dataclass(frozen=True, slots=True)
class SpectrumRow:
    """A row of the spectrum, and the place that is its worst."""

    number: int  #: Row of the file, in which the headings are the first; of columns, from 1 on.
    hours: float | None
    simulated: Simulated


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Rows of a spectrum, and the verdict on all: that of the worst row."""

    rows: tuple[SpectrumRow, ...]
    unused: tuple[str, ...] = ()  #: Columns that no answer depends on.
    counted: str = ""  #: Rows used and left out, with the reasons, if any is left out.

    @property
    def binding(self) -> SpectrumRow:
        """The row that decides: scuffing has no memory, so the worst one does."""
        return max(self.rows, key=lambda row: row.simulated.rank)

    @property
    def verdict(self) -> str:
        """Verdict on the spectrum: severe if any row is, mild if all are."""
        return self.binding.simulated.verdict

    @property
    def sentence(self) -> str:
        """The verdict in one sentence, for those who decide."""
        row, share = self.binding, self._share()
        worst = row.simulated
        duty, place, critical = worst.mesh.duty, worst.place, worst.mesh.pair.critical_words
        begin = {
            SEVERE: f"Scuffing is predicted {share}",
            NOT_DECIDED: f"Whether the gears scuff is not decided {share}",
            MILD: f"No scuffing is predicted {share}",
        }[self.verdict]
        beyond = "below" if worst.distance >= 0 else "above"
        towards = "pinion" if place.position > 0 else "wheel"
        return (
            f"{begin}. Row {row.number}, {duty.torque:.4g} N m at {duty.turns:.4g} rpm, binds: "
            f"severe with {percent(worst.probability)}, {abs(worst.distance):.0f} K {beyond} the "
            f"critical temperature ({critical}), {display(abs(place.position), 'mm', 3)} from the "
            f"pitch point towards the {towards}'s tip."
        )

    @property
    def remarks(self) -> Iterator[str]:
        """The verdict on the whole, and columns that no answer depends on, in lines."""
        count = len(self.rows)
        yield (
            f"verdict on {count} {'row' if count == 1 else 'rows'}: {self.verdict}; hours are "
            "counted, and wear over them is not"
        )
        if self.unused:
            yield f"columns not used: {', '.join(self.unused)}"

    def _share(self) -> str:
        """Rows and hours with the verdict, in words."""
        rows = [row for row in self.rows if row.simulated.verdict == self.verdict]
        said = f"in {len(rows)} of {len(self.rows)} rows"
        hours = [row.hours for row in self.rows]
        if None in hours or not (total := sum(filter(None, hours))):
            return said
        own = sum(row.hours or 0.0 for row in rows)
        return f"{said}, {own:.6g} of {total:.6g} h"


def read_spectrum(
    source: str | PathLike[str] | Mapping[str, Sequence[Any]], pair: Pair, sheet: str | None = None
) -> tuple[list[tuple[float | None, Duty]], Sheet]:
    """Read a table of duties, each with its hours, and what became of its rows and columns.

    Columns are ``torque``, ``speed`` and, if they are there, ``hours``, ``load factor``, and
    ``bulk temperature`` or ``oil temperature``, in place of those of the pair; see `warm_duty`.
    """
    given = Path(source) if isinstance(source, str | PathLike) else lines_of(columns_of(source))
    read = read_sheet(given, _UNITS, _DUTY[:2], _DUTY[:2], sheet)
    _, rows = read.entries(_Row)
    if {"bulk_temperature", "oil_temperature"} <= {*read.places}:
        read.faults.append("there are bulk and oil temperatures; give one of both columns")
    first_line = "torque [N m],speed [rpm],hours"
    read.refuse_faults(first_line)
    duties, faults = [], list[Fault]()
    for number, row in zip((row.number for row in read.rows), rows, strict=True):
        try:
            duties.append((row["hours"], warm_duty(pair, *(row[name] for name in _DUTY))))
        except InputError as error:
            faults.append(Fault("bulk_temperature", str(error), row=number))
    read.faults += listed_faults(faults)
    read.refuse_faults(first_line)
    return duties, read


def judge_spectrum(
    pair: Pair,
    points: str | PathLike[str] | Mapping[str, Sequence[Any]],
    sheet: str | None = None,
    **choices: Any,
) -> Spectrum:
    """Simulate a duty spectrum, and judge it by its worst row.

    Parameters
    ----------
    pair : Pair
        The pair, with a critical temperature.
    points : path or mapping of str to sequence
        A .csv or .xlsx file of duties, or columns by heading; see `read_spectrum`.
    sheet : str, optional
        Sheet of a workbook.
    **choices
        Preset, workers and progress of `simulate`.

    Raises
    ------
    InputError
        If the table has faults; the message names all.
    """
    duties, table = read_spectrum(points, pair, sheet)
    found = simulate([mesh(pair, duty=duty) for _, duty in duties], **choices)
    rows = (
        SpectrumRow(row.number, hours, one)
        for row, (hours, _), one in zip(table.rows, duties, found, strict=True)
    )
    return Spectrum((*rows,), tuple(table.unused), table.counted)

"""One figure or table of the paper, recomputed: text, data, figure, and where they agree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Finding:
    """A statement of the paper beside what is computed.

    Attributes
    ----------
    printed, computed : str
        Statement of the paper and result of the computation, each in a few words.
    agrees : bool
        Whether the two agree.
    why : str
        Reason for a difference, or for an agreement that is a coincidence.
    """

    printed: str
    computed: str
    agrees: bool
    why: str = ""

    def __str__(self) -> str:
        verdict = "agrees " if self.agrees else "differs"
        reason = f" {self.why}" if self.why else ""
        return f"{verdict}  {self.printed}: {self.computed}.{reason}"


@dataclass(frozen=True, slots=True)
class Table:
    """Texts in columns; a row of one text is a heading within the table."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def lines(self) -> Iterator[str]:
        r"""Aligned text: the first column to the left, the others to the right.

        Examples
        --------
        >>> table = Table(("load", "a", "b"), (("width",), ("750 N", "1", "22")))
        >>> print(*table.lines(), sep="\n")
        load   a   b
        width
        750 N  1  22
        """
        full = [self.columns, *(row for row in self.rows if len(row) > 1)]
        widths = [max(len(row[i]) for row in full) for i in range(len(self.columns))]
        for row in (self.columns, *self.rows):
            if len(row) == 1:
                yield row[0]
                continue
            cells = [row[0].ljust(widths[0])]
            cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
            yield "  ".join(cells).rstrip()

    def markdown(self) -> Iterator[str]:
        """The same as a table of Markdown, headings in bold."""
        blank = ("",) * (len(self.columns) - 1)
        yield f"| {' | '.join(self.columns)} |"
        yield "|---" * len(self.columns) + "|"
        for row in self.rows:
            cells = (f"**{row[0]}**", *blank) if len(row) == 1 else row
            yield f"| {' | '.join(cells)} |"


@dataclass(frozen=True, slots=True)
class Report:
    """A figure or table of the paper, computed.

    Attributes
    ----------
    name : str
        Name of the result, as in `irg reproduce --list`.
    title : str
        One line on what is shown.
    table : Table
        The numbers, written for reading.
    findings : tuple of Finding
        Statements of the paper beside what is computed.
    notes : tuple of str
        Assumptions that the numbers rest on.
    data : dict
        The numbers as plain values, in SI unless the key names another unit.
    figure : Figure
        The numbers, drawn.
    seconds : float
        Duration of its computation [s].
    file : Path or None
        File the figure was written to.
    """

    name: str
    title: str
    table: Table
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    data: dict[str, Any]
    figure: Figure = field(repr=False)
    seconds: float = 0.0
    file: Path | None = None

    def lines(self) -> Iterator[str]:
        """Lines of text for a terminal."""
        yield f"{self.name}: {self.title}"
        yield ""
        yield from self.table.lines()
        yield ""
        yield from map(str, self.findings)
        yield from (f"note     {note}" for note in self.notes)
        if self.file:
            yield f"figure   {self.file}"
        yield f"took     {self.seconds:.1f} s"

    def as_dict(self) -> dict[str, Any]:
        """One document of plain values."""
        return {
            "name": self.name,
            "title": self.title,
            "agrees": all(finding.agrees for finding in self.findings),
            "findings": [
                {
                    "printed": finding.printed,
                    "computed": finding.computed,
                    "agrees": finding.agrees,
                    "why": finding.why,
                }
                for finding in self.findings
            ],
            "notes": list(self.notes),
            "data": self.data,
            "figure": str(self.file) if self.file else None,
            "wall_time": self.seconds,
        }


def mean_and_spread(values: Sequence[float], digits: int = 0) -> str:
    """Mean and standard deviation, the latter only where there are several values.

    Examples
    --------
    >>> mean_and_spread([150.0, 154.0]), mean_and_spread([150.0], digits=1)
    ('152 ± 3', '150.0')
    """
    mean, spread = statistics(values)
    return f"{mean:.{digits}f}" + (f" ± {spread:.{digits}f}" if len(values) > 1 else "")


def statistics(values: Sequence[float]) -> tuple[float, float]:
    """Mean, and standard deviation of the single values; 0 if there is but one."""
    mean = sum(values) / len(values)
    if len(values) == 1:
        return mean, 0.0
    return mean, (sum((value - mean) ** 2 for value in values) / (len(values) - 1)) ** 0.5

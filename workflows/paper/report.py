"""One figure or table of the paper, recomputed: text, data, figure, and where they agree.

All prose stands in ``words.toml``, by result; numbers are put into its braces. Beside the formats
of Python, ``g%`` writes a share in percent, lists are written one by one, and with ``range`` as
their lowest and highest value.
"""

from __future__ import annotations

import string
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.analysis.tables import lines_of
from tribo.types import Array

WORDS: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("words.toml").read_text(encoding="utf-8")
)
"""Prose of the results, by their names."""


class _Writer(string.Formatter):
    """Writer of numbers into prose."""

    def format_field(self, value: Any, form: str) -> str:
        """Text of a value, or of a list of values.

        Examples
        --------
        >>> writer = _Writer()
        >>> writer.format("{a:g%}; {b:.1f}; {b:+.0f%range}", a=0.1, b=[1.0, 2.0])
        '10 %; 1.0, 2.0; +100 to +200 %'
        """
        is_range, form = form.endswith("range"), form.removesuffix("range")
        unit, form = " %" * form.endswith("%"), form.removesuffix("%")
        values = np.atleast_1d(value).tolist()
        texts = [
            format(100 * entry if unit else entry, form)
            for entry in ((min(values), max(values)) if is_range else values)
        ]
        return (" to " if is_range else ", ").join(texts) + unit


_WRITER = _Writer()


@dataclass(frozen=True, slots=True)
class Finding:
    """A statement of the paper beside what is computed.

    Attributes
    ----------
    printed, computed : str
        Statement of the paper and result of the computation, each in a few words.
    agrees : bool
        True if the two agree.
    why : str
        Reason for a difference, or for an agreement that is a coincidence.
    """

    printed: str
    computed: str
    agrees: bool
    why: str = ""

    def __str__(self) -> str:
        verdict = "agrees " if self.agrees else "differs"
        return f"{verdict}  {self.printed}: {self.computed}.{self.reason}"

    @property
    def reason(self) -> str:
        """The reason after a blank, if there is one."""
        return f" {self.why}" if self.why else ""


def judged(result: str, statement: str, agrees: bool, values: Mapping[str, Any]) -> Finding:
    """Judge a statement of the paper, in the words of a result filled with values.

    The value ``why`` names the reason; without it the reason is the usual one.
    """
    texts = WORDS[result]["findings"][statement]
    why = texts.get(values.get("why"), texts.get("why", ""))
    printed, computed, why = (
        _WRITER.vformat(text, (), values) for text in (texts["printed"], texts["computed"], why)
    )
    return Finding(printed, computed, bool(agrees), why)


_NEAR = 0.1  # relative: see `agree`


def agree(computed: Any, printed: Any, zero: Any = 0.0) -> bool:
    """Whether numbers agree with printed ones, by the rule of the page.

    Each mean over the surfaces, the last axis, lies within a tenth of the printed number or within
    twice its own standard deviation; of temperatures the tenth is of the rise above `zero`.

    Examples
    --------
    >>> agree([[10.0, 11.0]], [9.6]), agree([[10.0, 10.2]], [9.0]), agree([[160.0]], [155.0], 145.0)
    (True, False, False)
    """
    allowed = np.maximum(_NEAR * np.abs(np.subtract(printed, zero)), 2 * spread(computed))
    return bool((np.abs(mean(computed) - printed) <= allowed).all())


def texts(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> pd.DataFrame:
    """Texts in columns; a row of one text is a heading within them."""
    filled = ((*row, *[""] * (len(columns) - len(row))) for row in rows)
    return pd.DataFrame(filled, columns=pd.Index(columns))


def line(label: str, values: Iterable[Any], form: str = ".0f") -> tuple[str, ...]:
    """Row of a table, its cells after a label.

    Examples
    --------
    >>> line("load", ["none", 2.0, [1.0, 3.0]], ".1f")
    ('load', 'none', '2.0', '2.0 ± 1.4')
    """
    return (label, *cells(values, form))


def cells(values: Iterable[Any], form: str) -> Iterator[str]:
    """Cells of a table: texts as they are, numbers by a format, of lists the mean and spread."""
    for value in values:
        if isinstance(value, str):
            yield value
        else:
            parts = [mean(value), spread(value)] if np.size(value) > 1 else [value]
            yield " ± ".join(_WRITER.format_field(part, form) for part in parts)


@dataclass(frozen=True, slots=True)
class Report:
    """A figure or table of the paper, computed.

    Attributes
    ----------
    name : str
        Name of the result, as in `irg paper --list`.
    title : str
        One line that describes the figure.
    table : DataFrame
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
    table: pd.DataFrame
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    data: dict[str, Any]
    figure: Figure = field(repr=False)
    seconds: float = 0.0
    file: Path | None = None

    @classmethod
    def of(
        cls,
        name: str,
        values: Mapping[str, Any],
        verdicts: Mapping[str, bool],
        data: dict[str, Any],
        findings: Iterable[Finding] = (),
        **parts: Any,
    ) -> Report:
        """Report on a result, its words filled with values and data.

        Verdicts go by the names of statements, true if one agrees with what is computed.
        """
        values = {**data, **values}
        notes = (_WRITER.vformat(note, (), values) for note in WORDS[name]["notes"])
        usual = (judged(name, statement, agrees, values) for statement, agrees in verdicts.items())
        return cls(
            name,
            title=_WRITER.vformat(WORDS[name]["title"], (), values),
            findings=(*usual, *findings),
            notes=tuple(filter(None, notes)),
            data=data,
            **parts,
        )

    def lines(self) -> Iterator[str]:
        """Lines of text for a terminal."""
        yield f"{self.name}: {self.title}"
        yield ""
        yield from lines_of(self.table)
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
            "findings": [asdict(finding) for finding in self.findings],
            "notes": list(self.notes),
            "data": _plain(self.data),
            "figure": str(self.file) if self.file else None,
            "wall_time": self.seconds,
        }


def _plain(value: Any) -> Any:
    """Values for JSON: names as text, arrays as lists."""
    if isinstance(value, Mapping):
        return {str(name): _plain(part) for name, part in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def mean(values: Any) -> Array:
    """Mean over the last axis."""
    means: Array = np.mean(values, axis=-1)
    return means


def spread(values: Any) -> Array:
    """Standard deviation of the single values of the last axis; 0 if there is but one."""
    values = np.asarray(values)
    spreads: Array = np.std(values, axis=-1, ddof=min(1, values.shape[-1] - 1))
    return spreads

"""One figure or table of the paper, recomputed: text, data, figure, and where they agree.

All prose stands in ``words.toml``, by result; numbers are put into its braces. Beside the formats
of Python, ``g%`` writes a share in percent, lists are written one by one, and with ``range`` as
their lowest and highest value.
"""

from __future__ import annotations

import re
import string
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.frames import lines_of
from tribo.types import Array

WORDS: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("words.toml").read_text(encoding="utf-8")
)
"""Prose of the results, by their names."""


class _Formatter(string.Formatter):
    """Formatter that fills numbers, and lists of numbers, into text."""

    def format_field(self, value: Any, form: str) -> str:
        """Text of a value, or of a list of values.

        Examples
        --------
        >>> writer = _Formatter()
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


_WRITER = _Formatter()
_MINUS = re.compile(r"(?<!\w)-(?=\d)")  # not that of 1e-6


@dataclass(frozen=True, slots=True)
class Finding:
    """A statement of the paper beside what is computed.

    Attributes
    ----------
    name : str
        Name of the statement, such as ``"width"``.
    printed, computed : str
        Statement of the paper and result of the computation, each in a few words.
    agrees : bool
        True if the two agree.
    why : str
        Reason for a difference, or for an agreement that is a coincidence.
    """

    name: str
    printed: str
    computed: str
    agrees: bool
    why: str = ""

    def __str__(self) -> str:
        verdict = "agrees " if self.agrees else "differs"
        return f"{verdict}  {self.printed}: {self.computed}.{self.reason}"

    @property
    def reason(self) -> str:
        """The reason for a difference, after a blank; empty if there is none."""
        return f" {self.why}" if self.why else ""


def judged(result: str, statement: str, agrees: bool, values: Mapping[str, Any]) -> Finding:
    """Finding on a statement of the paper, in words of the result `result` filled with values.

    `values["why"]` names the reason to give; without it the usual reason is given.
    """
    texts = WORDS[result]["findings"][statement]
    why = texts.get(values.get("why"), texts.get("why", ""))
    printed, computed, why = (
        _MINUS.sub("−", _WRITER.vformat(text, (), values))
        for text in (texts["printed"], texts["computed"], why)
    )
    return Finding(statement, printed, computed, bool(agrees), why)


_TOLERANCE = 0.1  # relative: see `agree`


def agree(computed: Any, printed: Any, zero: Any = 0.0) -> bool:
    """True if computed numbers agree with printed ones, by the rule that the gallery states.

    The last axis of `computed` is surfaces. Each mean over surfaces lies within a tenth of the
    printed number, or within twice the standard deviation over surfaces. The tenth counts from
    `zero`, as for temperatures above bulk.

    Examples
    --------
    >>> agree([[10.0, 11.0]], [9.6]), agree([[10.0, 10.2]], [9.0]), agree([[160.0]], [155.0], 145.0)
    (True, False, False)
    """
    allowed = np.maximum(_TOLERANCE * np.abs(np.subtract(printed, zero)), 2 * spread(computed))
    return bool((np.abs(mean(computed) - printed) <= allowed).all())


def texts(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> pd.DataFrame:
    """Data frame of texts; a row with a single text is a heading inside the table."""
    filled = ((*row, *[""] * (len(columns) - len(row))) for row in rows)
    return pd.DataFrame(filled, columns=pd.Index(columns))


def line(label: str, values: Iterable[Any], form: str = ".0f") -> tuple[str, ...]:
    """Row of a table: a label, then values as text; lists as mean ± standard deviation.

    Examples
    --------
    >>> line("load", ["none", 2.0, [1.0, 3.0]], ".1f")
    ('load', 'none', '2.0', '2.0 ± 1.4')
    """
    return (label, *cells(values, form))


def cells(values: Iterable[Any], form: str) -> Iterator[str]:
    """Yield values as text: numbers in the format `form`, lists as mean ± standard deviation."""
    for value in values:
        if isinstance(value, str):
            yield value
        else:
            parts = [mean(value), spread(value)] if np.size(value) > 1 else [value]
            yield " ± ".join(_WRITER.format_field(part, form) for part in parts)


@dataclass(frozen=True, slots=True)
class Recomputation:
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
    def from_values(
        cls,
        name: str,
        values: Mapping[str, Any],
        verdicts: Mapping[str, bool],
        data: dict[str, Any],
        findings: Iterable[Finding] = (),
        **parts: Any,
    ) -> Recomputation:
        """Make the report on a result; its words are filled with values and data.

        `verdicts` are True for statements, by name, that agree with the computation.
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
        """Yield the report in lines of text for a terminal."""
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
        """The report as plain data for JSON."""
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
    """A value with plain types for JSON: names as text, arrays as lists."""
    if isinstance(value, Mapping):
        return {str(name): _plain(part) for name, part in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def mean(values: Any) -> Array:
    """Mean over the last axis."""
    means: Array = np.mean(values, axis=-1)
    return means


def spread(values: Any) -> Array:
    """Standard deviation over the last axis; 0 if it has a single value."""
    values = np.asarray(values)
    spreads: Array = np.std(values, axis=-1, ddof=min(1, values.shape[-1] - 1))
    return spreads

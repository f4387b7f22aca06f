"""Caveats of an answer: what a reader of it must know, in a line of at most 100 columns each."""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.quantities import display
from pipeline.sweep.accuracy import error_in_words
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Sweep
from pipeline.sweep.physics import caveat_on_turns, note_on_ends

SEPARATOR = " | "
"""What separates notes in a cell of a table, since sentences have semicolons."""


def caveats(
    sweep: Sweep, conditions: Conditions, counts_inputs: bool, warm: str
) -> tuple[str, ...]:
    """Caveats of answers on a sweep under some conditions; samples count errors of the inputs.

    Where wear is severe on warm tracks is given in words, if known.
    """
    critical, sd = conditions.critical_temperature, conditions.critical_sd
    lines = [
        sweep.declared.caveat,
        note_on_ends(sweep),
        caveat_on_turns(sweep, warm) if critical else None,
        None if counts_inputs else "inputs such as the steel's conductivity are taken as exact",
        critical_in_words(critical, sd) if critical and sd else None,
        error_in_words(sweep) if critical else None,
    ]
    return tuple(line for line in lines if line)


def critical_in_words(value: float, sd: float | None) -> str:
    """How exactly a critical temperature is known, and that verdicts count it [K]."""
    doubt = f" ± {display(sd, 'K', 2)}, which is counted" if sd else ", taken as exact"
    return f"the critical temperature is {display(value, '°C', 4)}{doubt}"


def joined(notes: Iterable[str]) -> str | None:
    """Notes as a cell of a table, each once; None without any."""
    return SEPARATOR.join(dict.fromkeys(notes)) or None


def parted(cells: Iterable[str | None]) -> list[str]:
    """The notes of cells of a table, each once."""
    return [*dict.fromkeys(one for cell in cells if cell for one in cell.split(SEPARATOR))]

"""Remarks beside a result: the entry they are about, how serious they are, and their words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

Grade = Literal["note", "warning"]
_SEPARATOR = " | "  # of notes in a cell, since sentences have semicolons


class Remark(NamedTuple):
    """A note or warning on a result; `place` is the path of the entry that it is about.

    `place` is empty if the remark is not about a single entry.
    """

    place: str
    grade: Grade
    words: str

    @property
    def text(self) -> str:
        """The remark as text, after the path of its entry."""
        return f"{self.place}: {self.words}" if self.place else self.words

    def __str__(self) -> str:
        return f"{self.grade}: {self.text}"


def remarks(grade: Grade, *words: str | None) -> Iterator[str]:
    """Write each of `words` as a line such as "note: text"; empty words are left out.

    `grade` is the word before the colon.
    """
    return (str(Remark("", grade, one)) for one in words if one)


def join_notes(notes: Iterable[str]) -> str | None:
    """Return the text of one table cell with all `notes`, without repeats; None without notes."""
    return _SEPARATOR.join(dict.fromkeys(notes)) or None


def split_notes(cells: Iterable[str | None]) -> list[str]:
    """Return the notes in `cells`, texts made by `join_notes`, without repeats."""
    return [*dict.fromkeys(one for cell in cells if cell for one in cell.split(_SEPARATOR))]

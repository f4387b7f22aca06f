"""Remarks beside a result: the entry they are about, how serious they are, and their words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

Grade = Literal["note", "warning"]
_SEPARATOR = " | "  # of notes in a cell, since sentences have semicolons


class Remark(NamedTuple):
    """Words beside a result, about the entry of the scene at a place; empty if about none alone."""

    place: str
    grade: Grade
    words: str

    @property
    def text(self) -> str:
        """The words, after their place."""
        return f"{self.place}: {self.words}" if self.place else self.words

    def __str__(self) -> str:
        return f"{self.grade}: {self.text}"


def remarks(grade: Grade, *words: str | None) -> Iterator[str]:
    """Lines of remarks about no entry alone, one for each of the words that are not empty."""
    return (str(Remark("", grade, one)) for one in words if one)


def joined(notes: Iterable[str]) -> str | None:
    """Notes as a cell of a table, each once; None without any."""
    return _SEPARATOR.join(dict.fromkeys(notes)) or None


def parted(cells: Iterable[str | None]) -> list[str]:
    """The notes of cells of a table, each once."""
    return [*dict.fromkeys(one for cell in cells if cell for one in cell.split(_SEPARATOR))]

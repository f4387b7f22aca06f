"""Remarks beside a result: the entry they are about, how serious they are, and their words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

Grade = Literal["note", "warning"]


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

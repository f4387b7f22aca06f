"""Remarks beside a result, each on an entry; and values of the library, with their sources."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

Grade = Literal["note", "warning"]


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


class FromLibrary(NamedTuple):
    """A value that a scene takes from the library: key path, value with unit, and source."""

    key: str
    value: str
    source: str


def library_tables(taken: Iterable[FromLibrary]) -> Iterator[tuple[str, str]]:
    """Yield pairs (text, source) for the values in `taken`, by table of the scene and source.

    The text names the table and its values, such as "pin: density 7800 kg/m³".
    """
    tables: dict[tuple[str, str], list[str]] = {}
    for key, value, source in taken:
        table, _, name = key.rpartition(".")
        tables.setdefault((table, source), []).append(f"{name.replace('_', ' ')} {value}")
    for (table, source), values in tables.items():
        yield f"{table}: {', '.join(values)}", source

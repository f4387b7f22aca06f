"""Notes and warnings on a scene, and values of the library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from pipeline.messages import listed
from pipeline.quantities import in_unit
from pipeline.units import typeset


class SceneNote(NamedTuple):
    """How an entry of a scene was read; `path` is its path, empty for no single entry."""

    path: str
    words: str

    @property
    def text(self) -> str:
        """The note as text, after the path of its entry."""
        return f"{self.path}: {self.words}" if self.path else self.words


class SceneWarning(NamedTuple):
    """A probable mistake in a scene, or a limit of the model.

    `path` is the path of the entry that it is about, empty for no single entry. `cases` has the
    labels of the cases that it is about, empty for all; `of_case` is the case that its numbers are
    of, empty if they are the same in all. Answers state a warning themselves, at the points that it
    concerns, if `is_in_answers`.
    """

    path: str
    words: str
    is_in_answers: bool = False
    cases: tuple[str, ...] = ()
    of_case: str = ""

    @property
    def text(self) -> str:
        """The warning as text, after the path of its entry."""
        words = self.words
        if self.cases or self.of_case:
            names = listed(self.cases) or "all cases"
            of_case = f"; numbers are of case {self.of_case}" if self.of_case else ""
            words = f"{words} (in {names}{of_case})"
        return f"{self.path}: {words}" if self.path else words


def unusual_warning(
    path: str, value: float, usual: tuple[float, float] | None, unit: str
) -> list[SceneWarning]:
    """Warning that a value [SI] is outside its usual range, which is in `unit`; empty if it is not.

    If `usual` is None, no value is unusual; NaN, for a value that is not known, is none either.
    """
    if usual is None:
        return []
    (low, high), unit = usual, typeset(unit)
    number, suffix = in_unit(value, unit), f" {unit}" if unit else ""
    if not (number < low or high < number):
        return []
    words = (
        f"{number:.3g}{suffix} is unusual ({low:g} to {high:g}{suffix} is common): "
        "check number and unit"
    )
    return [SceneWarning(path, words)]


class FromLibrary(NamedTuple):
    """A value that a scene takes from the library: key path, value with unit, and source."""

    key: str
    value: str
    source: str


def library_tables(library_values: Iterable[FromLibrary]) -> Iterator[tuple[str, str]]:
    """Yield pairs (text, source) for `library_values`, by table of the scene and source.

    The text names the table and its values, such as "pin: density 7800 kg/m³".
    """
    tables: dict[tuple[str, str], list[str]] = {}
    for key, value, source in library_values:
        table, _, name = key.rpartition(".")
        tables.setdefault((table, source), []).append(f"{name.replace('_', ' ')} {value}")
    for (table, source), values in tables.items():
        yield f"{table}: {', '.join(values)}", source

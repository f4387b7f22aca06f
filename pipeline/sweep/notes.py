"""Notes and warnings on a scene, the latter as codes with values; and values of the library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

from pipeline.units import unusual


class SceneNote(NamedTuple):
    """How an entry of a scene was read; `path` is its path, empty for no single entry."""

    path: str
    words: str

    @property
    def text(self) -> str:
        """The note as text, after the path of its entry."""
        return f"{self.path}: {self.words}" if self.path else self.words


Code = Literal[
    "unusual", "unusual_values", "narrow_window", "lay_along_sliding", "long_correlation",
    "no_wear", "far_test", "fresh_specimens", "cold_tracks", "large_uncertainty",
]  # fmt: skip
"""Kinds of warnings."""


class SceneWarning(NamedTuple):
    """A probable mistake in a scene, or a limit of the model: a code, and its values [SI].

    `path` is the path of the entry that it is about, empty for no single entry. `cases` has the
    labels of the cases that it is about, empty for all; `of_case` is the case that the values are
    of, empty if they are the same in all.
    """

    code: Code
    path: str = ""
    values: tuple[float | str, ...] = ()
    cases: tuple[str, ...] = ()
    of_case: str = ""


def unusual_warning(
    path: str, value: float, usual: tuple[float, float] | None, unit: str
) -> list[SceneWarning]:
    """Warning that a value [SI] is outside its usual range, which is in `unit`; empty if it is not.

    If `usual` is None, no value is unusual.
    """
    if usual is None or not unusual(value, usual, unit):
        return []
    return [SceneWarning("unusual", path, (float(value), *map(float, usual), unit))]


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

"""Faults of a scene file, the error that carries all of them, and the words of their messages."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from pipeline.scene.shipped import name_of
from pipeline.scene.units import UnitError
from pipeline.sweep.remarks import Grade, Remark
from tribo import InputError, TriboError

_SHOWN_ROWS = 6  # rows that a message names
_SHOWN = 18  # faults that are shown, where there are thousands


class Fault(NamedTuple):
    """A fault in an entry of a scene: its key path, what is wrong, and what to do instead.

    `file` is given if the key is not enough to find the entry. For a fault in a table file, `row`
    is the number of the row and `key` the column.
    """

    key: str
    problem: str
    file: Path | None = None
    row: int = 0


class Faults(list[Fault]):
    """All faults of a scene, and notes and warnings on other entries."""

    def __init__(self, is_complete: bool = False, allows_store_only: bool = False) -> None:
        super().__init__()
        self.notes: list[Remark] = []
        self.is_complete = is_complete  # the entries of a store, where no default fills a gap
        self.allows_store_only = allows_store_only  # entries that no file may have are allowed

    def refuse(self, key: str, problem: str) -> None:
        """Add a fault of the entry at a key path; `problem` also says what to do."""
        self.append(Fault(key, problem))

    def note(self, place: str, words: str, grade: Grade = "note") -> None:
        """Add `words` as a note or warning (`grade`) on the entry at the key path `place`.

        Nothing is added if `words` is empty.
        """
        if words:
            self.notes.append(Remark(place, grade, words))

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Context manager: turn an `InputError` or `UnitError` into a fault of the entry `key`."""
        try:
            yield
        except (InputError, UnitError) as error:
            self.refuse(key, " ".join(str(error).split()))

    def touches(self, path: str) -> bool:
        """True if there is a fault in the entry at a path, within it, or in the table around it."""
        within = f"{path}.", f"{path}["
        return any(
            key == path or key.startswith(within) or path.startswith(f"{key}.") for key, *_ in self
        )


class SceneFileError(TriboError):
    """A scene file cannot be used.

    Attributes
    ----------
    path : Path
        Scene file.
    faults : list of str
        Every fault, one line each: key, file if it is not the scene file, what is wrong, and what
        is allowed.

    Examples
    --------
    >>> import pipeline
    >>> try:
    ...     pipeline.load_scene("workflows/first_try.toml", overrides={"pin.radius": 2})
    ... except pipeline.SceneFileError as error:
    ...     print(error)
    workflows/first_try.toml: pin.radius: 2 has no unit; give a length above 0, such as "2 mm"
    """

    def __init__(self, path: Path, faults: list[str]) -> None:
        super().__init__(path, faults)
        self.path = path
        self.faults = faults

    def __str__(self) -> str:
        name = name_of(self.path)
        if not name.isprintable():
            name = json.dumps(name)
        return fault_lines(name, self.faults)


def fault_lines(name: str, faults: Sequence[str]) -> str:
    """Join faults to a message that names the file; several have a line each, 20 at most."""
    if len(faults) == 1:
        return f"{name}: {faults[0]}"
    lines = [f"{name}: {len(faults)} faults", *faults[:_SHOWN]]
    if (more := len(faults) - _SHOWN) > 0:
        lines.append(f"and {more} more")
    return "\n  ".join(lines)


def quoted(value: object) -> str:
    """Write a value on one line, roughly as in the scene file."""
    if isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"[{', '.join(map(quoted, value[:4]))}{', ...' if len(value) > 4 else ''}]"
    elif isinstance(value, str):
        text = json.dumps(value, ensure_ascii=not value.isprintable())
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int) and abs(value) > 10**30:  # Python writes 4300 digits at most
        text = "a number above 10^30"
    else:
        text = str(value)
    return text if len(text) <= 100 else f"{text[:96]} ..."


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Question such as "did you mean X?" for the most similar of `words`; else empty."""
    word, known = word[:80].lower(), {other.lower(): other for other in words}
    ends = [other for other in known if other.endswith(f".{word}")]
    longer = [other for other in known if len(word) > 2 and other.startswith(word)]
    near = ends or longer or difflib.get_close_matches(word, known, n=1, cutoff=0.67)
    return f' (did you mean "{known[near[0]]}"?)' if near else ""


def key_path(place: str, key: str) -> str:
    """Path of a key within the table `place`, quoted as TOML needs it."""
    bare = key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)
    return f"{place}.{bare}" if place else bare

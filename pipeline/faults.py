"""Faults of a scene file, and the error that carries all of them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from pipeline.messages import fault_lines
from pipeline.shipped import name_of
from pipeline.sweep.notes import SceneNote, SceneWarning
from pipeline.table import TableError
from pipeline.units import UnitError
from tribo import InputError, TriboError


class Fault(NamedTuple):
    """A fault in an entry of a scene: its key path, what is wrong, and what to do instead."""

    key: str
    problem: str


class Faults(list[Fault]):
    """Faults of a scene, and notes and warnings on other entries."""

    def __init__(self) -> None:
        super().__init__()
        self.notes: list[SceneNote] = []
        self.warnings: list[SceneWarning] = []

    def refuse(self, key: str, problem: str) -> None:
        """Add a fault of the entry at a key path; `problem` also says what to do."""
        self.append(Fault(key, problem))

    def note(self, key: str, text: str) -> None:
        """Add a note on the entry at the key path `key`."""
        self.notes.append(SceneNote(key, text))

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Context manager: turn an `InputError` or `UnitError` into a fault of the entry `key`."""
        try:
            yield
        except TableError as error:
            for fault in error.faults if len(error.faults) > 1 else [str(error)]:
                self.refuse(key, fault)
        except (InputError, UnitError) as error:
            self.refuse(key, " ".join(str(error).split()))

    def raise_first(self) -> None:
        """Raise the first fault, if there is one, as an `InputError`."""
        if self:
            raise InputError(f"{self[0].key}: {self[0].problem}")


class SceneFileError(TriboError):
    """A scene file cannot be used.

    Attributes
    ----------
    path : Path
        Scene file.
    faults : list of str
        Every fault, one line each: key, the scene that the entry is inherited from, what is wrong,
        and what is allowed.

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

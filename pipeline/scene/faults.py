"""Faults of a scene file, the error that carries all of them, and that of one not to be written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

from tribo import InputError, TriboError

_SHOWN = 100  # faults, at most, where there are thousands


class Fault(NamedTuple):
    """One thing that is wrong with a scene.

    Attributes
    ----------
    key : str
        Key path of the entry, such as ``disk.roughness.ra``; empty if the whole file is meant.
    problem : str
        Fault, value, allowed values and cure, in one line.
    file : Path or None
        File that the entry stands in, where the key alone does not tell.
    """

    key: str
    problem: str
    file: Path | None = None


class SceneFileError(TriboError):
    """A scene file that cannot be used.

    Attributes
    ----------
    path : Path
        Scene file.
    faults : list of str
        Every fault, one line each: its key, the file where that is another one, what is wrong and
        what is allowed.

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
        name = str(self.path)
        if not name.isprintable():
            name = json.dumps(name)
        if len(self.faults) == 1:
            return f"{name}: {self.faults[0]}"
        shown = self.faults[:_SHOWN]
        if more := len(self.faults) - len(shown):
            shown = [*shown, f"and {more} more"]
        return "\n  ".join([f"{name}: {len(self.faults)} faults", *shown])


def unwritable(path: Path, error: OSError) -> InputError:
    """Say why a file cannot be written."""
    folder = path.parent
    reason = error.strerror or error if folder.is_dir() else f"there is no folder {folder}"
    return InputError(f"{path} cannot be written: {reason}")

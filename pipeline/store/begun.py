"""What the creation of a store leaves in a folder if it is cut short.

A new store has its arrays and coordinates before it has a root. So a folder without a root is
begun anew if it holds nothing but that, each file just as a creation writes it; a folder with a
chunk of any point, or with any other file, is left alone.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from pipeline.store.folder import PARTIAL, ROOT, Place, read_json
from pipeline.store.variables import is_coordinate, variable_of

_PARTIAL = re.compile(rf".+\.(json|[0-9a-f]{{32}}){re.escape(PARTIAL)}")
_CHUNK = re.compile(r"c\.\d+")


def is_begun(folder: Place) -> bool:
    """Whether a folder without a root holds only what comes before it, or nothing."""
    return not (folder / ROOT).exists() and all(_is_of_creation(each) for each in folder.iterdir())


def remove_partial(folder: Path) -> None:
    """Remove what processes that were killed were writing, which takes a look at every name."""
    for place, _, names in os.walk(folder):
        for name in names:
            if name.endswith(PARTIAL) and _is_partial(file := Path(place, name)):
                file.unlink(missing_ok=True)


def _is_of_creation(entry: Place) -> bool:
    """Whether something in a folder without a root is what a creation leaves that was cut short."""
    if _is_partial(entry):
        return True
    if variable_of(entry.name) is None or not entry.is_dir():
        return False
    return all(_is_partial(file) or _is_new(entry.name, file) for file in entry.iterdir())


def _is_new(name: str, file: Place) -> bool:
    """Whether a file of a variable is written before the root is."""
    if file.name != ROOT:
        return is_coordinate(name) and bool(_CHUNK.fullmatch(file.name))
    variable = variable_of(name)
    try:
        document = read_json(file)
        same = variable and document["attributes"]["long_name"] == variable.long_name
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False
    return bool(same) and document.get("node_type") == "array"


def _is_partial(file: Place) -> bool:
    """Whether a file was being written by this program."""
    return bool(_PARTIAL.fullmatch(file.name)) and not file.is_dir()

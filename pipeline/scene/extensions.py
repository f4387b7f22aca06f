"""What a scene may name beside one plane: logs, values of entries, rows of a table, unknown inputs.

Each is a module with a function ``begin``, loaded only where a scene names it: of this room, or
``entries`` of an extra. The function may add to the document before it is read, and returns what
makes the table of variants afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from pipeline import extras
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.sweep.model import Sweep
from pipeline.sweep.tables import entry_at


class Reading(NamedTuple):
    """What has been read of a scene when its table of variants is made."""

    document: Document
    scene: Any  # the file as it is declared
    faults: Faults


Extend = Callable[[Sweep, Reading], Sweep]
"""Gives a sweep the variants that its scene names."""
_NAMES = {
    "over": ("sweep.over",),
    "along": ("sweep.along",),
    "uncertain": ("unknown", "sweep.samples", "sweep.sample_seed"),
    "laboratory": ("measured", "tested"),
}
"""Modules and extras in the order in which they are asked, and the entries that name them."""


def begin(document: Document, faults: Faults) -> tuple[Document, list[Extend]]:
    """The document with what extensions add to it, and what they do to the sweep."""
    entries, extensions = document.entries(), list[Extend]()
    for name, paths in _NAMES.items():
        named = [path for path in paths if _is_named(entry_at(entries, path), path)]
        if not named:
            continue
        with faults.at(named[0]):
            document, extend = _module(name).begin(document, faults)
            extensions += [extend] if extend else []
            continue
        for path in paths:  # which nothing reads, so that no more is said of it
            document = document.replaced(path, None)
    return document, extensions


def _module(name: str) -> Any:
    is_extra = name in extras.EXTRAS
    return extras.module(name, "entries") if is_extra else import_module(f"pipeline.scene.{name}")


def _is_named(entry: Any, path: str) -> bool:
    """True if a scene has an entry; of tests, if a file stands for some."""
    if path in _NAMES["laboratory"]:
        listed = entry if isinstance(entry, list) else []
        return any(isinstance(test, dict) and "file" in test for test in listed)
    return entry is not None

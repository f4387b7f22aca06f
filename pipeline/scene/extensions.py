"""What a scene may name beside one plane: logs, values of entries, rows of a table, unknown inputs.

Each is a module with a function ``begin``, loaded only where a scene names it. The function may add
to the document before it is read, and returns what makes the table of variants afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, NamedTuple

from pipeline.scene.document import Document
from pipeline.scene.faults import Faults, entry_at
from pipeline.sweep.model import Sweep


class Reading(NamedTuple):
    """What has been read of a scene when its table of variants is made."""

    document: Document
    tables: dict[str, Any]  # of the format
    # Makes the sweep with other values of some entries, by their paths; raises their first fault.
    make: Callable[[Mapping[str, Any]], Sweep]
    faults: Faults


Extend = Callable[[Sweep, Reading], Sweep]
"""Gives a sweep the variants that its scene names."""
_NAMES = {
    "over": ("sweep.over",),
    "along": ("sweep.along", "sweep.around"),
    "distributions": ("unknown", "sweep.samples"),
}
_PLACES = {"distributions": "pipeline.uncertain.entries"}
"""Modules in the order in which they are asked, and the entries that name them."""


def begin(document: Document, faults: Faults) -> tuple[Document, list[Extend]]:
    """The document with what extensions add to it, and what they do to the sweep."""
    entries = document.entries()
    asked = [name for name, paths in _NAMES.items() if any(_has(entries, path) for path in paths)]
    extensions = list[Extend]()
    for name in [*asked, *(["logs"] if _has_log(entries) else [])]:
        document, extend = import_module(_PLACES.get(name, f"pipeline.scene.{name}")).begin(
            document, faults
        )
        extensions += [extend] if extend else []
    return document, extensions


def _has(entries: Mapping[str, Any], path: str) -> bool:
    return entry_at(dict(entries), path) is not None


def _has_log(entries: Mapping[str, Any]) -> bool:
    """True if a file stands for tests."""
    listed = [
        tests for key in ("measured", "tested") if isinstance(tests := entries.get(key), list)
    ]
    return any(isinstance(test, dict) and "file" in test for tests in listed for test in tests)

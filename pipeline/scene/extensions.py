"""What a scene may name beside one plane: logs, values of entries, rows of a table, unknown inputs.

Each is read by a module with a function ``begin``, loaded only where a scene names it: of this
room, or ``entries`` of an extra whose ``format`` finds its entries. The function may add to the
document before it is read, and returns what makes the table of variants afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from pipeline import extras
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.sweep.model import Sweep
from pipeline.sweep.tables import entry_at

Extend = Callable[[Sweep], Sweep]
"""Gives a sweep the variants that its scene names."""


def begin(document: Document, faults: Faults) -> tuple[Document, list[Extend]]:
    """The document with what extensions add to it, and what they do to the sweep."""
    extensions, entries = list[Extend](), document.entries()
    named = [([f"sweep.{name}"], f"pipeline.scene.{name}") for name in ("over", "along")]
    named += [(one.find(entries), f"{one.__package__}.entries") for one in extras.modules("format")]
    for paths, module in named:
        if not any(entry_at(entries, path) is not None for path in paths):
            continue
        with faults.at(paths[0]):
            document, extend = import_module(module).begin(document, faults)
            extensions += [extend] if extend else []
            continue
        for path in paths:  # which nothing reads, so that no more is said of it
            document = document.replaced(path, None)
    return document, extensions

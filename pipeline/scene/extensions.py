"""Extensions of a scene: entries with several values, operating points, logs.

Each is read by a module with a function ``begin``, imported only where a scene needs it: a module
of this package, or ``entries`` of an extra whose ``format`` finds its entries. ``begin`` may add to
the document before it is read, and returns the function that adds variants to the sweep.
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
"""Function that adds to a sweep the variants that its scene names."""


def begin(document: Document, faults: Faults) -> tuple[Document, list[Extend]]:
    """Let each extension change the document of a scene.

    Returns the document, and the functions that later add variants to the sweep. If an extension
    raises an error, a fault is added and its entries are removed from the document.
    """
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
        for path in paths:  # a faulty entry is removed, so that it has no further faults
            document = document.replaced(path, None)
    return document, extensions

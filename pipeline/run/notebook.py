"""The progress of a run in a notebook, where nobody asked for another report of it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


def in_notebook() -> bool:
    """True in a kernel of Jupyter."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


@contextmanager
def reported(
    progress: Callable[[Any], None] | None,
) -> Iterator[Callable[[Any], None] | None]:
    """Give the callable that was given; in a notebook without one, a line below the cell.

    The line is replaced, not added to: a notebook kept with its output has one line of a run.
    """
    if progress is not None or not in_notebook():
        yield progress
        return
    from IPython.display import display

    line = display(  # type: ignore[no-untyped-call]
        {"text/plain": "starting workers"}, raw=True, display_id=True
    )

    def show(progress: Any) -> None:
        line.update({"text/plain": str(progress)}, raw=True)

    yield show

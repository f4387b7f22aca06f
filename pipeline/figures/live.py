"""A figure of a sweep that is drawn again as its points come."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.figures.plot import plot
from pipeline.figures.points import PendingError
from pipeline.figures.style import figure_path
from pipeline.store.place import PathLike
from pipeline.store.progress import Summary, summary

_INTERVAL = 1.0  # [s] between two drawings at least
_SHARE = 2  # times the duration of a drawing between two, so that a run keeps its cores


def watch(
    store: PathLike,
    out: Path,
    kind: str,
    read: Callable[[], xr.Dataset],
    progress: Callable[[Summary], None],
    **options: Any,
) -> Summary:
    """Draw a figure into a file as the points of a store come, until its run in a process ends.

    The file is replaced whole each time. `read` gives the dataset to draw, `progress` is called
    after each drawing, and `options` are those of `pipeline.plot`. Returns the state at the end.
    """
    path, drawn = figure_path(out), None
    while True:
        state = summary(store)
        began = time.monotonic()
        if state.done + len(state.failed) != drawn:
            try:
                _replace(path, lambda beside: plot(read(), kind, beside, **options))
            except PendingError:
                if state.running is None:
                    raise
            else:
                drawn = state.done + len(state.failed)
                progress(state)
        if state.running is None and summary(store).done == state.done:
            return state
        time.sleep(max(_INTERVAL, _SHARE * (time.monotonic() - began)))


def _replace(path: Path, draw: Callable[[Path], Any]) -> None:
    """Draw beside a file, and put it in the file's place."""
    beside = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        draw(beside)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)

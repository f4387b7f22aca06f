"""The picture of a run, which another process draws as points come."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pipeline
from pipeline.cli.output import tell

if TYPE_CHECKING:
    from pipeline.run.tally import Progress

_LAST = 60.0  # [s] for the last drawing of a file, after the run


def require_screen(file: str | None) -> None:
    """Refuse a file that cannot be written or a window that cannot be opened, before the run."""
    if file:
        pipeline.figure_path(file)
    elif file is not None:
        from pipeline.figures.live import require_window  # with xarray

        require_window()


@contextmanager
def watched(
    file: str | None, store: Path | str, show: Callable[[Progress], None]
) -> Iterator[Callable[[Progress], None]]:
    """Report progress, and let another process draw the diagram from the first report on.

    It draws beside the run, whose schedule a drawing would hold up.

    Parameters
    ----------
    file : str or None
        File to draw into; empty for a window, None for no picture.
    store : path
        Store of the run, which is there when it first reports.
    show : callable
        Reports progress.
    """
    if file is None:
        yield show
        return
    drawing: list[subprocess.Popen[bytes]] = []

    def begin_and_show(progress: Progress) -> None:
        if not drawing:
            command = [sys.executable, "-m", "pipeline", "plot", str(store), "--watch", "-q"]
            command += ["-o", file] if file else []
            drawing.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))
        show(progress)

    yield begin_and_show
    if drawing and file:
        try:
            drawing[0].wait(_LAST)
        except subprocess.TimeoutExpired:
            tell(f"{file} is still being drawn")

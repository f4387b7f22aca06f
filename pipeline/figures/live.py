"""A figure of a sweep that is drawn again as its points come."""

from __future__ import annotations

import io
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.analysis.dataset import dataset_of
from pipeline.figures.plot import plot
from pipeline.figures.points import PendingError
from pipeline.figures.style import figure_path, png_of
from pipeline.store.place import PathLike
from pipeline.store.progress import Summary, summary
from tribo import InputError

_SHARE = 2  # times the duration of a drawing between two, so that a run keeps its cores


def watch(
    store: PathLike,
    out: str | Path | None = None,
    kind: str = "diagram",
    interval: float = 1.0,
    progress: Callable[[Summary], None] | None = None,
    read: Callable[[], xr.Dataset] | None = None,
    **options: Any,
) -> Summary:
    """Draw a figure of a sweep as its points come, until its run ends.

    The figure is shown in a notebook below the cell, or else in a window, which stays open at the
    end until it is closed; or written to a file, which is replaced whole each time. Points that are
    pending are marked as such.

    Parameters
    ----------
    store : str or path
        Path of the store, which a run in another process writes to.
    out : path, optional
        File to write in place of a window: .pdf, .png or .svg.
    kind : str
        Name of the figure; see `pipeline.plot`.
    interval : float
        Shortest time between two drawings [s].
    progress : callable, optional
        Called with the state of the sweep after each drawing.
    read : callable, optional
        Reads the dataset to draw, such as that at one value of an entry; the whole store if not
        given.
    **options
        Options of `pipeline.plot`.

    Returns
    -------
    Summary
        State of the sweep when its run had ended.

    Raises
    ------
    InputError
        If an option of the figure is faulty, or no window can be opened.
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> state = pipeline.watch("results/first_try.zarr", "results/live.png")
    >>> state.done, state.running
    (24, None)
    """
    if kind == "animation":
        raise InputError("an animation is not drawn as points come; give another kind of figure")
    screen = _screen(out)
    drawn = None
    while True:
        state = summary(store)
        began = time.monotonic()
        if state.done + len(state.failed) != drawn:
            try:
                screen.show(
                    lambda path: plot(read() if read else dataset_of(store), kind, path, **options)
                )
            except PendingError:
                if state.running is None:
                    raise
            else:
                drawn = state.done + len(state.failed)
                if progress:
                    progress(state)
        if state.running is None and summary(store).done == state.done:
            screen.end()
            return state
        screen.wait(max(interval, _SHARE * (time.monotonic() - began)))


class _File:
    """A file that holds the figure, and is replaced whole."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def wait(self, seconds: float) -> None:
        time.sleep(seconds)

    def end(self) -> None:
        pass

    def show(self, draw: Callable[[Path], Any]) -> None:
        beside = self._path.with_name(f".{self._path.stem}.{os.getpid()}{self._path.suffix}")
        try:
            draw(beside)
            beside.replace(self._path)
        finally:
            beside.unlink(missing_ok=True)


class _Notebook(_File):
    """A picture below the cell of a notebook."""

    def __init__(self) -> None:
        from IPython.display import display

        self._display: Any = display({"text/plain": "no figure yet"}, raw=True, display_id=True)  # type: ignore[no-untyped-call]

    def show(self, draw: Callable[[Any], Any]) -> None:
        self._display.update(draw(None))


class _Window(_File):
    """A window of matplotlib."""

    def __init__(self) -> None:
        require_window()
        from matplotlib import pyplot

        self._pyplot = pyplot
        self._figure = pyplot.figure("irg")

    def show(self, draw: Callable[[Any], Any]) -> None:
        picture = io.BytesIO(png_of(draw(None), self._figure.dpi))
        self._figure.clear()
        self._figure.figimage(self._pyplot.imread(picture), resize=True)

    def wait(self, seconds: float) -> None:
        self._pyplot.pause(seconds)
        if not self._pyplot.fignum_exists("irg"):
            raise KeyboardInterrupt

    def end(self) -> None:
        self._pyplot.show()


def require_window() -> None:
    """Refuse to open a window where matplotlib has no backend for one."""
    from matplotlib import pyplot
    from matplotlib.backends.registry import BackendFilter, backend_registry

    names = backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE)  # type: ignore[no-untyped-call]
    if pyplot.get_backend().lower() in names:
        raise InputError("no window can be opened here; give a file, such as diagram.png")


def _screen(out: str | Path | None) -> _File:
    """The file, the notebook or the window to draw on."""
    if out is not None:
        return _File(figure_path(out))
    return _Notebook() if "ipykernel" in sys.modules else _Window()

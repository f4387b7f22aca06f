"""Scenes and surfaces of the results."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import xarray as xr

from pipeline import Sweep, load_scene, open_sweep, run_sweep
from pipeline.cli.output import run_line
from pipeline.progress import Progress, Report, duration, silent
from pipeline.run.run_sweep import RunSummary
from pipeline.shipped import WORKFLOWS

T = TypeVar("T")

_SOON = 2.0  # [s] before which no time is predicted


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """Scenes of a result, and the work that may be spent on it.

    Attributes
    ----------
    scenes : path
        Folder of the scene files.
    results : path
        Folder of stores, as `irg run` fills it.
    preset : str or None
        Preset in place of the fidelity that the scene, or else the result, chooses.
    surfaces : int or None
        Number of random surfaces in place of each result's own.
    workers : int or None
        Number of workers of a sweep; one for each core if not given.
    progress : callable
        Called with a `Progress`, whose words say what comes next.
    """

    scenes: str | Path = WORKFLOWS
    results: str | Path = "results"
    preset: Any = None
    surfaces: int | None = None
    workers: int | None = None
    progress: Report = silent

    def tell(self, words: str) -> None:
        """Report in a line what is computed next."""
        self.progress(Progress(words))

    def scene(self, name: str, overrides: Mapping[str, Any] | None = None) -> Sweep:
        """Load the scene of this name, with its own fidelity or with the preset asked for."""
        path = Path(self.scenes, f"{name}.toml")
        return load_scene(path, preset=self.preset, overrides=overrides)

    def stages(
        self,
        items: Iterable[T],
        name: Callable[[T], str] = str,
        weight: Callable[[T], float] = lambda item: 1.0,
    ) -> Iterator[T]:
        """Yield `items` one after the other, and report each as a stage; see `with_progress`."""
        return with_progress(items, self.progress, name, weight)

    def sweep(
        self, sweep: Sweep, name: str, accuracy: float | None = None
    ) -> tuple[RunSummary, xr.Dataset]:
        """Run or resume a sweep in the store `name`; return its outcome and dataset.

        With `accuracy` only the points are computed that it takes, see `run_sweep`.
        """
        store = Path(self.results, f"{name}.zarr")
        self.tell(f"the sweep in {store}, including what is there already")
        with run_line() as progress:
            outcome = run_sweep(
                sweep,
                store,
                workers=self.workers,
                progress=progress,
                accuracy=accuracy,
            )
        return outcome, open_sweep(store)

    def seeds(self, usual: int) -> range:
        """Seeds of the random surfaces, as many as asked for, else `usual`."""
        return range(self.surfaces or usual)


def with_progress(
    items: Iterable[T],
    progress: Report,
    name: Callable[[T], str] = str,
    weight: Callable[[T], float] = lambda item: 1.0,
) -> Iterator[T]:
    """Yield items; before each, report its name, its number and the estimated time left.

    `name` returns the name of an item, and `weight` its relative duration.
    """
    everything = list(items)
    weights = [weight(item) for item in everything]
    began, total = time.monotonic(), len(everything)
    for number, item in enumerate(everything):
        done, left = sum(weights[:number]), sum(weights[number:])
        elapsed = time.monotonic() - began
        to_go = elapsed * left / done if done > 0 and elapsed >= _SOON else None
        rest = "" if to_go is None else f" (about {duration(to_go)} left)"
        count = f"{number + 1} of {total}: " if total > 1 else ""
        words = f"{count}{name(item)}{rest}"
        progress(Progress(words, number, total, elapsed=elapsed, time_to_go=to_go))
        yield item

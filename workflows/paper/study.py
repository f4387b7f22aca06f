"""Scenes and surfaces of the results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import xarray as xr

from pipeline import Sweep, load_scene, open_sweep, run_sweep
from pipeline.cli.output import run_line
from pipeline.run.sweep import Outcome
from pipeline.scene.shipped import WORKFLOWS
from pipeline.sweep.stages import Progress, Report, silent, staged

T = TypeVar("T")


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
        Fidelity in place of the one that the scene, or else the result, chooses.
    surfaces : int or None
        Number of random surfaces in place of each result's own.
    workers : int or None
        Number of workers of a sweep; one for each core if not given.
    progress : callable
        Called with a `Progress`, whose words say what comes next.
    """

    scenes: str | Path = WORKFLOWS
    results: str | Path = "results"
    preset: str | None = None
    surfaces: int | None = None
    workers: int | None = None
    progress: Report = silent

    def tell(self, words: str) -> None:
        """Tell in a line what comes next."""
        self.progress(Progress(words))

    def scene(self, name: str) -> Sweep:
        """The scene of this name, with its own fidelity or the one asked for."""
        return load_scene(Path(self.scenes, f"{name}.toml"), preset=self.preset)

    def stages(
        self,
        items: Iterable[T],
        name: Callable[[T], str] = str,
        weight: Callable[[T], float] = lambda item: 1.0,
    ) -> Iterator[T]:
        """Go through what is computed one after the other, and tell; see `staged`."""
        return staged(items, self.progress, name, weight)

    def sweep(self, sweep: Sweep, name: str) -> tuple[Outcome, xr.Dataset]:
        """Run or resume a sweep in the store of a name, with its progress on stderr."""
        store = Path(self.results, f"{name}.zarr")
        self.tell(f"the sweep in {store}, including what is there already")
        with run_line() as progress:
            outcome = run_sweep(sweep, store, workers=self.workers, progress=progress)
        return outcome, open_sweep(store)

    def seeds(self, usual: int) -> range:
        """Seeds of the random surfaces."""
        return range(self.surfaces or usual)

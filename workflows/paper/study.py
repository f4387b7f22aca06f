"""Scenes and surfaces of the results, and the end of a point."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import open_sweep
from pipeline.cli.progress import run_line
from pipeline.figures.style import celsius
from pipeline.run.sweep import Outcome, run_sweep
from pipeline.scene.scenefile import load_scene
from pipeline.scene.shipped import WORKFLOWS
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import contact_temperature, failed_fraction
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import staged
from tribo import InputError, Scene, State, measures, simulate
from tribo.criterion import Columns, columns_of

T = TypeVar("T")
WearPattern = Literal["swept", "local"]


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
    tell : callable
        Called with a line on what comes next.
    """

    scenes: str | Path = WORKFLOWS
    results: str | Path = "results"
    preset: str | None = None
    surfaces: int | None = None
    workers: int | None = None
    tell: Callable[[str], None] = lambda line: None

    def scene(self, name: str) -> Sweep:
        """The scene of this name, with its own fidelity or the one asked for."""
        return load_scene(Path(self.scenes, f"{name}.toml"), preset=self.preset)

    def scene_with_history(self, name: str) -> Sweep:
        """The scene of this name, with temperatures on the way also where a preset asks for none.

        A scene of its own asks for those that it wants to show; a preset for that at the end only.
        """
        sweep = self.scene(name)
        if self.preset is None:
            return sweep
        interval = max(1, sweep.fidelity.increments // 10)
        return replace(sweep, fidelity=replace(sweep.fidelity, temperature_interval=interval))

    def each(
        self,
        items: Iterable[T],
        name: Callable[[T], str] = str,
        weight: Callable[[T], float] = lambda item: 1.0,
    ) -> Iterator[T]:
        """Go through what is computed one after the other, and tell; see `staged`."""
        return staged(items, self.tell, name, weight)

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


@dataclass(frozen=True, slots=True)
class End:
    """The end of a point.

    Attributes
    ----------
    contact_width : float
        Between the outermost elements in contact [m].
    bearing_width : float
        Width of the rows of elements across the sliding direction that carry at least 5 % of
        what the most loaded one carries [m].
    rises : mapping
        Rises of the contact at friction 1 [K], as `tribo.criterion.columns_of` has them.
    """

    contact_width: float
    bearing_width: float
    rises: Columns

    def decisive_rise(self, conditions: Conditions) -> float:
        """Rise at friction 1 that decides [K]."""
        return float(conditions.decisive.rise(self.rises))

    def exceeded(self, conditions: Conditions) -> float:
        """Temperature that decides [°C]."""
        return float(celsius(contact_temperature(self.decisive_rise(conditions), conditions)))

    def highest(self, conditions: Conditions) -> float:
        """Highest temperature of the contact [°C]."""
        return self.exceeded(conditions.changed(share=0.0))

    def failed_fraction(self, conditions: Conditions) -> float:
        """Share of the contact area above the critical temperature."""
        return failed_fraction(self.rises["rise_quantile"], conditions)


def with_wear(sweep: Sweep, pattern: WearPattern) -> Sweep:
    """The scene with its wear in another pattern."""
    if sweep.wear is None:
        raise InputError(f"the scene {sweep.name} must have a [wear]")
    return replace(sweep, wear=replace(sweep.wear, pattern=pattern))


def end_of(scene: Scene, normal_load: float, velocity: float) -> End:
    """Simulate a point."""
    *_, state = simulate(scene, normal_load, velocity)
    return summary_of(scene, state)


def summary_of(scene: Scene, state: State) -> End:
    """Take from a state with temperature what is compared with the paper."""
    if state.heat is None:
        raise InputError("a point ended without a temperature")
    carried = state.pressure.mean(axis=1)
    bearing = np.count_nonzero(carried >= 0.05 * carried.max()) * scene.grid.spacing[0]
    rises = {name: np.array(rise) for name, rise in columns_of(state.heat).items()}
    return End(measures(scene, state)["contact_width"], float(bearing), rises)

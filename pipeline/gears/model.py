"""What the pipeline answers on places of mesh: the simulation of their rough, worn contact.

All that is asked of the rest of `pipeline` about temperatures and verdicts is asked here.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import pipeline
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.margin import NOT_DECIDED, told
from pipeline.analysis.margin_frame import Judged, judged
from pipeline.gears.contact import Mesh, MeshPlace
from pipeline.gears.scene import scene_toml
from pipeline.sweep.caveats import joined
from pipeline.sweep.stages import Report, silent

MILD, SEVERE = "mild", "severe"
_WORSE = ("", MILD, NOT_DECIDED, SEVERE)


@dataclass(frozen=True, slots=True)
class Simulated:
    """A simulated place of a mesh; of all the worst one."""

    mesh: Mesh
    place: MeshPlace
    temperature: float  #: That decides about severe wear [K].
    error: float  #: Numerical error of that temperature [K]; infinite where it is not known.
    verdict: str = ""  #: That of `pipeline.margin`; empty without a critical temperature.
    probability: float = 0.0  #: Probability that the next run is severe.
    notes: str | None = None  #: What a reader of the verdict must know.

    @property
    def distance(self) -> float:
        """Critical less deciding temperature [K]."""
        critical = self.mesh.pair.critical
        return math.nan if critical is None else critical - self.temperature

    @property
    def told(self) -> float:
        """The probability as a number, which is not told nearer to 0 or 1 than is known."""
        return told(self.probability)

    @property
    def rank(self) -> tuple[int, float, float]:
        """Key by which a worse place or duty is the larger one."""
        return _WORSE.index(self.verdict), self.probability, self.temperature

    @property
    def integral(self) -> float | None:
        """Integral temperature of the rule of the standard [K]; None without an oil."""
        rule = self.mesh.integral
        return None if rule is None else rule.integral


def decisive_places(one: Mesh) -> Mesh:
    """The mesh at the places that may decide: letters with sliding, and the hottest of its range.

    Rough flanks are hotter than smooth ones, by a factor that changes slowly along the path.
    """
    heat = [at.temperature for at in one.places]
    kept = (
        at
        for k, at in enumerate(one.places)
        if at.sliding and (at.letter or at.temperature == max(heat[max(k - 1, 0) : k + 2]))
    )
    return replace(one, places=tuple(kept))


def simulate(
    meshes: Sequence[Mesh],
    preset: str | None = None,
    workers: int | None = None,
    progress: Report = silent,
) -> list[Simulated]:
    """Simulate the places that may decide, and take the worst of each mesh.

    Without a critical temperature of the pair it is the hottest. A mesh whose teeth alone are above
    the critical temperature is severe, and is not simulated.

    Parameters
    ----------
    meshes : sequence of Mesh
        Of one pair at one duty or several.
    preset : str, optional
        Preset of the numerical choices; ``"standard"`` by default.
    workers : int, optional
        Number of processes; one for each core by default.
    progress : callable, optional
        See `pipeline.run_sweep`.

    Raises
    ------
    TriboError
        If a place cannot be simulated.
    """
    chosen = [decisive_places(one) for one in meshes if not _is_too_hot(one)]
    if not chosen:
        return [*map(_unsimulated, meshes)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh.toml"
        file.write_text(scene_toml(chosen), encoding="utf-8")
        sweep = pipeline.load_scene(file, preset)
        store = Path(folder) / "mesh.zarr"
        outcome = pipeline.run_sweep(sweep, store, workers, progress=progress)
        if outcome.failed:
            raise pipeline.ExecutionError(f"a place of mesh failed: {outcome.failed[0]}")
        rows = judged(pipeline.open_sweep(store), None)
        found = [[_simulated(one, place, next(rows)) for place in one.places] for one in chosen]
    worst = (max(places, key=attrgetter("rank")) for places in found)
    return [_unsimulated(one) if _is_too_hot(one) else next(worst) for one in meshes]


def _simulated(one: Mesh, place: MeshPlace, found: Judged) -> Simulated:
    """A place by its simulation; without a critical temperature it has no verdict."""
    field = found.field
    temperature = field.conditions.contact_temperature(
        decisive_rise(field.source, field.conditions).item()
    )
    (relative,) = field.errors(*found.place)
    error = relative.times(field.conditions.temperature_error(temperature)).total
    verdict: tuple[Any, ...] = ()
    if one.pair.critical is not None:
        margin = found.known()
        notes = *one.pair.caveats, *margin.caveats, f"the model's own error: {margin.model_error}"
        verdict = margin.verdict, margin.probability, joined(notes)
    return Simulated(one, place, temperature, math.inf if error is None else error, *verdict)


def _is_too_hot(one: Mesh) -> bool:
    """True if the teeth alone are as hot as the critical temperature."""
    return one.pair.critical is not None and one.duty.bulk >= one.pair.critical


def _unsimulated(one: Mesh) -> Simulated:
    """A mesh whose teeth alone are too hot, with the temperature of smooth flanks."""
    alone = "the teeth alone are above the critical temperature: not simulated"
    notes, hot = joined([*one.pair.caveats, alone]), one.hottest
    return Simulated(one, hot, hot.temperature, math.nan, SEVERE, 1.0, notes)

"""What the pipeline answers on places of mesh: the simulation of their rough, worn contact.

All that is asked of the rest of `pipeline` about temperatures and verdicts is asked here.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path

import pipeline
from pipeline.gears.contact import Mesh, MeshPlace
from pipeline.gears.scene import scene_toml
from pipeline.quantities import si_of
from pipeline.sweep.stages import Report, silent


@dataclass(frozen=True, slots=True)
class Simulated:
    """The hottest simulated place of a mesh, by the temperature that decides."""

    mesh: Mesh
    place: MeshPlace
    temperature: float  #: That decides about severe wear [K].
    error: float  #: Error of that temperature [K]; infinite where it is not known.

    @property
    def integral(self) -> float | None:
        """Integral temperature of the rule of the standard [K]; None without an oil."""
        rule = self.mesh.integral
        return None if rule is None else rule.integral


def decisive_places(one: Mesh) -> Mesh:
    """The mesh at the places that may decide: letters with sliding, and the hottest place.

    It has no critical temperature, which moves none of theirs, and may lie below the bulk.
    """
    kept = (at for at in one.places if at.sliding and (at.letter or at is one.hottest))
    return replace(one, places=tuple(kept), pair=one.pair.changed(critical=None))


def simulate(
    meshes: Sequence[Mesh],
    preset: str | None = None,
    workers: int | None = None,
    progress: Report = silent,
) -> list[Simulated]:
    """Simulate the places that may decide, and take the hottest of each mesh.

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
    chosen = [decisive_places(one) for one in meshes]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh.toml"
        file.write_text(scene_toml(chosen), encoding="utf-8")
        sweep = pipeline.load_scene(file, preset)
        store = Path(folder) / "mesh.zarr"
        outcome = pipeline.run_sweep(sweep, store, workers, progress=progress)
        if outcome.failed:
            raise pipeline.ExecutionError(f"a place of mesh failed: {outcome.failed[0]}")
        found = _decisive(store)
    return [
        max(
            (Simulated(one, place, *next(found)) for place in one.places),
            key=attrgetter("temperature"),
        )
        for one in chosen
    ]


def _decisive(store: Path) -> Iterator[tuple[float, float]]:
    """Temperatures that decide and their errors [K], of the rows of a store."""
    table = pipeline.margin(pipeline.at(store, critical_temperature=1000.0))
    temperatures = (si_of(one, "°C") for one in table["decisive temperature [°C]"].astype(float))
    errors = table["temperature error [K]"].astype(float).fillna(math.inf)
    return zip(temperatures, errors.tolist(), strict=True)

"""Temperatures at one point on ever finer grids, and with ever more increments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pipeline.sweep.model import Measurement, Sweep
from tribo import ConvergenceError, Fidelity, simulate, warnings
from tribo.types import Array
from workflows.paper.study import Study
from workflows.paper.transitions import HIGHEST, Ends, WearPattern, end_of, worn

_BLOCKS = (8, 6, 4, 3, 2, 1)  # pixels along a side of an element
_INCREMENTS = (20, 30, 40, 50, 75, 100, 150, 200)
PUBLISHED = 100  # increments
SCHEMES: dict[str, tuple[WearPattern, Mapping[str, Any]]] = {  # the latter of the fidelity
    "implicit, swept": ("swept", {"wear_scheme": "implicit"}),
    "explicit, swept": ("swept", {"wear_scheme": "explicit"}),
    "implicit, local": ("local", {"wear_scheme": "implicit"}),
    "explicit, local (as published)": ("local", {"wear_scheme": "explicit"}),
}

_PAPER = Fidelity(pixels_per_element=2, increments=PUBLISHED, averaging="mean")
"""The grid and the increments of the paper, on which each is varied alone."""

Row = dict[int, list[float]]
"""Temperatures over the surfaces [°C], by the number of elements along a side or of increments."""


@dataclass(frozen=True, slots=True)
class Steps:
    """Effect of the number of increments under a scheme of wear."""

    highest: Row
    unstable: dict[int, str]  # warnings of unstable steps, by the number of increments
    pressure: Array | None  # after the increments that are shown [Pa]


@dataclass(frozen=True, slots=True)
class Refinement:
    """Temperatures on other grids and with other steps, at one point."""

    sweep: Sweep
    measured: Measurement
    pictured: int  # increments of the pressure fields
    by_elements: dict[str, Row]
    by_increments: dict[str, Steps]

    @property
    def fields(self) -> dict[str, Array]:
        """Pressures after the increments that are pictured [Pa]."""
        items = self.by_increments.items()
        return {name: steps.pressure for name, steps in items if steps.pressure is not None}


def refined(study: Study) -> Refinement:
    """Simulate the paper's system at its highest measured load, on each grid, with each step."""
    sweep = study.scene("irg_transition")
    if study.preset is None:
        sweep = replace(sweep, fidelity=_PAPER)
    measured = max(sweep.measured, key=lambda entry: entry.normal_load)
    blocks = [n for n in _BLOCKS if study.preset is None or n >= sweep.fidelity.pixels_per_element]
    counts = [n for n in _INCREMENTS if study.preset is None or n <= 50]
    pictured = max(count for count in counts if count <= PUBLISHED)
    surfaces = [sweep.on_surface(seed) for seed in study.seeds(1)]
    by_elements: dict[str, Row] = {"maximum": {}, "10 %": {}, "one step": {}}
    sides = {sweep.pixels.shape[0] // block: block for block in blocks}
    for side in study.stages(sides, "{0} × {0} elements".format, weight=lambda side: side**2):
        for name, values in _on_grid(surfaces, sides[side], measured).items():
            by_elements[name][side] = values
    by_increments = {
        name: _with_steps(study, surfaces, name, counts, pictured, measured) for name in SCHEMES
    }
    return Refinement(sweep, measured, pictured, by_elements, by_increments)


def _on_grid(
    surfaces: Sequence[Sweep], block: int, measured: Measurement
) -> dict[str, list[float]]:
    """Temperatures with elements of so many pixels along each side [°C]."""
    elements = {"pixels_per_element": block, "history_coarsening": 1, "averaging": "mean"}
    scenes = [_with(surface, **elements) for surface in surfaces]
    ends = [end_of(scene, measured) for scene in scenes]
    single = [end_of(worn(scene, "unworn"), measured) for scene in scenes]
    decisive = scenes[0].conditions.decisive
    return {
        "maximum": [float(end.celsius(HIGHEST)) for end in ends],
        "10 %": [float(end.celsius(decisive)) for end in ends],
        "one step": [float(end.celsius(HIGHEST)) for end in single],
    }


def _with_steps(
    study: Study,
    surfaces: Sequence[Sweep],
    name: str,
    counts: Sequence[int],
    pictured: int,
    measured: Measurement,
) -> Steps:
    """Temperatures with a scheme of wear in each of several numbers of increments."""
    pattern, changes = SCHEMES[name]
    highest: Row = {}
    unstable: dict[int, str] = {}
    shown_pressure = None
    for count in study.stages(counts, (name + ", {} increments").format, weight=float):
        for surface in surfaces:
            steps = {"increments": count, "history_coarsening": 1, **changes}
            scene = _with(worn(surface, pattern), **steps)
            try:
                *_, state = simulate(scene, measured.normal_load, measured.velocity)
            except ConvergenceError as error:
                unstable[count] = str(error)
                continue
            end = Ends.of(scene, state, measured.friction)
            highest.setdefault(count, []).append(float(end.celsius(HIGHEST)))
            if pattern == "local" and count == pictured and surface is surfaces[0]:
                shown_pressure = state.pressure
            for warning in map(str, warnings(scene, state)):
                if "explicit" in warning:
                    unstable[count] = warning
    return Steps(highest, unstable, shown_pressure)


def _with(scene: Sweep, **changes: Any) -> Sweep:
    return replace(scene, fidelity=replace(scene.fidelity, **changes))

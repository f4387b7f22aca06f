"""Steps of a point that are stored: the times of its loading with results, its end last."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Literal

from tribo import MeasuredLoad, Scene, Stages
from tribo.loading import LoadStep

Steps = Literal["course", "end"]
"""Steps that are stored: all of them ("course"), or those that verdicts use ("end")."""
Fields = bool | Literal["steps"]
"""Whether fields of a point are stored: not (False), at its end (True), or at each stored step."""


@dataclass(frozen=True, slots=True)
class StoredSteps:
    """Which steps (times of the loading) of each point are stored."""

    steps: Steps
    # True if a hold is judged at each step: bodies warm while wear widens the contact.
    judges_hold: bool

    def heat_steps(self, scene: Scene, load: float) -> frozenset[int]:
        """Indices of the time steps at which to compute a temperature on the finest grid.

        The steps belong to the loading up to `load` [N], and to the time for which this load is
        held. The step that reaches the load, and the last step, may be missing from the set: their
        temperatures are always computed.
        """
        if isinstance(scene.loading, Stages):
            return frozenset()  # onset and end of each stage always have one
        load_steps = list(scene.all_load_steps(load))
        holding = [step for step in load_steps if step.holding]
        if self.steps == "course":
            shares_no_steps = isinstance(scene.loading, MeasuredLoad) or not scene.wears
            return frozenset(step.index for step in (load_steps if shares_no_steps else holding))
        return frozenset(step.index for step in holding) if self.judges_hold else frozenset()

    def select(self, scene: Scene, load: float) -> list[LoadStep]:
        """Load steps of a point at a load [N] that are stored; the last is the point's end.

        With load stages they are the onset and end of each stage.
        """
        if isinstance(scene.loading, Stages):
            return [step for step in scene.load_steps(load) if step.bounds_hold]
        heat_steps = self.heat_steps(scene, load)
        steps = list(scene.load_steps(load, heat_steps))
        return [
            step
            for step in steps
            if step is steps[-1]
            or step.index in heat_steps
            or (step.normal_load >= load and not step.holding)
            or self.steps == "course"
        ]


def least_load_evaluated(scene: Scene, load: float) -> float:
    """Least load at which a step can govern the verdict [N]: that of the point; 0 with stages."""
    return 0.0 if isinstance(scene.loading, Stages) else load


def ramp_of(scene: Scene) -> Hashable:
    """Key that is equal for scenes whose loadings have the same steps."""
    fidelity = scene.fidelity
    return scene.loading, fidelity.increments, fidelity.hold_increments, scene.wears

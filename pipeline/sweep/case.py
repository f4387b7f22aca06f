"""A case: one scene to simulate, and the conditions to judge it by."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.variants import Variant
from tribo import Oil, Scene


@dataclass(frozen=True, slots=True)
class Case:
    """One scene to simulate, and the conditions by which its points are judged.

    Attributes
    ----------
    name : tuple
        Labels along the dimensions of the sweep, as pairs (dimension, label); empty for the scene
        itself.
    scene : Scene
        The scene to simulate, with its numerical choices.
    conditions : Conditions
        Friction, temperatures and criterion.
    friction_band : pair of float or None
        Lowest and highest friction that the diagram shows.
    model_scatter : float or None
        Stated relative scatter of the model; None if not stated.
    lubricant : Oil or None
        The oil between the bodies, which does not affect simulations.
    preset : str or None
        Name of the preset that has the scene's numerical choices; None if there is none.
    """

    name: Variant
    scene: Scene
    conditions: Conditions
    friction_band: tuple[float, float] | None
    model_scatter: float | None
    lubricant: Oil | None
    preset: str | None

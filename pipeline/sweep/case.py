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
    model_bias, model_scatter : float
        How far the model may be off, as parts of the rise: shared by all specimens, and each one's
        own.
    lubricant : Oil or None
        The oil between the bodies, which does not affect simulations.
    preset : str or None
        Name of the preset that has the scene's numerical choices; None if there is none.
    """

    name: Variant
    scene: Scene
    conditions: Conditions
    friction_band: tuple[float, float] | None
    model_bias: float
    model_scatter: float
    lubricant: Oil | None
    preset: str | None

    @property
    def has_film(self) -> bool:
        """True if the film of an oil is judged: between line contacts, of an oil that is known."""
        oil = self.lubricant
        return bool(oil and oil.pressure_coefficients) and self.scene.pin.length is not None

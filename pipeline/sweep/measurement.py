"""Cases, each a scene with its conditions; and tests on rigs, each with a case of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from pipeline.sweep.conditions import Conditions
from pipeline.sweep.variants import Variant
from tribo import InputError, Oil, Scene

OUTCOMES = ("mild", "severe")
"""Outcomes of a test; a transition has none."""
Place = tuple[float, float]
"""Load [N] and velocity [m/s]."""
TEST = "test"
"""Dimension that numbers the tests of a scene in the names of their cases."""


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


@dataclass(frozen=True, slots=True)
class Measurement:
    """A test on a rig: a measured transition to severe wear, or a point with its outcome.

    `own` is the case of the test as it is simulated: the scene on its first surface, with what the
    test itself changes. Its conditions leave out the critical temperature: it is the oil's.
    """

    normal_load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    friction: float | None = None
    bulk_temperature: float | None = None  # the same in both bodies [K]
    hold: float | None = None  # at the full load [s]
    outcome: Literal["mild", "severe"] | None = None  # None at a transition
    number: str | None = None  # number or name in answers
    run: str | None = None  # shared by the tests of one specimen
    load_step: float = 0.0  # of a transition: wear was mild at this much less load [N]
    velocity_step: float = 0.0  # of a transition: wear was mild at this much less velocity [m/s]
    # Stages of the specimen, as declared; None for the loading of the scene.
    stages: Any = None
    # Other entries of the scene by path, as written.
    changes: Mapping[str, Any] = field(default_factory=dict, hash=False)
    own: Case | None = field(default=None, compare=False, repr=False)

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Load [N] and velocity [m/s] of each point of the test.

        There are two for a transition with a step: the last where wear was mild, and the first
        where it was severe.
        """
        here = self.normal_load, self.velocity
        before = self.normal_load - self.load_step, self.velocity - self.velocity_step
        return (here,) if before == here else (before, here)

    @property
    def simulated(self) -> Case:
        """The case to simulate, whose conditions have no critical temperature."""
        if self.own is None:
            raise InputError("this test belongs to no scene; take it from the tests of one")
        return self.own

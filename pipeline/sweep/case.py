"""Cases, each a scene with its conditions, and tests on rigs, each with its case.

Conditions act on stored results, after the simulation. Their entries in a scene, and limits that
follow from them, are here, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, Self

from pipeline.sweep.case_table import CaseName
from tribo import Conditions as Conditions
from tribo import Fidelity, InputError, Oil, Ramp, Scene, SelfAffineRoughness
from tribo.simulation import verdict

OUTCOMES = ("mild", "severe", "transition")
"""Outcomes of a test."""
OUTCOME_WORDS = {
    "ok": "mild", "pass": "mild", "passed": "mild",
    "fail": "severe", "failed": "severe", "scuffed": "severe", "seized": "severe",
}  # fmt: skip
"""Outcomes for words that laboratories write; a scene has the outcomes themselves."""
OperatingPoint = tuple[float, float]
"""Load [N] and velocity [m/s]."""
LARGEST = 1e15
"""Load [N] or velocity [m/s] at most; scenes have smaller ones."""
TEST = "test"
"""Dimension that numbers the tests of a scene in the names of their cases."""
OF_TESTS = "friction", "bulk_temperature", "corrections"
"""Conditions that each test sets; all others are those of the oil."""


TEMPERATURES = "temperature.bulk", "temperature.critical"
"""Inputs whose uncertainty is a temperature difference."""
CLOSED_FORM = ("friction.coefficient", *TEMPERATURES)
"""Inputs that act after the simulation, with sensitivities in closed form."""


class Uncertainty(NamedTuple):
    """Standard deviation that the inputs at some paths have in common: relative, or in K."""

    entries: tuple[str, ...]
    deviation: float


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
        Friction and temperatures.
    friction_band : pair of float or None
        Lowest and highest friction that the diagram shows.
    model_bias, model_scatter : float
        Model error as a fraction of the rise: common to all specimens, and differing between them.
    lubricant : Oil or None
        The oil between the bodies, which does not affect simulations.
    preset : str or None
        Name of the preset that has the scene's numerical choices; None if there is none.
    critical_from_tests : bool
        True if the critical temperature, which conditions then lack, is found by the tests.
    uncertainty : tuple of Uncertainty
        Standard deviations of inputs, which act after the simulation.
    includes_earlier_revolutions : bool
        True if the bulk temperature contains the heat of earlier revolutions of the bodies.
    bias_without_inputs : float
        The part of `model_bias` that no uncertain input explains.
    """

    name: CaseName
    scene: Scene
    conditions: Conditions
    friction_band: tuple[float, float] | None
    model_bias: float
    model_scatter: float
    lubricant: Oil | None
    preset: str | None
    critical_from_tests: bool = False
    uncertainty: tuple[Uncertainty, ...] = ()
    includes_earlier_revolutions: bool = False
    bias_without_inputs: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.model_bias <= 1 and 1e-3 <= self.model_scatter <= 1):
            raise InputError(
                f"model bias {self.model_bias} and scatter {self.model_scatter} are out of range; "
                "give 0 to 1, and 0.001 to 1"
            )

    @property
    def is_judged(self) -> bool:
        """True if there are verdicts: the critical temperature is known, or found by tests."""
        return self.conditions.critical_temperature is not None or self.critical_from_tests

    @property
    def has_film(self) -> bool:
        """True if its film is judged: a line contact, and an oil with a pressure coefficient."""
        oil = self.lubricant
        return bool(oil and oil.pressure_coefficient) and self.scene.pin.length is not None

    def on_surface(self, seed: int) -> Self:
        """The case on the random surface of another seed; unchanged without a random surface."""
        rough = self.scene.roughness
        if not isinstance(rough, SelfAffineRoughness):
            return self
        return replace(self, scene=replace(self.scene, roughness=replace(rough, seed=seed)))

    def with_hold(self, duration: float | None) -> Self:
        """The case with another hold at the full load [s], also for the heat of its tracks."""
        loading = self.scene.loading
        if duration is None or getattr(loading, "hold", None) == duration:
            return self
        if not isinstance(loading, Ramp):
            raise InputError(
                f"hold is {duration:g} s, but load records and load stages have their own "
                "duration; remove the hold, or use a loading with rate and reference_load"
            )
        loading = replace(loading, hold=duration)
        scene = replace(self.scene, loading=loading)
        return replace(self, scene=scene, conditions=self.conditions.with_loading(loading))

    def with_fidelity(self, fidelity: Fidelity, preset: str | None = None) -> Self:
        """The case with other numerical choices; `preset` is their name, or None."""
        return replace(self, scene=replace(self.scene, fidelity=fidelity), preset=preset)


@dataclass(frozen=True, slots=True)
class SpecimenTest:
    """A test on a rig: a point with its outcome, or with a transition to severe wear.

    Its case is the scene on its first surface, with the changes of the test. Its conditions have no
    critical temperature: that of the oil applies.
    """

    normal_load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    case: Case
    outcome: Literal["mild", "severe", "transition"] = "transition"
    number: str | None = None  # or name in answers; the same for both ends of a run by stages
    load_step: float = 0.0  # of a transition: wear was mild at this much less load [N]
    velocity_step: float = 0.0  # of a transition: wear was mild at this much less velocity [m/s]
    has_own_inputs: bool = False  # if its uncertain inputs err independently of the scene's

    def __post_init__(self) -> None:
        pairs = (self.normal_load, self.load_step), (self.velocity, self.velocity_step)
        if not all(0 <= step <= value <= LARGEST for value, step in pairs):
            raise InputError(f"a test of {self.points} has a step out of range, or no point")

    @property
    def points(self) -> tuple[OperatingPoint, ...]:
        """Load [N] and velocity [m/s] of each point of the test.

        There are two for a transition with a step: the last where wear was mild, and the first
        where it was severe.
        """
        end = self.normal_load, self.velocity
        step_before = self.normal_load - self.load_step, self.velocity - self.velocity_step
        return (end,) if step_before == end else (step_before, end)


VELOCITY_INPUT = "velocity"
"""Name of the sliding velocity among the inputs of `Variant`."""
INPUT_STEP = 1.1
"""Factor of an input, and its inverse, between which sensitivities are differences."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A point of a case with one input multiplied by a factor, for a sensitivity.

    With the velocity multiplied by 1 it is the point itself.
    """

    entry: str  # path of the input, or `VELOCITY_INPUT`
    value: float  # of the input in the scene [SI]
    unit: str  # in which the value is printed
    factor: float  # `INPUT_STEP`, its inverse, or 1
    load: float  # [N]
    velocity: float  # of the point whose sensitivity this is for [m/s]
    case: Case  # with the changed input
    of_case: CaseName = ()  # the case of the sweep, without its surface, that the point belongs to

    @property
    def point(self) -> OperatingPoint:
        """Load [N] and velocity [m/s] at which the sensitivity is."""
        return self.load, self.velocity

    @property
    def points(self) -> tuple[OperatingPoint, ...]:
        """Load [N] and velocity [m/s] of the one point to simulate."""
        is_velocity = self.entry == VELOCITY_INPUT
        return ((self.load, self.velocity * (self.factor if is_velocity else 1.0)),)


def known_critical_temperature(conditions: Conditions) -> float:
    """Critical temperature [K]; raises an `InputError` if it is not known."""
    if conditions.critical_temperature is None:
        raise InputError(
            "a critical temperature is needed; add one to the scene, such as critical = "
            '"145 degC" under [temperature], or use --critical-temperature '
            "(critical_temperature in Python)"
        )
    return conditions.critical_temperature


def allowable_rise(conditions: Conditions) -> float:
    """Temperature rise per unit friction coefficient above which wear is severe [K].

    It is infinite if the friction coefficient is 0. Raises an `InputError` if the critical
    temperature is not known.
    """
    known_critical_temperature(conditions)
    return verdict.allowable_rise(conditions)


def with_test_conditions(conditions: Conditions, test_conditions: Conditions) -> Conditions:
    """The `conditions` with those named in `OF_TESTS` taken from `test_conditions`."""
    return replace(conditions, **{name: getattr(test_conditions, name) for name in OF_TESTS})

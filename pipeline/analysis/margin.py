"""`Margin`: the verdict on an operating point, and its distance from severe wear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.analysis.film import OUTSIDE, OUTSIDE_WORDS
from pipeline.analysis.judge import NOT_DECIDED
from pipeline.analysis.rise_error import RiseError
from pipeline.constants import DECIDED, LEAST_STATED
from pipeline.quantities import display

_CHANGE = "a change of conditions or of the scene"
PASSED = "wear is severe at lower loads at this velocity, through which a ramp passes"
"""Caveat on an operating point where wear is mild, but severe at lower loads."""
AT_EDGE = "the contact touches the window's edge at the points used here: give more window.pixels"
"""Caveat on an operating point whose temperature comes from contacts wider than the window."""


@dataclass(frozen=True, slots=True)
class Margin:
    """The verdict on an operating point, and its distances from severe wear.

    The distances are the critical temperature minus the contact temperature that the criterion
    compares with it (``distance``), critical velocity over velocity (``velocity_factor``), and
    critical load over load (``load_factor``). They are computed, untouched by tests. Beyond the
    computed velocities the temperature rise is extrapolated as a power of the velocity.

    Examples
    --------
    >>> import pipeline
    >>> here = pipeline.margin("results/first_try.zarr", "400 N", "1.4 m/s")
    >>> here.verdict, here.probability < 0.01
    ('mild', True)
    """

    load: float  #: Normal load on the whole pin [N].
    velocity: float  #: Sliding velocity [m/s].
    #: Friction, bulk and critical temperature by which the point is judged, in words.
    conditions: str
    probability: float  #: Probability that wear is severe in a further run.
    lowest: float  #: This probability if the numerical error makes contacts colder.
    highest: float  #: This probability if the numerical error makes contacts hotter.
    #: Contact temperature that the criterion compares with the critical temperature [K].
    deciding_temperature: float
    error: RiseError  #: Numerical error of `deciding_temperature` by its parts [K].
    critical_temperature: float  #: Temperature above which the lubricant fails [K].
    distance: float  #: Critical temperature minus `deciding_temperature` [K]; < 0 if severe.
    model_error: str  #: How far the model may be off, and by how many tests, in words.
    #: Lowest velocity at this load at which wear turns severe [m/s], computed. NaN if the sweep has
    #: none, or if wear is severe at the lowest velocity.
    critical_velocity: float
    tested_velocity: float  #: Velocity at this load at which severe wear is 50 % likely [m/s].
    critical_load: float  #: Lowest load at this velocity at which wear turns severe [N], or NaN.
    velocity_outcome: str  #: Why there is no critical velocity, or ranges of severe wear.
    load_outcome: str  #: Why there is no critical load, or ranges of severe wear.
    is_computed: bool  #: True if the sweep has computed this point, so nothing is interpolated.
    is_outside: bool  #: True if an oil film carries more than a fifth of the load.
    is_continued: bool  #: True if the temperature is extrapolated beyond the computed points.
    patches: int  #: Number of patches of the specimen, over which the rise is a mean.
    not_mild: str = ""  #: Which tests forbid a mild verdict here, in words.
    not_severe: str = ""  #: Which tests forbid a severe verdict here, in words.
    tested: tuple[str, ...] = ()  #: Tests of the scene at or near the operating point, in words.
    caveats: tuple[str, ...] = ()  #: Limits of the verdict, one line each.
    #: Values of entries that vary in the sweep, by dimension [SI].
    entries: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        """Verdict on a further run: mild, severe, not decided, or outside the model."""
        if self.is_outside:
            return OUTSIDE
        verdict = verdict_between(self.lowest, self.highest)
        return NOT_DECIDED if self.against else verdict

    @property
    def against(self) -> str:
        """Why the verdict by probability does not hold, in words; empty if it does."""
        if self.is_outside:
            return ""
        reasons = {"mild": self.not_mild, "severe": self.not_severe}
        return reasons.get(verdict_between(self.lowest, self.highest), "")

    @property
    def temperature_error(self) -> float | None:
        """Numerical error of `deciding_temperature` [K]; None if a part is unknown."""
        return self.error.total

    @property
    def surface_error(self) -> float | None:
        """Part of `temperature_error` that more patches of the surface would reduce [K]."""
        return self.error.surface

    @property
    def velocity_factor(self) -> float:
        """Critical velocity at the point's load, divided by the velocity; NaN if unknown."""
        return self.critical_velocity / self.velocity

    @property
    def load_factor(self) -> float:
        """Critical load at the point's velocity, divided by the load; NaN if unknown."""
        return self.critical_load / self.load

    @property
    def decided_by(self) -> str | None:
        """What would decide an undecided verdict, such as "a test at this point"; else None."""
        if self.verdict != NOT_DECIDED or self.against:
            return None
        if verdict_between(*[self.probability] * 2) == NOT_DECIDED:  # at any error
            return _CHANGE if self.tested else "a test at this point"
        measured = "its numerical error, which is known for a preset"
        parts = {
            "more points near it": self.error.interpolation,
            measured if self.error.preset is None else "a finer preset": self.error.preset,
            "what its warnings ask for": self.error.warned,
            "more patches (sweep.realizations)": self.error.surface,
        }
        sizes = {kind: math.inf if part is None else part for kind, part in parts.items()}
        return max(sizes, key=lambda kind: sizes[kind])

    @property
    def sentence(self) -> str:
        """Sentence that states the verdict and the probability of severe wear.

        The sentence also states the distance [K] from the critical temperature, and the tests near
        the operating point with their outcomes, if there are any.
        """
        side = "below" if self.distance >= 0 else "above"
        within = _within(self.lowest, self.highest)
        within = ", numerical error not known" if self.error.total is None else within
        likely = f"severe wear is {percent(self.probability)} likely{within}"
        where = f"{abs(self.distance):.3g} K {side} the critical temperature"
        if self.is_outside:
            heat = f"the contact is at {display(self.deciding_temperature, '°C', 4)}"
            return f"{OUTSIDE_WORDS[:1].upper()}{OUTSIDE_WORDS[1:]}; {heat}"
        tests = f"; tested there: {', '.join(self.tested)}" if self.tested else ""
        return f"{self.verdict.capitalize()}: {likely}, {where}{tests}"


def _within(lowest: float, highest: float) -> str:
    """Ends of a probability in words, such as " (3 to 12 %)"; empty if they read alike."""
    low, high = percent(lowest), percent(highest)
    if low == high:
        return ""
    if lowest < LEAST_STATED:
        return f" (at most {high})" if highest <= 1 - LEAST_STATED else " (0 to 100 %)"
    is_open = highest > 1 - LEAST_STATED
    return f" (at least {low})" if is_open else f" ({low.removesuffix(' %')} to {high})"


def verdict_between(lowest: float, highest: float) -> str:
    """Verdict from the lowest and highest probability of severe wear within numerical error."""
    if highest <= DECIDED[0]:
        return "mild"
    return "severe" if lowest >= DECIDED[-1] else NOT_DECIDED


def percent(probability: float) -> str:
    """A probability in words: a percentage, or "less than 1 %"."""
    if probability < LEAST_STATED:
        return f"less than {100 * LEAST_STATED:g} %"
    if probability > 1 - LEAST_STATED:
        return f"more than {100 * (1 - LEAST_STATED):g} %"
    return f"{100 * probability:.2g} %"

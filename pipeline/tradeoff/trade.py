"""Speed against accuracy, measured on a scene at a few points on the boundary.

What counts is the error of the boundary velocity: that of the logarithm of the rise, divided by the
exponent with which the rise grows with velocity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from pipeline.analysis.tables import as_dict, frame_of, lines_of
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import in_si
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.severity import rise_limit
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Report, silent, staged
from pipeline.sweep.variants import Variants
from pipeline.tradeoff.probe import (
    Probe,
    Target,
    dividing_pixels,
    near_the_boundary,
    probe,
    some_places,
    velocity_errors,
)
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

_USUAL = ("draft", "standard", "fine")
_LOADS = 4
_BOUNDS = (0.05, 0.03, 0.02, 0.01, 0.005)  # errors, for each of which the cheapest is named
_HEADS = "name", "velocity error [%]", "seconds [s]", "share of fine"


@dataclass(frozen=True, slots=True)
class Choice:
    """One fidelity against the reference."""

    name: str  # a preset's, or "as in the scene"
    fidelity: Fidelity
    velocity_errors: tuple[float, ...]  # relative, of the boundary at each point, with sign
    velocity_error: float  # largest at any point, without sign
    seconds: float  # processor time of the points [s]
    share_of_fine: float | None = None  # time over that of preset fine, if measured


@shown
@dataclass(frozen=True, slots=True)
class Trade:
    """Speed and accuracy of numerical choices on a scene."""

    drawn_by: ClassVar = "pipeline.figures.studies:draw_trade"
    title: str  #: Title of the scene.
    points: tuple[Point, ...]  #: Points at which the errors are measured.
    choices: tuple[Choice, ...]  #: Fidelities that were measured, the reference last.
    not_converged: tuple[str, ...] = ()  #: Choices that did not converge, and why.

    @property
    def reference(self) -> Choice:
        """The choice that the others are compared with."""
        return self.choices[-1]

    @property
    def front(self) -> tuple[Choice, ...]:
        """Choices that no other one beats in both time and error, the fastest first."""
        best, choices = math.inf, []
        by_time = sorted(self.choices, key=lambda one: (one.seconds, one.velocity_error))
        for choice in by_time:
            if choice.velocity_error < best:
                best = choice.velocity_error
                choices.append(choice)
        return tuple(choices)

    def cheapest(self, error: float) -> Choice:
        """The fastest choice whose boundary velocity errs by no more than `error`."""
        return min(
            (choice for choice in self.choices if choice.velocity_error <= error),
            key=lambda choice: choice.seconds,
        )

    @property
    def table(self) -> pd.DataFrame:
        """Error and time of the choices, one in a row."""
        names = as_dict(pd.DataFrame(columns=[*_HEADS]))
        return frame_of(_HEADS, ([getattr(one, name) for name in names] for one in self.choices))

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return asdict(self) | {
            "points": [{"load": point.load, "velocity": point.velocity} for point in self.points],
            "front": [choice.name for choice in self.front],
            "cheapest_within": {f"{bound:g}": self.cheapest(bound).name for bound in _BOUNDS},
        }

    def __str__(self) -> str:
        places = ", ".join(f"{point.load:g} N {point.velocity:.3g} m/s" for point in self.points)
        lines = [
            f"{self.title}: speed against accuracy at",
            f"  {places}",
            "",
            *lines_of(self.table),
            "",
            "Largest error of the boundary velocity at these points, against the reference on the",
            "same pixels, and processor time of the points. --accuracy adds a margin for other",
            "points.",
            "",
            *(
                f"cheapest within {100 * bound:g} %: {self.cheapest(bound).name}"
                for bound in _BOUNDS
            ),
            *(f"no result: {reason}" for reason in self.not_converged),
        ]
        return "\n".join(lines)


@np.errstate(under="ignore")
def trade(
    sweep: SceneLike,
    presets: Sequence[str] = _USUAL,
    loads: Sequence[float | str] | None = None,
    progress: Report | None = None,
) -> Trade:
    """Measure speed against accuracy on a scene.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene to measure, or its path or name; its own fidelity is one of the choices, unless it
        is a preset.
    presets : sequence of str
        Presets to compare with ``reference``.
    loads : sequence of float or str, optional
        Loads at which to look at the boundary [N], or text with a unit; four of the sweep's if
        not given.
    progress : callable, optional
        Called before each choice with a `Progress`, whose words name it.

    Raises
    ------
    InputError
        If a preset is unknown, or the sweep has no friction heat.
    ConvergenceError
        If the reference does not converge.

    Examples
    --------
    >>> import pipeline
    >>> print(pipeline.trade("first_try", presets=["draft"]))  # doctest: +SKIP
    """
    sweep = sweep_of(sweep)
    for name in presets:
        if name not in PRESETS:
            raise InputError(f"preset {name!r} is unknown; known are {', '.join(PRESETS)}")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("friction is 0, so there is no boundary; give one above 0")
    asked = [Target(in_si("load", load, "600 N")) for load in loads or ()]
    asked = asked or [*some_places(sweep.changed(variants=Variants()), _LOADS)]
    places, exponents = near_the_boundary(sweep, asked)
    stages = staged(
        [*_candidates(sweep, presets).items()],
        progress or silent,
        name=lambda stage: stage[0],
        weight=lambda stage: _work(stage[1]),
    )
    _, exact = next(stages)
    reference = probe(sweep, exact, places, is_timed=True)
    choices, failed = [], []
    for name, fidelity in stages:
        try:
            tried = probe(sweep, fidelity, places, is_timed=True)
        except ConvergenceError as error:
            failed.append(f"{name}: {error}")
        else:
            choices.append(_choice(name, tried, reference, exponents))
    choices.append(_choice("reference", reference, reference, exponents))
    fine = next((one.seconds for one in choices if one.name == "fine"), None)
    if fine:
        choices = [replace(one, share_of_fine=one.seconds / fine) for one in choices]
    return Trade(
        title=sweep.about.title,
        points=places,
        choices=tuple(choices),
        not_converged=tuple(failed),
    )


def _work(fidelity: Fidelity) -> float:
    """Steps times elements for each pixel, about."""
    coarse = fidelity.increments / fidelity.history_coarsening**2
    return (coarse + 1) / fidelity.pixels_per_element**2


def _candidates(sweep: Sweep, presets: Sequence[str]) -> dict[str, Fidelity]:
    """Fidelities to measure, by their names: the reference first, each once."""
    named = {name: dividing_pixels(sweep, PRESETS[name]) for name in ("reference", *presets)}
    if sweep.about.preset is None:
        named["as in the scene"] = sweep.scene.fidelity
    names: dict[Fidelity, str] = {}
    for name, fidelity in named.items():
        names.setdefault(fidelity, name)
    return {name: fidelity for fidelity, name in names.items()}


def _choice(name: str, measured: Probe, reference: Probe, exponents: Sequence[float]) -> Choice:
    """A choice against the reference."""
    errors = velocity_errors(measured.readings, reference.readings, exponents)
    return Choice(
        name=name,
        fidelity=measured.fidelity,
        velocity_errors=errors,
        velocity_error=max(map(abs, errors)),
        seconds=measured.seconds,
    )

"""Table of fidelities, each measured on a scene at a few points on the boundary.

A fidelity is a set of numerical choices. The measure is the relative error of the critical
velocity: the error of ln(rise) divided by the exponent with which the rise grows with velocity.
`irg trade` prints the table.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from pipeline.analysis.tables import frame_of, lines_of
from pipeline.constants import DEVIATIONS, LARGEST_TIMES, OF_ONE_ELEMENT, OF_REFERENCE
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.written import with_fidelity
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.selection import Choice, presets_for
from pipeline.sweep.severity import boundary_velocity_error, rise_limit
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report, silent, staged
from pipeline.tradeoff.forecast import as_computed
from pipeline.tradeoff.probe import (
    Probe,
    Target,
    points_near_boundary,
    probe,
    spread_places,
)
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

USUAL = ("standard", "fine")
OWN = "the scene's own fidelity"
_LOADS, _PLACES = 4, 6  # number of points for a single variant, and for several
_HEADS = "name", "velocity error [%]", "error at any load [%]", "seconds [s]"


@shown
@dataclass(frozen=True, slots=True)
class Trade:
    """Speed and accuracy of several fidelities on a scene."""

    drawn_by: ClassVar = "pipeline.figures.studies:draw_trade"
    title: str  #: Title of the scene.
    points: tuple[Point, ...]  #: Points at which the errors are measured.
    choices: tuple[Choice, ...]  #: Fidelities measured, in order of their work; the reference last.
    not_converged: tuple[str, ...] = ()  #: Fidelities that did not converge, with the reason.

    @property
    def reference(self) -> Choice:
        """The fidelity with which all other fidelities are compared."""
        return self.choices[-1]

    @property
    def front(self) -> tuple[Choice, ...]:
        """Pareto front, the fastest first: no other fidelity is both faster and more accurate."""
        best, choices = math.inf, []
        by_time = sorted(self.choices, key=lambda one: (one.seconds, one.velocity_error))
        for choice in by_time:
            if choice.velocity_error < best:
                best = choice.velocity_error
                choices.append(choice)
        return tuple(choices)

    @property
    def table(self) -> pd.DataFrame:
        """Frame with a row for each fidelity: two errors [%], and two times.

        The errors are those of the critical velocity: the largest at the points measured, and the
        error to expect at any load. One time is in seconds, the other is relative to the time of
        the preset ``fine``, or NaN if ``fine`` was not measured.
        """
        names = [head.partition(" [")[0].replace(" ", "_") for head in _HEADS]
        table = frame_of(_HEADS, ([getattr(one, name) for name in names] for one in self.choices))
        fine = next((one.seconds for one in self.choices if one.name == "fine"), math.nan)
        table["share of fine"] = table["seconds [s]"] / fine
        return table

    def __str__(self) -> str:
        places = ", ".join(f"{point.load:g} N {point.velocity:.3g} m/s" for point in self.points)
        lines = [
            f"{self.title}: speed against accuracy at",
            f"  {places}",
            "",
            *lines_of(self.table),
            "",
            "Largest error of the boundary velocity at these points, against the reference on the",
            "same pixels; error to expect at any load, with margin; processor time of all points.",
            *(f"no result: {reason}" for reason in self.not_converged),
        ]
        return "\n".join(lines)


@np.errstate(under="ignore")
def trade(
    sweep: SceneLike, presets: Sequence[str] = USUAL, progress: Report | None = None
) -> Trade:
    """Measure how long simulations take with several fidelities, and how large their errors are.

    A fidelity is a set of numerical choices, such as a preset. An error is the relative difference
    of the scene's critical velocity from that with the preset ``reference``.

    Errors are measured near the boundary, at up to four loads from the lowest to the highest; with
    several variants, at up to six pairs of load and variant.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene to measure, or its path or name; its own fidelity is measured, too.
    presets : sequence of str
        Presets to measure against the preset ``reference``.
    progress : callable, optional
        Called with a `Progress` that names each fidelity.

    Raises
    ------
    InputError
        If a preset is unknown, or the sweep has no friction heat.
    ConvergenceError
        If the reference does not converge.

    Examples
    --------
    >>> import pipeline
    >>> print(pipeline.trade("first_try", presets=["standard"]))  # doctest: +SKIP
    """
    sweep = sweep_of(sweep)
    for name in presets:
        if name not in PRESETS:
            raise InputError(f"preset {name!r} is unknown; give one of {', '.join(PRESETS)}")
    progress = progress or silent
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("friction is 0, so there is no boundary; give a friction above 0")
    places = spread_places(sweep, _PLACES if len(sweep.variants.names) > 1 else _LOADS)
    candidates = _candidates(sweep, presets)
    progress(Progress(f"{len(candidates)} choices at {len(places)} place{'s' * (len(places) > 1)}"))
    near, exponents = points_near_boundary(sweep, places)
    stages = staged(
        [*candidates.items()],
        progress,
        name=lambda stage: stage[0],
        weight=lambda stage: _cost(sweep, stage[1], places),
    )
    _, exact = next(stages)
    reference = probe(sweep, exact, near)
    choices, failed = [], []
    for name, fidelity in stages:
        try:
            tried = probe(sweep, fidelity, near)
        except ConvergenceError as error:
            failed.append(f"{name}: {error}")
        else:
            choices.append(_choice(name, tried, reference, exponents))
    # By work, not time, so that the choice is the same on every machine.
    choices.sort(key=lambda choice: _cost(sweep, choice.fidelity, places))
    choices.append(_choice("reference", reference, reference, exponents))
    return Trade(sweep.title, near, tuple(choices), tuple(failed))


def _cost(sweep: Sweep, fidelity: Fidelity, places: Sequence[Target]) -> float:
    """Cost of simulating the targets `places`, in steps on a grid of single-pixel elements.

    A step with larger elements costs less, in proportion to the number of elements of its grid.
    """
    scene = as_computed(with_fidelity(sweep, fidelity))
    before = sum(step_count(scene, place.load) - 1 for place in places)
    steps = before / scene.coarsening**2 + len(places)
    return float(steps / scene.fidelity.pixels_per_element**2)


def _candidates(sweep: Sweep, presets: Sequence[str]) -> dict[str, Fidelity]:
    """Fidelities to measure, by name: the preset ``reference``, `presets`, and the sweep's own.

    Equal fidelities are listed once, under the first name.
    """
    named = presets_for(sweep.scene, ("reference", *presets))
    named.setdefault(sweep.preset or OWN, sweep.scene.fidelity)
    names: dict[Fidelity, str] = {}
    for name, fidelity in named.items():
        names.setdefault(fidelity, name)
    return {name: fidelity for fidelity, name in names.items()}


def _choice(name: str, measured: Probe, reference: Probe, exponents: Sequence[float]) -> Choice:
    """Compare a fidelity with the reference: errors of the critical velocity, and processor time.

    `name` is the name of the fidelity, which is a set of numerical choices. `measured` has the
    fidelity's rises at some points, and `reference` those of the reference. `exponents` are
    d ln(rise)/d ln(velocity) at each point.
    """
    pairs = zip(measured.rises, reference.rises, exponents, strict=True)
    errors = tuple(boundary_velocity_error(*pair) for pair in pairs)
    largest = max(map(abs, errors))
    spread = statistics.stdev(errors) if len(errors) > 2 else 0.0
    elsewhere = max(LARGEST_TIMES * largest, abs(statistics.mean(errors)) + DEVIATIONS * spread)
    return Choice(
        name=name,
        fidelity=measured.fidelity,
        velocity_errors=errors,
        velocity_error=largest,
        error_at_any_load=elsewhere + OF_REFERENCE + OF_ONE_ELEMENT / reference.fewest_nodes,
        seconds=measured.seconds,
    )

"""Speed against accuracy, measured on a scene at a few points on the boundary.

What counts is the error of the boundary velocity: that of the logarithm of the rise, divided by the
exponent with which the rise grows with velocity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

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
_SAVES, _MOVES = 1.1, 0.002  # a choice is wasted that saves so much, and moves so little
_BOUNDS = (0.05, 0.03, 0.02, 0.01, 0.005)  # errors, for each of which the cheapest is named
_HEADS = (
    "name", "velocity error [%]", "rise error [%]", "width error [%]", "share error",
    "area error [%]", "pressure error [%]", "saturated error", "seconds [s]", "speedup", "saving",
    "convolutions", "peak bytes [MB]",
)  # fmt: skip
_OF_PROBE = "fidelity", "seconds", "convolutions", "work", "peak_bytes"


@dataclass(frozen=True, slots=True)
class Choice:
    """One fidelity against the reference."""

    name: str  # a preset's, or what is varied in it
    varied: str | None  # field of the fidelity
    fidelity: Fidelity
    velocity_errors: tuple[float, ...]  # relative, of the boundary at each point, with sign
    # Largest at any point, without sign: relative, but for the failed share.
    velocity_error: float
    rise_error: float
    width_error: float
    share_error: float
    # Largest of what the size of the elements decides, with sign: contact fraction and mean
    # pressure, relative, and share of the contact at the hardness.
    area_error: float
    pressure_error: float
    saturated_error: float
    seconds: float  # processor time of the points [s]
    convolutions: int
    work: float  # convolutions times the elements of their grids
    peak_bytes: int | None  # most memory that arrays took at a point [B]
    speedup: float  # factors by which the reference takes more time, and more work
    saving: float


@dataclass(frozen=True, slots=True)
class Wasted:
    """A numerical choice that costs much and gains nothing."""

    preset: str
    field: str  # field of the fidelity
    value: Any  # that the preset has
    cheaper: Any  # value that would do
    saving: float  # factor by which it takes less work
    moves: float  # largest relative change of the boundary velocity by it

    def __str__(self) -> str:
        return (
            f"{self.field} = {_shown(self.value)} of {self.preset!r}: with {_shown(self.cheaper)} "
            f"the work is {self.saving:.2g} times less, and the boundary moves by "
            f"{100 * self.moves:.2f} %"
        )


@shown
@dataclass(frozen=True, slots=True)
class Trade:
    """Speed and accuracy of numerical choices on a scene."""

    drawn_by: ClassVar = "pipeline.figures.studies:draw_trade"
    title: str  #: Title of the scene.
    points: tuple[Point, ...]  #: Points at which the errors are measured.
    base: str  #: Preset that was varied.
    choices: tuple[Choice, ...]  #: Fidelities that were measured, the reference last.
    wasted: tuple[Wasted, ...]  #: Choices of the base that cost much and gain nothing.
    not_converged: tuple[str, ...] = ()  #: Choices that did not converge, and why.

    @property
    def reference(self) -> Choice:
        """The choice that the others are compared with."""
        return self.choices[-1]

    @property
    def front(self) -> tuple[Choice, ...]:
        """Choices that no other one beats in both work and error, the cheapest first."""
        best, choices = math.inf, []
        for choice in sorted(self.choices, key=lambda choice: (choice.work, choice.velocity_error)):
            if choice.velocity_error < best:
                best = choice.velocity_error
                choices.append(choice)
        return tuple(choices)

    def cheapest(self, error: float) -> Choice:
        """The choice of least work whose boundary velocity errs by no more than `error`."""
        return min(
            (choice for choice in self.choices if choice.velocity_error <= error),
            key=lambda choice: choice.work,
        )

    @property
    def table(self) -> pd.DataFrame:
        """Cost and errors of the choices, one in a row."""
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
            "Largest errors at these points: of boundary velocity, decisive rise, contact width",
            "and failed share; and of contact area, mean pressure and share of the contact at the",
            "hardness, which the size of the elements decides. All are against the reference on",
            "the same pixels, without the margin for other points that --accuracy adds.",
            "",
            *(
                f"cheapest within {100 * bound:g} %: {self.cheapest(bound).name}"
                for bound in _BOUNDS
            ),
            *(f"wasted: {finding}" for finding in self.wasted),
            *(f"no result: {reason}" for reason in self.not_converged),
        ]
        return "\n".join(lines)


def _shown(value: Any) -> str:
    """A value for printing."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def trade(
    sweep: SceneLike,
    presets: Sequence[str] = _USUAL,
    base: str | None = "fine",
    loads: Sequence[float | str] | None = None,
    progress: Report | None = None,
    own_laws: bool = False,
) -> Trade:
    """Measure speed against accuracy on a scene.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene to measure, or its path or name; its own fidelity is one of the choices, unless it
        is a preset.
    presets : sequence of str
        Presets to compare with ``reference``.
    base : str, optional
        Preset whose numerical choices are varied, one at a time. None for none.
    loads : sequence of float or str, optional
        Loads at which to look at the boundary [N], or text with a unit; four of the sweep's if
        not given.
    progress : callable, optional
        Called before each choice with a `Progress`, whose words name it.
    own_laws : bool
        See `pipeline.load_scene`.

    Raises
    ------
    InputError
        If a preset is unknown, or the sweep has no friction heat.
    ConvergenceError
        If the reference does not converge.

    Examples
    --------
    >>> import pipeline
    >>> print(pipeline.trade("first_try", presets=["draft"], base=None))  # doctest: +SKIP
    """
    sweep = sweep_of(sweep, own_laws)
    named = (*presets, *([base] if base else []))
    for name in named:
        if name not in PRESETS:
            raise InputError(f"preset {name!r} is unknown; known are {', '.join(PRESETS)}")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("friction is 0, so there is no boundary; give one above 0")
    asked = [Target(in_si("load", load, "600 N")) for load in loads or ()]
    asked = asked or [*some_places(sweep.changed(variants=Variants()), _LOADS)]
    places, exponents = near_the_boundary(sweep, asked)
    stages = staged(
        _candidates(sweep, named, base),
        progress or silent,
        name=lambda stage: stage[0],
        weight=lambda stage: _work(stage[2]),
    )
    _, _, exact = next(stages)
    reference = probe(sweep, exact, places, with_memory=True)
    choices, failed = [], []
    for name, varied, fidelity in stages:
        try:
            tried = probe(sweep, fidelity, places, with_memory=True)
        except ConvergenceError as error:
            failed.append(f"{name}: {error}")
        else:
            choices.append(_choice(name, varied, tried, reference, exponents))
    choices.append(_choice("reference", None, reference, reference, exponents))
    return Trade(
        title=sweep.about.title,
        points=places,
        base=base or "",
        choices=tuple(choices),
        wasted=_wasted(choices, base),
        not_converged=tuple(failed),
    )


def _work(fidelity: Fidelity) -> float:
    """Steps times elements for each pixel, about."""
    coarse = fidelity.increments / fidelity.history_coarsening**2
    return (coarse + 1) / fidelity.pixels_per_element**2


def _candidates(
    sweep: Sweep, presets: Sequence[str], base: str | None
) -> list[tuple[str, str | None, Fidelity]]:
    """Name, varied field and fidelity of all that is to be measured, the reference first.

    Each fidelity stands there once, with its first name.
    """
    candidates: list[tuple[str, str | None, Fidelity]] = [
        (name, None, dividing_pixels(sweep, PRESETS[name])) for name in ("reference", *presets)
    ]
    if sweep.about.preset is None:
        candidates.append(("as in the scene", None, sweep.scene.fidelity))
    if base:
        start = dividing_pixels(sweep, PRESETS[base])
        for field, values in _variations(start, sweep.scene.unequal_bulks).items():
            for value in values:
                changed = dividing_pixels(sweep, replace(start, **{field: value}))
                candidates.append((f"{base}, {field} = {_shown(value)}", field, changed))
    first: dict[Fidelity, tuple[str, str | None, Fidelity]] = {}
    for candidate in candidates:
        first.setdefault(candidate[2], candidate)
    return [*first.values()]


def _variations(start: Fidelity, unequal_bulks: bool) -> dict[str, tuple[Any, ...]]:
    """Values to try of each field alone, as far as they go with unequal bulk temperatures."""
    block, coarsening = start.pixels_per_element, start.history_coarsening
    steps = start.increments
    return {
        "pixels_per_element": (2 * block, 4 * block),
        "averaging": ("mean", "sample") if block > 1 else (),
        "history_coarsening": (max(1, coarsening // 2), 2 * coarsening, 4 * coarsening),
        "increments": (*sorted({max(1, steps // 10), max(1, steps // 4), 2 * steps}),),
        "wear_scheme": ("implicit", "sdirk2"),
        "contact_tolerance": (
            float(f"{start.contact_tolerance / 30:.0e}"), min(1.0, start.contact_tolerance * 10)
        ),
        "partition": () if unequal_bulks else ("uniform",),
        "heat_tolerance": (start.heat_tolerance / 100, min(0.1, start.heat_tolerance * 100)),
        "kernel": ("nearest-image",),
    }  # fmt: skip


def _choice(
    name: str, varied: str | None, measured: Probe, reference: Probe, exponents: Sequence[float]
) -> Choice:
    """A choice against the reference."""
    errors = velocity_errors(measured.readings, reference.readings, exponents)

    def largest(name: str, relative: bool = True) -> float:
        """Largest error of a value at any point, with its sign."""
        readings = zip(measured.readings, reference.readings, strict=True)
        pairs = ((getattr(one, name), getattr(true, name)) for one, true in readings)
        off = (one / true - 1 if relative else one - true for one, true in pairs)
        return float(max(off, key=abs))

    return Choice(
        name=name,
        varied=varied,
        velocity_errors=errors,
        velocity_error=max(map(abs, errors)),
        rise_error=abs(largest("rise")),
        width_error=abs(largest("contact_width")),
        share_error=abs(largest("failed_share", relative=False)),
        area_error=largest("contact_fraction"),
        pressure_error=largest("mean_pressure"),
        saturated_error=largest("saturated_fraction", relative=False),
        **{name: getattr(measured, name) for name in _OF_PROBE},
        speedup=reference.seconds / max(measured.seconds, 1e-9),
        saving=reference.work / max(measured.work, 1.0),
    )


def _wasted(choices: Sequence[Choice], base: str | None) -> tuple[Wasted, ...]:
    """Choices of the base that cost much and gain nothing, the costliest of each field first."""
    start = next((choice for choice in choices if choice.name == base), None)
    if start is None:
        return ()
    costliest: dict[str, Wasted] = {}
    for choice in sorted(choices, key=lambda choice: choice.work):
        saving = start.work / choice.work
        pairs = zip(choice.velocity_errors, start.velocity_errors, strict=True)
        moves = max(abs(one - other) for one, other in pairs)
        if choice.varied and saving >= _SAVES and moves <= _MOVES:
            value, cheaper = (getattr(one.fidelity, choice.varied) for one in (start, choice))
            found = Wasted(start.name, choice.varied, value, cheaper, saving, moves)
            costliest.setdefault(choice.varied, found)
    return tuple(costliest.values())

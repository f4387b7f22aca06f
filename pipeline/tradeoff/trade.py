"""Speed against accuracy, measured on a scene.

The presets, and every numerical choice of one of them varied alone, are compared with the
reference at a few points on the boundary, each simulated from the start. What counts is the error
of the boundary velocity: that of the logarithm of the rise, divided by the exponent with which the
rise grows with velocity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import in_si
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import staged
from pipeline.sweep.variants import Variants
from pipeline.tradeoff.probe import (
    Probe,
    Target,
    near_the_boundary,
    on_pixels,
    probe,
    some_places,
    velocity_errors,
)
from pipeline.tradeoff.table import Choice, Finding, Trade, shown
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

_USUAL = ("draft", "standard", "fine")
_LOADS = 4
_SAVES, _MOVES = 1.1, 0.002  # a choice is wasted that saves so much, and moves so little


def trade(
    sweep: SceneLike,
    presets: Sequence[str] = _USUAL,
    base: str | None = "fine",
    loads: Sequence[float | str] | None = None,
    progress: Callable[[str], None] | None = None,
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
        Preset of which every numerical choice is varied alone; None for none.
    loads : sequence of float or str, optional
        Loads at which to look at the boundary [N], or text with a unit; four of the sweep's if
        not given.
    progress : callable, optional
        Called before each choice with a line: which it is, of how many, and the time to go.
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
    for name in (*presets, *([base] if base else [])):
        if name not in PRESETS:
            raise InputError(f"preset {name!r} is unknown; known are {', '.join(PRESETS)}")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("friction is 0, so there is no boundary; give one above 0")
    without_surfaces = sweep.changed(variants=Variants())
    asked = tuple(in_si("load", load, "600 N") for load in loads or ())
    asked = asked or tuple(place.load for place in some_places(without_surfaces, _LOADS))
    places, exponents = near_the_boundary(sweep, [Target(load) for load in asked])
    exact = on_pixels(sweep, PRESETS["reference"])
    candidates = _candidates(sweep, presets, base)
    stages = staged(
        [("reference", None, exact), *candidates],
        progress,
        name=lambda stage: stage[0],
        weight=lambda stage: _work(stage[2]),
    )
    next(stages)
    reference = probe(sweep, exact, places, with_memory=True)

    def choice(name: str, varied: str | None, measured: Probe) -> Choice:
        errors = velocity_errors(measured.readings, reference.readings, exponents)
        return _choice(name, varied, measured, reference, errors)

    choices, failed = [], []
    for name, varied, fidelity in stages:
        try:
            tried = probe(sweep, fidelity, places, with_memory=True)
        except ConvergenceError as error:
            failed.append(f"{name}: {error}")
        else:
            choices.append(choice(name, varied, tried))
    choices.append(choice("reference", None, reference))
    return Trade(
        title=sweep.about.title,
        points=places,
        base=base or "",
        choices=tuple(choices),
        wasted=_wasted(choices, base, on_pixels(sweep, PRESETS[base])) if base else (),
        not_converged=tuple(failed),
    )


def _work(fidelity: Fidelity) -> float:
    """Steps times elements for each pixel, about."""
    coarse = fidelity.increments / fidelity.history_coarsening**2
    return (coarse + 1) / fidelity.pixels_per_element**2


def _candidates(
    sweep: Sweep, presets: Sequence[str], base: str | None
) -> list[tuple[str, str | None, Fidelity]]:
    """Name, varied field and fidelity of all that is to be measured, each fidelity once."""
    candidates: list[tuple[str, str | None, Fidelity]] = [
        (name, None, on_pixels(sweep, PRESETS[name])) for name in presets if name != "reference"
    ]
    if base and base not in presets:
        candidates.append((base, None, on_pixels(sweep, PRESETS[base])))
    fidelity = sweep.scene.fidelity
    if sweep.about.preset is None:
        candidates.append(("as in the scene", None, fidelity))
    if base:
        start = on_pixels(sweep, PRESETS[base])
        for field, values in _variations(start, sweep.scene.unequal_bulks).items():
            for value in values:
                changed = on_pixels(sweep, replace(start, **{field: value}))
                candidates.append((f"{base}, {field} = {shown(value)}", field, changed))
    unique: dict[Fidelity, tuple[str, str | None, Fidelity]] = {}
    for candidate in candidates:
        unique.setdefault(candidate[2], candidate)
    unique.pop(on_pixels(sweep, PRESETS["reference"]), None)
    return list(unique.values())


def _variations(start: Fidelity, unequal_bulks: bool) -> dict[str, tuple[Any, ...]]:
    """Values to try of each field alone, as far as they go with unequal bulk temperatures."""
    block, coarsening = start.pixels_per_element, start.history_coarsening
    return {
        "pixels_per_element": (2 * block, 4 * block),
        "averaging": ("mean", "sample") if block > 1 else (),
        "history_coarsening": (max(1, coarsening // 2), 2 * coarsening, 4 * coarsening),
        "increments": (start.increments // 10, start.increments // 4, 2 * start.increments),
        "wear_scheme": ("implicit", "sdirk2"),
        "contact_tolerance": (
            float(f"{start.contact_tolerance / 30:.0e}"), start.contact_tolerance * 10
        ),
        "partition": () if unequal_bulks else ("uniform",),
        "heat_tolerance": (start.heat_tolerance / 100, start.heat_tolerance * 100),
        "kernel": ("nearest-image",),
        "precision": ("single",),
    }  # fmt: skip


def _choice(
    name: str, varied: str | None, measured: Probe, reference: Probe, errors: tuple[float, ...]
) -> Choice:
    """A choice against the reference, with its errors of the boundary velocity."""

    def largest(name: str, relative: bool = True) -> float:
        """Largest error of a value at any point, with its sign."""
        readings = zip(measured.readings, reference.readings, strict=True)
        pairs = ((getattr(one, name), getattr(true, name)) for one, true in readings)
        errors = [one / true - 1 if relative else one - true for one, true in pairs]
        return float(max(errors, key=abs))

    return Choice(
        name=name,
        varied=varied,
        fidelity=measured.fidelity,
        velocity_errors=errors,
        velocity_error=max(map(abs, errors)),
        rise_error=abs(largest("rise")),
        width_error=abs(largest("contact_width")),
        share_error=abs(largest("failed_share", relative=False)),
        area_error=largest("contact_fraction"),
        pressure_error=largest("mean_pressure"),
        saturated_error=largest("saturated_fraction", relative=False),
        seconds=measured.seconds,
        convolutions=measured.convolutions,
        work=measured.work,
        peak_bytes=measured.peak_bytes,
        speedup=reference.seconds / max(measured.seconds, 1e-9),
        saving=reference.work / max(measured.work, 1.0),
    )


def _wasted(choices: Sequence[Choice], base: str, start: Fidelity) -> tuple[Finding, ...]:
    """Choices of the base that cost much and gain nothing, the costliest first."""
    base_choice = next((choice for choice in choices if choice.name == base), None)
    if base_choice is None:
        return ()
    findings = []
    for choice in choices:
        saving = base_choice.work / choice.work
        pairs = zip(choice.velocity_errors, base_choice.velocity_errors, strict=True)
        moves = max(abs(one - other) for one, other in pairs)
        if choice.varied and saving >= _SAVES and moves <= _MOVES:
            value, cheaper = (getattr(one, choice.varied) for one in (start, choice.fidelity))
            findings.append(Finding(base, choice.varied, value, cheaper, saving, moves))
    findings.sort(key=lambda finding: -finding.saving)
    costliest: dict[str, Finding] = {}
    for finding in findings:
        costliest.setdefault(finding.field, finding)
    return tuple(costliest.values())

"""Speed against accuracy, measured on a scene.

The presets, and every numerical choice of one of them varied alone, are compared with the
reference: at a few points on the boundary, each one simulated from the start, or on a whole small
diagram. What counts is the error of the boundary velocity. At a point on the boundary it is the
error of the logarithm of the rise, divided by the exponent with which the rise grows with
velocity; in a diagram, that of the crossing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from pipeline.analysis.interpolation import crossing
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Point, Sweep
from pipeline.tradeoff.probe import (
    Probe,
    fitted,
    near_the_boundary,
    probe,
    some_loads,
)
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

__all__ = ["Choice", "Finding", "Trade", "trade"]

_USUAL = ("draft", "standard", "fine")
_LOADS = 4
_DIAGRAM_VELOCITIES = 5
_SAVES, _MOVES = (
    1.1,
    0.002,
)  # a choice is wasted that saves as much and moves the boundary so little


@dataclass(frozen=True, slots=True)
class Choice:
    """One fidelity against the reference.

    Attributes
    ----------
    name : str
        A preset, or what is varied of one.
    varied : str or None
        Field of the fidelity that is varied; None if it is a preset as it is.
    fidelity : Fidelity
        All of the numerical choices.
    velocity_errors : tuple of float
        Relative error of the boundary velocity at each load, with its sign.
    velocity_error, rise_error, width_error, share_error : float
        Largest errors at any point, without sign: of the boundary velocity, the decisive rise and
        the contact width, relative; and of the failed share.
    seconds : float
        Processor time of the points [s].
    convolutions : int
        Convolutions of contacts and of heat.
    work : float
        Convolutions times the elements of their grids.
    peak_bytes : int or None
        Most memory that arrays took at a point [B].
    speedup, saving : float
        How many times less time, and less work, than the reference takes.
    """

    name: str
    varied: str | None
    fidelity: Fidelity
    velocity_errors: tuple[float, ...]
    velocity_error: float
    rise_error: float
    width_error: float
    share_error: float
    seconds: float
    convolutions: int
    work: float
    peak_bytes: int | None
    speedup: float
    saving: float


@dataclass(frozen=True, slots=True)
class Finding:
    """A numerical choice that costs much and gains nothing.

    Attributes
    ----------
    preset, field : str
        Name of the preset, and of the field of its fidelity.
    value, cheaper : object
        Value that the preset has, and a cheaper one that would do.
    saving : float
        How many times less work the cheaper value takes.
    moves : float
        Largest relative change of the boundary velocity by the cheaper value.
    """

    preset: str
    field: str
    value: Any
    cheaper: Any
    saving: float
    moves: float

    def __str__(self) -> str:
        return (
            f"{self.field} = {_shown(self.value)} of {self.preset!r}: with {_shown(self.cheaper)} "
            f"the work is {self.saving:.2g} times less, and the boundary moves by "
            f"{100 * self.moves:.2f} %"
        )


@dataclass(frozen=True, slots=True)
class Trade:
    """What speed costs in accuracy on a scene.

    Attributes
    ----------
    title : str
        Title of the scene.
    points : tuple of Point
        Points at which the errors are measured.
    base : str
        Preset that was varied.
    choices : tuple of Choice
        Fidelities that were measured, the reference last.
    wasted : tuple of Finding
        Choices of the base that cost much and gain nothing.
    not_converged : tuple of str
        Choices that did not converge, and why.
    """

    title: str
    points: tuple[Point, ...]
    base: str
    choices: tuple[Choice, ...]
    wasted: tuple[Finding, ...]
    not_converged: tuple[str, ...] = ()

    @property
    def reference(self) -> Choice:
        """What the others are compared with."""
        return self.choices[-1]

    @property
    def front(self) -> tuple[Choice, ...]:
        """Choices that no other beats both in work and in error, the cheapest first."""
        best, found = math.inf, []
        for choice in sorted(self.choices, key=lambda choice: (choice.work, choice.velocity_error)):
            if choice.velocity_error < best:
                best = choice.velocity_error
                found.append(choice)
        return tuple(found)

    def cheapest(self, error: float) -> Choice:
        """The choice of least work whose boundary velocity errs by no more than `error`."""
        return min(
            (choice for choice in self.choices if choice.velocity_error <= error),
            key=lambda choice: choice.work,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return asdict(self) | {
            "points": [{"load": at.load, "velocity": at.velocity} for at in self.points],
            "front": [choice.name for choice in self.front],
            "cheapest_within": {
                f"{bound:g}": self.cheapest(bound).name for bound in (0.05, 0.03, 0.02, 0.01, 0.005)
            },
        }

    def __str__(self) -> str:
        places = ", ".join(f"{at.load:g} N {at.velocity:.3g} m/s" for at in self.points)
        loads = sorted({at.load for at in self.points})
        velocities = sorted({at.velocity for at in self.points})
        if len(velocities) < len(self.points):  # a diagram
            places = (
                f"{', '.join(f'{load:g}' for load in loads)} N, "
                f"{', '.join(f'{velocity:.3g}' for velocity in velocities)} m/s"
            )
        rows = [_HEADER, *map(_row, self.choices)]
        lines = [
            f"{self.title}: speed against accuracy at",
            f"  {places}",
            "",
            *rows,
            "",
            *(
                f"cheapest within {100 * bound:g} %: {self.cheapest(bound).name}"
                for bound in (0.05, 0.03, 0.02, 0.01, 0.005)
            ),
            *(f"wasted: {finding}" for finding in self.wasted),
            *(f"no result: {reason}" for reason in self.not_converged),
        ]
        return "\n".join(lines)


def trade(
    sweep: Sweep,
    presets: Sequence[str] = _USUAL,
    base: str | None = "fine",
    loads: Sequence[float] | None = None,
    diagram: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Trade:
    """Measure speed against accuracy on a scene.

    Parameters
    ----------
    sweep : Sweep
        Scene to measure; its own fidelity is one of the choices, unless it is a preset.
    presets : sequence of str
        Presets to compare with ``reference``.
    base : str, optional
        Preset of which every numerical choice is varied alone; None for none.
    loads : sequence of float, optional
        Loads at which to look at the boundary [N]; four of the sweep's if not given.
    diagram : bool
        Whether to compare small diagrams instead of single points.
    progress : callable, optional
        Called with the name of each choice before it is computed.

    Raises
    ------
    InputError
        If a preset is unknown, or the sweep has no friction heat.
    ConvergenceError
        If the reference does not converge.
    """
    for name in (*presets, *([base] if base else [])):
        if name not in PRESETS:
            raise InputError(f"preset {name!r} is unknown; known are {', '.join(PRESETS)}")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("without friction there is no heat, and no boundary to be wrong about")
    asked = tuple(loads) if loads else some_loads(sweep, _LOADS)
    boundary_points, exponents = near_the_boundary(sweep, asked)
    places = _around(boundary_points) if diagram else boundary_points
    tell = progress or (lambda name: None)

    tell("reference")
    reference = probe(sweep, fitted(sweep, PRESETS["reference"]), places, with_memory=True)
    compare = _Comparison(sweep, places, exponents, asked if diagram else None, reference)
    found, failed = [], []
    for name, varied, fidelity in _candidates(sweep, presets, base):
        tell(name)
        try:
            measured = probe(sweep, fidelity, places, with_memory=True)
        except ConvergenceError as error:
            failed.append(f"{name}: {error}")
        else:
            found.append(compare.choice(name, varied, measured))
    found.append(compare.choice("reference", None, reference))
    return Trade(
        title=sweep.title,
        points=tuple(places),
        base=base or "",
        choices=tuple(found),
        wasted=_wasted(found, base, fitted(sweep, PRESETS[base])) if base else (),
        not_converged=tuple(failed),
    )


def _around(points: Sequence[Point]) -> tuple[Point, ...]:
    """A small diagram about points on the boundary: every load at velocities across them."""
    velocities = [point.velocity for point in points]
    axis = np.geomspace(0.8 * min(velocities), 1.25 * max(velocities), _DIAGRAM_VELOCITIES)
    return tuple(Point(point.load, float(velocity)) for point in points for velocity in axis)


def _candidates(
    sweep: Sweep, presets: Sequence[str], base: str | None
) -> list[tuple[str, str | None, Fidelity]]:
    """Name, varied field and fidelity of all that is to be measured, each fidelity once."""
    found: list[tuple[str, str | None, Fidelity]] = [
        (name, None, fitted(sweep, PRESETS[name])) for name in presets if name != "reference"
    ]
    if base and base not in presets:
        found.append((base, None, fitted(sweep, PRESETS[base])))
    own = replace(sweep.fidelity, temperature_interval=0)
    if sweep.preset is None:
        found.append(("as in the scene", None, own))
    if base:
        start = fitted(sweep, PRESETS[base])
        for field, values in _variations(start).items():
            for value in values:
                changed = fitted(sweep, replace(start, **{field: value}))
                found.append((f"{base}, {field} = {_shown(value)}", field, changed))
    seen = {fitted(sweep, PRESETS["reference"])}
    unique = []
    for entry in found:
        if entry[2] not in seen:
            seen.add(entry[2])
            unique.append(entry)
    return unique


def _variations(start: Fidelity) -> dict[str, tuple[Any, ...]]:
    """Values to try of each field alone."""
    block, coarsening = start.pixels_per_element, start.history_coarsening
    return {
        "pixels_per_element": (2 * block, 4 * block),
        "averaging": ("mean", "sample") if block > 1 else (),
        "history_coarsening": (max(1, coarsening // 2), 2 * coarsening, 4 * coarsening),
        "increments": (start.increments // 10, start.increments // 4, 2 * start.increments),
        "wear_scheme": ("sdirk2",),
        "contact_tolerance": (_round(start.contact_tolerance / 30), start.contact_tolerance * 10),
        "partition": ("uniform",),
        "heat_tolerance": (start.heat_tolerance / 100, start.heat_tolerance * 100),
        "kernel": ("nearest-image",),
        "precision": ("single",),
    }


@dataclass(frozen=True, slots=True)
class _Comparison:
    """Errors against the reference.

    `loads` are those of a diagram, whose points lie velocity by velocity at each of them.
    """

    sweep: Sweep
    points: Sequence[Point]
    exponents: Sequence[float]
    loads: Sequence[float] | None
    reference: Probe

    def choice(self, name: str, varied: str | None, measured: Probe) -> Choice:
        pairs = list(zip(measured.readings, self.reference.readings, strict=True))
        errors = self._velocity_errors(measured)
        return Choice(
            name=name,
            varied=varied,
            fidelity=measured.fidelity,
            velocity_errors=errors,
            velocity_error=max(map(abs, errors)),
            rise_error=max(abs(one.rise / true.rise - 1) for one, true in pairs),
            width_error=max(abs(one.contact_width / true.contact_width - 1) for one, true in pairs),
            share_error=max(abs(one.failed_share - true.failed_share) for one, true in pairs),
            seconds=measured.seconds,
            convolutions=measured.convolutions,
            work=measured.work,
            peak_bytes=measured.peak_bytes,
            speedup=self.reference.seconds / max(measured.seconds, 1e-9),
            saving=self.reference.work / max(measured.work, 1.0),
        )

    def _velocity_errors(self, measured: Probe) -> tuple[float, ...]:
        if self.loads is None:
            return tuple(
                boundary_velocity_error(one.rise, true.rise, exponent)
                for one, true, exponent in zip(
                    measured.readings, self.reference.readings, self.exponents, strict=True
                )
            )
        ours, theirs = self._crossings(measured), self._crossings(self.reference)
        if all(map(math.isnan, theirs)):
            raise InputError("the reference has no transition between these velocities")
        return tuple(
            math.inf if math.isnan(one) else one / true - 1
            for one, true in zip(ours, theirs, strict=True)
            if not math.isnan(true)
        )

    def _crossings(self, measured: Probe) -> list[float]:
        rows: dict[float, list[tuple[float, float]]] = {}
        for point, reading in zip(self.points, measured.readings, strict=True):
            rows.setdefault(point.load, []).append((point.velocity, reading.rise))
        limit = rise_limit(self.sweep.conditions)
        pairs = (np.array(row).T for row in rows.values())
        return [crossing(velocities, rises, limit) for velocities, rises in pairs]


def _wasted(choices: Sequence[Choice], base: str, start: Fidelity) -> tuple[Finding, ...]:
    """Choices of the base that cost much and gain nothing, the costliest first."""
    own = next((choice for choice in choices if choice.name == base), None)
    if own is None:
        return ()
    found: dict[str, Finding] = {}
    for choice in choices:
        if choice.varied is None:
            continue
        saving = own.work / choice.work
        moves = max(
            abs(one - other)
            for one, other in zip(choice.velocity_errors, own.velocity_errors, strict=True)
        )
        known = found.get(choice.varied)
        if saving >= _SAVES and moves <= _MOVES and (known is None or known.saving < saving):
            found[choice.varied] = Finding(
                base,
                choice.varied,
                getattr(start, choice.varied),
                getattr(choice.fidelity, choice.varied),
                saving,
                moves,
            )
    return tuple(sorted(found.values(), key=lambda finding: -finding.saving))


def _round(value: float) -> float:
    return float(f"{value:.0e}")


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


_HEADER = (
    f"{'choice':38} {'velocity':>9} {'rise':>7} {'width':>7} {'share':>7} "
    f"{'time':>9} {'faster':>7} {'less work':>9} {'conv.':>6} {'memory':>7}"
)


def _row(choice: Choice) -> str:
    memory = f"{choice.peak_bytes / 1e6:.0f} MB" if choice.peak_bytes else ""
    return (
        f"{choice.name:38} {_percent(choice.velocity_error):>9} {_percent(choice.rise_error):>7} "
        f"{_percent(choice.width_error):>7} {choice.share_error:7.3f} {choice.seconds:7.3f} s "
        f"{choice.speedup:7.3g} {choice.saving:9.3g} {choice.convolutions:6d} {memory:>7}"
    )


def _percent(value: float) -> str:
    return f"{100 * value:.2f} %" if math.isfinite(value) else "none"

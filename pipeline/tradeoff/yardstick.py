"""The yardstick of accuracy: nearly exact steps, at the boundary that they give themselves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.stages import staged
from pipeline.tradeoff.probe import Place, Probe, Reading, fitted, near_the_boundary, probe
from tribo import PRESETS, Fidelity

YARDSTICK = replace(
    PRESETS["reference"], increments=25, contact_tolerance=1e-3, heat_tolerance=1e-6
)
"""A quarter of the steps of the reference, and looser tolerances."""

_TOLERANCES = 2e-3  # the largest error seen that neither steps nor the heat model account for
_APART = 0.05  # of the logarithms of the two velocities at a load from that of the boundary
_MOVED, _ROUNDS = 0.1, 4  # how far the boundary may lie from where it was sought; how often to move
_FLATTEST, _STEEPEST = 0.2, 2.0  # exponents of the rise over the velocity
_HEAT_STEPS, _SMALL = 50, 2e4  # steps, and elements up to which they are the scene's own
_LEFT = 0.5  # of what half the steps move is left to whole ones; a third, at second order
_COARSER = replace(YARDSTICK, pixels_per_element=2, averaging="sample")
_MARGIN = 1.2  # errors between the points are so much larger


@dataclass(frozen=True, slots=True)
class OwnError:
    """Relative error that the yardstick itself makes in the boundary velocity.

    Attributes
    ----------
    steps : float
        Error due to its number of increments.
    heat_model : float
        Error due to the heat model "elapsed", if the scene takes it; 0 with "history".
    work : float
        Elements times convolutions that were spent on it.
    scatters : bool
        Whether more increments make the error of the steps no less. Under a ball each step wears
        by other positions of the disk; where few elements touch, their imprint is left to chance.
    """

    steps: float
    heat_model: float
    work: float
    scatters: bool = False

    def of(self, fidelity: Fidelity) -> float:
        """Error of a fidelity that differs from the yardstick in its steps and heat model alone."""
        more = 1.0 if self.scatters else fidelity.increments / YARDSTICK.increments
        heat = self.heat_model if fidelity.heat_model == "elapsed" else 0.0
        return self.steps / more + _TOLERANCES + heat


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Results of the yardstick about its own boundary, or at points that were asked for.

    Attributes
    ----------
    points : tuple of Point
        Points on either side of the boundary at each place, or those that were asked for.
    exponents : tuple of float
        d ln(rise)/d ln(velocity) at each.
    readings : tuple of Reading
        Results of the yardstick at these points.
    work, own_work : float
        Elements times convolutions that were spent, the search included; and those of the yardstick
        at these points alone.
    boundary : tuple of Point
        The velocity of the boundary at each place.
    coarser : float or None
        Largest relative change of the boundary by elements of twice the pixels' size; None where
        pixels cannot be joined.
    """

    points: tuple[Point, ...]
    exponents: tuple[float, ...]
    readings: tuple[Reading, ...]
    work: float
    own_work: float
    boundary: tuple[Point, ...] = ()
    coarser: float | None = None

    def errors(self, other: Probe) -> list[float]:
        """Relative errors of the boundary velocity by another fidelity, one at each point."""
        readings = zip(other.readings, self.readings, self.exponents, strict=True)
        return [boundary_velocity_error(one.rise, true.rise, at) for one, true, at in readings]

    @property
    def fewest_nodes(self) -> int:
        """Fewest elements in contact at any of the points."""
        return min(reading.contact_nodes for reading in self.readings)


def measured(
    sweep: Sweep, places: Sequence[Place], tell: Callable[[str], None] | None = None
) -> Yardstick:
    """Find the yardstick's boundary, and take readings at two velocities about it at each place.

    It is sought from where the preset ``draft`` has it, first on larger elements, and again
    wherever it has moved. A line is told before each place.
    """
    exact, coarse = fitted(sweep, YARDSTICK), fitted(sweep, _COARSER)
    searches, found = [], []
    starts = near_the_boundary(sweep, places)[0]
    for start in staged(
        starts,
        tell,
        lambda at: f"the boundary by nearly exact steps, {at.load:g} N",
        lambda at: at.load,
    ):
        nearer = _followed(sweep, coarse, start)
        searches.append(nearer)
        found.append(_followed(sweep, exact, nearer.boundary))
    moves = (
        abs(one.boundary.velocity / other.boundary.velocity - 1)
        for one, other in zip(searches, found, strict=True)
    )
    return Yardstick(
        points=tuple(point for each in found for point in each.points),
        exponents=tuple(each.exponent for each in found for _ in each.points),
        readings=tuple(reading for each in found for reading in each.readings),
        work=sum(each.work for each in (*searches, *found)),
        own_work=sum(each.last_work for each in found),
        boundary=tuple(each.boundary for each in found),
        coarser=max(moves) if coarse.pixels_per_element > 1 else None,
    )


def measured_at(sweep: Sweep, points: Sequence[Point], exponents: Sequence[float]) -> Yardstick:
    """Take readings of the yardstick at some points, whose exponents are known."""
    exact, coarse = fitted(sweep, YARDSTICK), fitted(sweep, _COARSER)
    found = probe(sweep, exact, points)
    work, coarser = found.work, None
    if coarse.pixels_per_element > 1:
        on_larger = probe(sweep, coarse, points)
        work += on_larger.work
        coarser = _difference(on_larger.readings, found.readings, exponents)
    return Yardstick(
        tuple(points), tuple(exponents), found.readings, work, found.work, coarser=coarser
    )


def own_error(
    sweep: Sweep,
    points: Sequence[Point],
    exponents: Sequence[float],
    known: Sequence[Reading],
) -> OwnError:
    """Measure by how much the yardstick errs itself: by its steps and by the heat model.

    Steps are halved, which at second order makes four times the error. The heat of all the past
    matters most at the lowest and the highest load; how much hardly depends on the grid.

    Parameters
    ----------
    sweep : Sweep
    points : sequence of Point
        Points near the boundary.
    exponents : sequence of float
        d ln(rise)/d ln(velocity) at each.
    known : sequence of Reading
        Readings of the yardstick at each.
    """
    steps = heat_model = work = 0.0
    exact = fitted(sweep, YARDSTICK)
    if sweep.wear is not None:
        halved = probe(sweep, replace(exact, increments=exact.increments // 2), points)
        steps = _difference(known, halved.readings, exponents)
        steps *= 1.0 if sweep.sweeps_over else _LEFT
        work += halved.work
    if sweep.fidelity.heat_model == "elapsed":
        size = 1 if math.prod(sweep.pixels.shape) <= _SMALL else 2
        by_load = sorted(range(len(points)), key=lambda k: points[k].load)
        at = sorted({by_load[0], by_load[-1]})
        present = replace(
            exact,
            wear_scheme="implicit",
            increments=_HEAT_STEPS,
            contact_tolerance=1e-2,
            pixels_per_element=size,
        )
        present = fitted(sweep, present)
        ends = [points[k] for k in at]
        one, other = (
            probe(sweep, replace(present, heat_model=model), ends)
            for model in ("elapsed", "history")
        )
        heat_model = _difference(one.readings, other.readings, [exponents[k] for k in at])
        work += one.work + other.work
    return OwnError(_MARGIN * steps, _MARGIN * heat_model, work, sweep.sweeps_over)


def _difference(
    ones: Sequence[Reading], others: Sequence[Reading], exponents: Sequence[float]
) -> float:
    """Largest difference of the boundary velocity by two readings at each point."""
    return max(
        abs(boundary_velocity_error(one.rise, other.rise, exponent))
        for one, other, exponent in zip(ones, others, exponents, strict=True)
    )


@dataclass(frozen=True, slots=True)
class _Found:
    """Readings on either side of the boundary at a load, and where it lies according to them."""

    points: tuple[Point, Point]
    readings: tuple[Reading, ...]
    exponent: float
    boundary: Point
    work: float
    last_work: float


def _followed(sweep: Sweep, fidelity: Fidelity, start: Point) -> _Found:
    """Take readings at two velocities about a boundary, and again about where these place it."""
    moving = [abs(velocity) for velocity in sweep.velocities if velocity]
    limit, at, work = rise_limit(sweep.conditions), start.velocity, 0.0
    for _ in range(_ROUNDS):
        low, high = at * math.exp(-_APART), at * math.exp(_APART)
        points = start._replace(velocity=low), start._replace(velocity=high)
        found = probe(sweep, fidelity, points)
        work += found.work
        below, above = (math.log(reading.rise / limit) for reading in found.readings)
        exponent = min(max((above - below) / (2 * _APART), _FLATTEST), _STEEPEST)
        sought = at
        at *= math.exp(-(below + above) / 2 / exponent)
        at = min(max(at, min(moving) / 2), 2 * max(moving))
        if abs(math.log(at / sought)) <= _MOVED:
            break
    boundary = start._replace(velocity=at)
    return _Found(points, found.readings, exponent, boundary, work, found.work)

"""The yardstick of accuracy: nearly exact steps, at the boundary that they give themselves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.stages import staged
from pipeline.tradeoff.probe import Probe, Reading, fitted, near_the_boundary, probe
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
    """

    steps: float
    heat_model: float
    work: float

    def of(self, fidelity: Fidelity) -> float:
        """Error of a fidelity that differs from the yardstick in its steps and heat model alone."""
        steps = self.steps * YARDSTICK.increments / fidelity.increments
        heat = self.heat_model if fidelity.heat_model == "elapsed" else 0.0
        return steps + _TOLERANCES + heat


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Results of the yardstick about its own boundary.

    Attributes
    ----------
    boundary : tuple of Point
        The velocity of the boundary at each load.
    points : tuple of Point
        Two velocities at each load, on either side of the boundary.
    exponents : tuple of float
        d ln(rise)/d ln(velocity) at each.
    readings : tuple of Reading
        Results of the yardstick at these points.
    work, own_work : float
        Elements times convolutions that were spent, the search included; and those of the yardstick
        at these points alone.
    """

    boundary: tuple[Point, ...]
    points: tuple[Point, ...]
    exponents: tuple[float, ...]
    readings: tuple[Reading, ...]
    work: float
    own_work: float

    def errors(self, other: Probe) -> list[float]:
        """Relative errors of the boundary velocity by another fidelity, one at each point."""
        readings = zip(other.readings, self.readings, self.exponents, strict=True)
        return [boundary_velocity_error(one.rise, true.rise, at) for one, true, at in readings]

    @property
    def fewest_nodes(self) -> int:
        """Fewest elements in contact at any of the points."""
        return min(reading.contact_nodes for reading in self.readings)


def measured(
    sweep: Sweep, loads: Sequence[float], tell: Callable[[str], None] | None = None
) -> Yardstick:
    """Find the yardstick's boundary, and take readings at two velocities about it at each load.

    It is sought from where the preset ``draft`` has it, first on larger elements, and again
    wherever it has moved. A line is told before each load.
    """
    exact = fitted(sweep, YARDSTICK)
    coarse = fitted(sweep, replace(YARDSTICK, pixels_per_element=2, averaging="sample"))
    searches, found = [], []
    starts = near_the_boundary(sweep, loads)[0]
    for start in staged(
        starts,
        tell,
        lambda at: f"the boundary by nearly exact steps, {at.load:g} N",
        lambda at: at.load,
    ):
        nearer = _followed(sweep, coarse, start)
        searches.append(nearer)
        found.append(_followed(sweep, exact, nearer.boundary))
    return Yardstick(
        boundary=tuple(each.boundary for each in found),
        points=tuple(point for each in found for point in each.points),
        exponents=tuple(each.exponent for each in found for _ in each.points),
        readings=tuple(reading for each in found for reading in each.readings),
        work=sum(each.work for each in (*searches, *found)),
        own_work=sum(each.last_work for each in found),
    )


def own_error(
    sweep: Sweep,
    points: Sequence[Point],
    exponents: Sequence[float],
    known: Sequence[Reading] | None = None,
) -> OwnError:
    """Measure by how much the yardstick errs itself: by its steps and by the heat model.

    Steps are halved, which at second order makes four times the error. The heat of all the past
    matters most at the first and the last of the loads; how much hardly depends on the grid.

    Parameters
    ----------
    sweep : Sweep
    points : sequence of Point
        Points near the boundary.
    exponents : sequence of float
        d ln(rise)/d ln(velocity) at each.
    known : sequence of Reading, optional
        Readings of the yardstick at each; taken again if not given.
    """
    steps = heat_model = work = 0.0
    exact = fitted(sweep, YARDSTICK)
    if sweep.wear is not None:
        if known is None:
            full = probe(sweep, exact, points)
            known, work = full.readings, full.work
        halved = probe(sweep, replace(exact, increments=exact.increments // 2), points)
        steps = _LEFT * _difference(known, halved.readings, exponents)
        work += halved.work
    if sweep.fidelity.heat_model == "elapsed":
        size = 1 if math.prod(sweep.pixels.shape) <= _SMALL else 2
        at = sorted({0, len(points) - 1})
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
    return OwnError(_MARGIN * steps, _MARGIN * heat_model, work)


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
        points = (
            Point(start.load, at * math.exp(-_APART)),
            Point(start.load, at * math.exp(_APART)),
        )
        found = probe(sweep, fidelity, points)
        work += found.work
        low, high = (math.log(reading.rise / limit) for reading in found.readings)
        exponent = min(max((high - low) / (2 * _APART), _FLATTEST), _STEEPEST)
        sought = at
        at *= math.exp(-(low + high) / 2 / exponent)
        at = min(max(at, min(moving) / 2), 2 * max(moving))
        if abs(math.log(at / sought)) <= _MOVED:
            break
    return _Found(points, found.readings, exponent, Point(start.load, at), work, found.work)

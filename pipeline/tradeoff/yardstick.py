"""Measures what nearly exact steps give at the boundary that they draw themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Point, Sweep
from pipeline.tradeoff.probe import Probe, Reading, fitted, near_the_boundary, probe
from tribo import PRESETS, Fidelity

__all__ = ["YARDSTICK", "OwnError", "Yardstick", "measured", "own_error"]

YARDSTICK = replace(
    PRESETS["reference"], increments=100, contact_tolerance=1e-3, heat_tolerance=1e-6
)
"""Half the steps of the reference, looser tolerances: a third of its work."""

_TOLERANCES = 2e-3  # the largest error seen that neither steps nor the heat model account for
_APART = 0.05  # of the logarithms of the two velocities at a load from that of the boundary
_MOVED, _ROUNDS = 0.1, 4  # how far the boundary may lie from where it was sought; how often to move
_FLATTEST, _STEEPEST = 0.2, 2.0  # exponents of the rise over the velocity
_HEAT_STEPS, _SMALL = 50, 2e4  # steps, and elements up to which they are the scene's own
_MARGIN = 1.2  # errors between the points are so much larger


@dataclass(frozen=True, slots=True)
class OwnError:
    """Error that a fidelity has itself, relative, of the boundary velocity.

    Attributes
    ----------
    steps : float
        Error by its number of increments.
    heat_model : float
        Error by the heat model "elapsed", which the scene takes; 0 with "history".
    work : float
        Elements times convolutions that were spent on it.
    """

    steps: float
    heat_model: float
    work: float

    def of(self, increments: int, of_heat: bool) -> float:
        """Error with so many increments in place of the yardstick's, tolerances included."""
        steps = self.steps * YARDSTICK.increments / increments
        return steps + _TOLERANCES + (self.heat_model if of_heat else 0.0)


@dataclass(frozen=True, slots=True)
class Yardstick:
    """What the yardstick gives about its own boundary.

    Attributes
    ----------
    points : tuple of Point
        Two velocities at each load, on either side of the boundary.
    exponents : tuple of float
        d ln(rise)/d ln(velocity) at each.
    readings : tuple of Reading
        What the yardstick gives there.
    work, own_work : float
        Elements times convolutions that were spent, on the search too; and by the yardstick at
        these points alone.
    """

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


def measured(sweep: Sweep, loads: Sequence[float]) -> Yardstick:
    """Find the boundary by the yardstick, and read it at two velocities about that at each load.

    It is sought from where the preset ``draft`` has it, first on larger elements, and again
    wherever it has moved.
    """
    exact = fitted(sweep, YARDSTICK)
    coarse = fitted(sweep, replace(YARDSTICK, pixels_per_element=2, averaging="sample"))
    searches, found = [], []
    for start in near_the_boundary(sweep, loads)[0]:
        nearer = _followed(sweep, coarse, start)
        searches.append(nearer)
        found.append(_followed(sweep, exact, nearer.boundary))
    return Yardstick(
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

    Steps are halved, which at first order doubles the error of those that were left. By the heat
    of all the past the last and the first of the loads differ most; how much, hardly depends on
    the grid.

    Parameters
    ----------
    sweep : Sweep
    points : sequence of Point
        Near the boundary.
    exponents : sequence of float
        d ln(rise)/d ln(velocity) at each.
    known : sequence of Reading, optional
        Of the yardstick at each; read again if not given.
    """
    steps = heat_model = work = 0.0
    exact = fitted(sweep, YARDSTICK)
    if sweep.wear is not None:
        if known is None:
            full = probe(sweep, exact, points)
            known, work = full.readings, full.work
        halved = probe(sweep, replace(exact, increments=exact.increments // 2), points)
        steps, work = _difference(known, halved.readings, exponents), work + halved.work
    if sweep.fidelity.heat_model == "elapsed":
        size = 1 if math.prod(sweep.pixels.shape) <= _SMALL else 2
        at = sorted({0, len(points) - 1})
        present = replace(
            exact, increments=_HEAT_STEPS, contact_tolerance=1e-2, pixels_per_element=size
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
    """Readings on either side of the boundary at a load, and where that lies by them."""

    points: tuple[Point, Point]
    readings: tuple[Reading, ...]
    exponent: float
    boundary: Point
    work: float
    last_work: float


def _followed(sweep: Sweep, fidelity: Fidelity, start: Point) -> _Found:
    """Read two velocities about a boundary, and again about where they say that it lies."""
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

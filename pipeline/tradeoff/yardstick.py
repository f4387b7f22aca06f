"""Yardstick of accuracy: results of nearly exact steps, and their own error."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pipeline.sweep.criterion import boundary_velocity_error
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.stages import staged
from pipeline.tradeoff.probe import Probe, Reading, fitted, probe
from tribo import PRESETS, Fidelity

YARDSTICK = replace(
    PRESETS["reference"], increments=25, contact_tolerance=1e-3, heat_tolerance=1e-6
)
"""A quarter of the steps of the reference, and looser tolerances."""

# Judged by `make promises`, as those of `pipeline.tradeoff.choose` are.
_TOLERANCES = 2e-3  # the largest error seen that neither steps nor the heat model account for
_HEAT_STEPS, _SMALL = 50, 2e4  # steps, and elements up to which they are the scene's own
_LEFT = 0.5  # of what half the steps move is left to whole ones; a third, at second order
_COARSER = replace(YARDSTICK, pixels_per_element=2, averaging="sample")
_MARGIN = 1.2  # errors between the points are so much larger


@dataclass(frozen=True, slots=True)
class OwnError:
    """Relative error that the yardstick itself makes in the boundary velocity."""

    steps: float
    """Error due to its number of increments."""
    heat_model: float
    """Error due to the heat model "elapsed", if the scene takes it."""
    work: float
    """Elements times convolutions that were spent on it."""
    scatters: bool = False
    """True if more increments do not reduce the error of the steps.

    Under a ball each step wears by other positions of the disk; where few elements touch, their
    imprint is left to chance.
    """

    def of(self, fidelity: Fidelity) -> float:
        """Error of a fidelity that differs from the yardstick in its steps and heat model alone."""
        more = 1.0 if self.scatters else fidelity.increments / YARDSTICK.increments
        heat = self.heat_model if fidelity.heat_model == "elapsed" else 0.0
        return self.steps / more + _TOLERANCES + heat


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Results of the yardstick at points near the boundary, or at those that were asked for."""

    points: tuple[Point, ...]
    exponents: tuple[float, ...]
    """d ln(rise)/d ln(velocity) at each."""
    readings: tuple[Reading, ...]
    work: float
    """Elements times convolutions that were spent, those on larger elements included."""
    own_work: float
    """Elements times convolutions of the yardstick alone."""
    coarser: float | None = None
    """Largest relative change of the boundary by elements of twice the pixels' size, if any."""

    def errors(self, other: Probe) -> tuple[float, ...]:
        """Relative errors of the boundary velocity by another fidelity, one at each point."""
        return velocity_errors(other.readings, self.readings, self.exponents)

    @property
    def fewest_nodes(self) -> int:
        """Fewest elements in contact at any of the points."""
        return min(reading.contact_nodes for reading in self.readings)


def measured(
    sweep: Sweep,
    points: Sequence[Point],
    exponents: Sequence[float],
    tell: Callable[[str], None] | None = None,
) -> Yardstick:
    """Take readings of the yardstick at some points, and tell a line before each of them."""
    exact, coarse = fitted(sweep, YARDSTICK), fitted(sweep, _COARSER)
    probes = [
        probe(sweep, exact, [point])
        for point in staged(points, tell, lambda point: f"nearly exact steps at {point}")
    ]
    readings = tuple(reading for probed in probes for reading in probed.readings)
    own_work = sum(probed.work for probed in probes)
    work, coarser = own_work, None
    if coarse.pixels_per_element > 1:
        on_larger = probe(sweep, coarse, points)
        work += on_larger.work
        coarser = max(map(abs, velocity_errors(on_larger.readings, readings, exponents)))
    return Yardstick(tuple(points), tuple(exponents), readings, work, own_work, coarser)


def own_error(
    sweep: Sweep,
    points: Sequence[Point],
    exponents: Sequence[float],
    readings: Sequence[Reading],
) -> OwnError:
    """Measure by how much the yardstick errs itself: by its steps and by the heat model.

    Steps are halved, which at second order makes four times the error. The heat of all the past
    matters most at the lowest and the highest load; how much hardly depends on the grid.
    """
    steps = heat_model = work = 0.0
    exact = fitted(sweep, YARDSTICK)
    if sweep.scene.wear is not None:
        halved = probe(sweep, replace(exact, increments=exact.increments // 2), points)
        steps = max(map(abs, velocity_errors(readings, halved.readings, exponents)))
        steps *= 1.0 if sweep.scene.sweeps_over else _LEFT
        work += halved.work
    if sweep.scene.fidelity.heat_model == "elapsed":
        size = 1 if math.prod(sweep.scene.pixels.shape) <= _SMALL else 2
        by_load = sorted(zip(points, exponents, strict=True), key=lambda pair: pair[0].load)
        ends, of_ends = zip(*dict.fromkeys((by_load[0], by_load[-1])), strict=True)
        present = replace(
            exact,
            wear_scheme="implicit",
            increments=_HEAT_STEPS,
            contact_tolerance=1e-2,
            pixels_per_element=size,
        )
        present = fitted(sweep, present)
        one, other = (
            probe(sweep, replace(present, heat_model=model), ends)
            for model in ("elapsed", "history")
        )
        heat_model = max(map(abs, velocity_errors(one.readings, other.readings, of_ends)))
        work += one.work + other.work
    return OwnError(_MARGIN * steps, _MARGIN * heat_model, work, sweep.scene.sweeps_over)


def velocity_errors(
    ones: Sequence[Reading], others: Sequence[Reading], exponents: Sequence[float]
) -> tuple[float, ...]:
    """Relative errors of the boundary velocity by readings against others at the same points."""
    return tuple(
        boundary_velocity_error(one.rise, other.rise, exponent)
        for one, other, exponent in zip(ones, others, exponents, strict=True)
    )

"""Cost and error of a numerical choice at a few points, against nearly exact steps."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import tasks
from pipeline.sweep.severity import (
    boundary_velocity_error,
    momentary_rise,
    rise_limit,
)
from pipeline.sweep.stages import Report, silent, staged
from pipeline.sweep.variants import Variant
from tribo import PRESETS, Fidelity, InputError, Scene, State, simulate
from tribo.simulation import Trunks, forget_contacts


class Target(NamedTuple):
    """Load at which to look for the boundary [N], and in which variant of the scene."""

    load: float
    variant: Variant = ()


_USUAL_EXPONENT, _FLATTEST = 0.6, 0.3  # exponents of the rise; where few nodes touch, it jumps
_TOLERANCE = 0.01  # relative, of the rise where its limit is looked for
_STEP = 0.05  # step of ln(velocity) over which the exponent is taken


@dataclass(frozen=True, slots=True)
class Reading:
    """Result of one point."""

    rise: float  # that decides, at friction 1 [K]
    contact_nodes: int  # elements in contact


@dataclass(frozen=True, slots=True)
class Probe:
    """Cost and results of a fidelity at some points."""

    fidelity: Fidelity
    readings: tuple[Reading, ...]
    seconds: float  # processor time; if asked for, without surfaces and kernels


def probe(
    sweep: Sweep, fidelity: Fidelity, points: Sequence[Point], is_timed: bool = False
) -> Probe:
    """Simulate points with another fidelity; those at one velocity share their ramp."""
    scene = sweep.changed(fidelity=fidelity, steps="end")
    if is_timed:  # without surface and kernels, which a whole sweep makes once
        load, velocity = min((point.load, point.velocity) for point in points)
        _run(scene, load / 2, velocity * 0.9)
    forget_contacts()
    began = time.process_time()
    runs = {}
    trunks = Trunks()
    for point in (point for task in tasks(points, scene) for point in task.points):
        variant = scene.variant(point.variant)
        runs[point] = _run(variant, point.load, point.velocity, trunks)
    seconds = time.process_time() - began
    readings = tuple(_reading(sweep, scene.scene, runs[point]) for point in points)
    return Probe(fidelity, readings, seconds)


def _run(sweep: Sweep, load: float, velocity: float, trunks: Trunks | None = None) -> State:
    """Simulate a point: its hottest state under full load."""
    hot: list[tuple[float, State]] = []
    for state in simulate(sweep.scene, load, velocity, trunks):
        if state.heat is not None and state.normal_load >= load:
            hot.append((momentary_rise(sweep.scene, state, sweep.conditions), state))
    return max(hot, key=lambda reading: reading[0])[1] if hot else state


def _reading(sweep: Sweep, scene: Scene, state: State) -> Reading:
    if state.heat is None:
        raise InputError("a point ended without a temperature")
    return Reading(
        rise=momentary_rise(scene, state, sweep.conditions),
        contact_nodes=int(np.count_nonzero(state.pressure)),
    )


def dividing_pixels(sweep: Sweep, fidelity: Fidelity) -> Fidelity:
    """A fidelity whose elements divide the scene's pixels."""
    nx, ny = sweep.scene.pixels.shape
    fits = (n for n in range(fidelity.pixels_per_element, 0, -1) if nx % n == ny % n == 0)
    return replace(fidelity, pixels_per_element=next(fits))


def some_places(sweep: Sweep, number: int) -> tuple[Target, ...]:
    """Some of a sweep's loads, both ends among them, and its variants in turn."""
    loads, variants = sweep.plane.loads, sweep.variants.names
    chosen = sorted({round((len(loads) - 1) * k / max(number - 1, 1)) for k in range(number)})
    turns = (divmod(k, len(chosen)) for k in range(number))
    places = (Target(loads[chosen[k]], variants[(k + turn) % len(variants)]) for turn, k in turns)
    return tuple(dict.fromkeys(places))


def near_the_boundary(
    sweep: Sweep, places: Sequence[Target]
) -> tuple[tuple[Point, ...], tuple[float, ...]]:
    """Points near which wear turns severe at ``standard``, and d ln(rise)/d ln(velocity) there.

    Without a transition from half the lowest to twice the highest velocity, the nearer end.
    """
    scene = sweep.changed(fidelity=dividing_pixels(sweep, PRESETS["standard"]))
    points, exponents = [], []
    moving = [abs(velocity) for velocity in sweep.plane.velocities if velocity]
    if not moving:
        raise InputError(
            "the sweep has no velocity but 0, and so no heat to be wrong about; "
            "give velocities above 0"
        )
    limit = rise_limit(sweep.conditions)

    def rise_at(place: Target, velocity: float) -> float:
        state = _run(scene.variant(place.variant), place.load, velocity)
        return _reading(sweep, scene.scene, state).rise

    for place in places:
        rise = partial(rise_at, place)
        velocity = critical_velocity(rise, limit, min(moving) / 2, max(moving) * 2)
        points.append(Point(place.load, velocity, place.variant))
        ratio = rise(velocity * math.exp(_STEP)) / rise(velocity * math.exp(-_STEP))
        exponents.append(max(math.log(ratio) / (2 * _STEP), _FLATTEST))
    return tuple(points), tuple(exponents)


def critical_velocity(
    rise: Callable[[float], float], limit: float, lowest: float, highest: float
) -> float:
    """Velocity at which a growing rise reaches a limit, or the nearer end of a range [m/s].

    By secants of the logarithms, or by halving where one leads back, as beside a jump.
    """
    low, high = math.log(lowest), math.log(highest)
    velocity, exponent = (low + high) / 2, _USUAL_EXPONENT
    tried: dict[float, float] = {}
    for _ in range(30):
        short = math.log(rise(math.exp(velocity)) / limit)
        low, high = (low, velocity) if short > 0 else (velocity, high)
        if abs(short) <= _TOLERANCE or high - low < 1e-9:
            break
        if tried:
            before, earlier = next(reversed(tried.items()))
            exponent = min(max((short - earlier) / (velocity - before), 0.2), 3.0)
        tried[velocity] = short
        velocity = min(max(velocity - short / exponent, low), high)
        if velocity in tried:
            velocity = (low + high) / 2
    return math.exp(velocity)


YARDSTICK = replace(
    PRESETS["reference"], increments=25, contact_tolerance=1e-3, heat_tolerance=1e-6
)
"""A quarter of the steps of the reference, and looser tolerances."""

_TOLERANCES = 2e-3
"""Largest error seen that neither steps nor the heat model account for.

Judged by `make promises`.
"""
_HEAT_STEPS, _SMALL = 50, 2e4  # steps, and elements up to which they are the scene's own
_LEFT = 0.5
"""Share of what half the steps move that is left to whole ones; a third, at second order.

Judged by `make promises`.
"""
_COARSER = replace(YARDSTICK, pixels_per_element=2, averaging="sample")
_MARGIN = 1.2
"""Errors between the points over those at them. Judged by `make promises`."""


@dataclass(frozen=True, slots=True)
class OwnError:
    """Relative error of the yardstick itself in the boundary velocity."""

    steps: float  # by the number of its increments
    heat_model: float  # by the heat model "elapsed", if the scene takes it
    # More increments reduce nothing: under a ball each step wears by other positions of the disk,
    # and where few elements touch, their imprint is left to chance.
    scatters: bool = False

    def of(self, fidelity: Fidelity) -> float:
        """Error of a fidelity that differs from the yardstick in its steps and heat model alone."""
        more = 1.0 if self.scatters else fidelity.increments / YARDSTICK.increments
        heat = self.heat_model if fidelity.heat_model == "elapsed" else 0.0
        return self.steps / more + _TOLERANCES + heat


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Results of the yardstick at points near the boundary, or at those that were asked for."""

    points: tuple[Point, ...]
    exponents: tuple[float, ...]  # d ln(rise)/d ln(velocity) at each
    readings: tuple[Reading, ...]
    seconds: float  # processor time of the points [s]
    coarser: float | None = None  # largest relative change by elements of twice the pixels' size

    def errors(self, other: Probe) -> tuple[float, ...]:
        """Relative errors of the boundary velocity by another fidelity, one at each point."""
        return velocity_errors(other.readings, self.readings, self.exponents)

    @property
    def fewest_nodes(self) -> int:
        """Fewest elements in contact at any of the points."""
        return min(reading.contact_nodes for reading in self.readings)


def measured(
    sweep: Sweep, points: Sequence[Point], exponents: Sequence[float], progress: Report = silent
) -> Yardstick:
    """Take readings of the yardstick at some points, and tell before each of them."""
    exact, coarse = dividing_pixels(sweep, YARDSTICK), dividing_pixels(sweep, _COARSER)
    probes = [
        probe(sweep, exact, [point])
        for point in staged(points, progress, lambda point: f"nearly exact steps at {point}")
    ]
    readings = tuple(reading for probed in probes for reading in probed.readings)
    seconds, coarser = sum(probed.seconds for probed in probes), None
    if coarse.pixels_per_element > 1:
        on_larger = probe(sweep, coarse, points)
        coarser = max(map(abs, velocity_errors(on_larger.readings, readings, exponents)))
    return Yardstick(tuple(points), tuple(exponents), readings, seconds, coarser)


def own_error(
    sweep: Sweep, points: Sequence[Point], exponents: Sequence[float], readings: Sequence[Reading]
) -> OwnError:
    """Measure by how much the yardstick errs itself: by its steps and by the heat model.

    Steps are halved, which at second order makes four times the error. The heat of all the past
    matters most at the lowest and the highest load; how much hardly depends on the grid.
    """
    steps = heat_model = 0.0
    exact = dividing_pixels(sweep, YARDSTICK)
    if sweep.scene.wear is not None:
        halved = probe(sweep, replace(exact, increments=exact.increments // 2), points)
        steps = max(map(abs, velocity_errors(readings, halved.readings, exponents)))
        steps *= 1.0 if sweep.scene.sweeps_over else _LEFT
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
        present = dividing_pixels(sweep, present)
        one, other = (
            probe(sweep, replace(present, heat_model=model), ends)
            for model in ("elapsed", "history")
        )
        heat_model = max(map(abs, velocity_errors(one.readings, other.readings, of_ends)))
    return OwnError(_MARGIN * steps, _MARGIN * heat_model, sweep.scene.sweeps_over)


def velocity_errors(
    ones: Sequence[Reading], others: Sequence[Reading], exponents: Sequence[float]
) -> tuple[float, ...]:
    """Relative errors of the boundary velocity by readings against others at the same points."""
    return tuple(
        boundary_velocity_error(one.rise, other.rise, exponent)
        for one, other, exponent in zip(ones, others, exponents, strict=True)
    )

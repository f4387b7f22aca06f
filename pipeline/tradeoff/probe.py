"""Cost and temperature rises of a fidelity at a few points near the boundary."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from pipeline.scene.written import with_fidelity
from pipeline.sweep.case import Case
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import tasks
from pipeline.sweep.selection import with_dividing_elements
from pipeline.sweep.severity import momentary_rise, rise_limit
from pipeline.sweep.variants import Variant
from tribo import PRESETS, Fidelity, InputError, State, simulate
from tribo.simulation import Trunks, forget_contacts


class Target(NamedTuple):
    """Load [N] and variant of the scene for which the boundary is searched."""

    load: float
    variant: Variant = ()


_USUAL_EXPONENT, _FLATTEST = 0.6, 0.3  # usual and least d ln(rise)/d ln(velocity)
_TOLERANCE = 0.01  # relative error of the rise at the velocity found
_STEP = 0.05  # step of ln(velocity) to either side, to find the exponent


class Probe(NamedTuple):
    """Processor time of simulating points with a fidelity, and the points' temperature rises."""

    fidelity: Fidelity
    rises: tuple[float, ...]  # of the criterion, per unit friction coefficient, by point [K]
    fewest_nodes: int  # fewest elements in contact at any of the points
    seconds: float  # processor time without making surfaces and kernels [s]


def probe(sweep: Sweep, fidelity: Fidelity, points: Sequence[Point]) -> Probe:
    """Simulate points with another fidelity; return their rises, and the processor time.

    Points at one velocity share the load steps of one ramp.
    """
    scene = replace(with_fidelity(sweep, fidelity), steps="end")
    # Make surface and kernels before timing: a whole sweep makes them once.
    first = min(points, key=lambda point: (point.load, point.velocity))
    _simulated_rise(scene.case(first.variant), first.load / 2, first.velocity * 0.9)
    forget_contacts()
    began = time.process_time()
    runs, trunks = dict[Point, tuple[float, State]](), Trunks()
    for point in (task.point for task in tasks(points, scene)):
        case = scene.case(point.variant)
        runs[point] = _simulated_rise(case, point.load, point.velocity, trunks)
    seconds = time.process_time() - began
    rises = tuple(runs[point][0] for point in points)
    fewest = min(int(np.count_nonzero(state.pressure)) for _, state in runs.values())
    return Probe(fidelity, rises, fewest, seconds)


def _simulated_rise(
    case: Case, load: float, velocity: float, trunks: Trunks | None = None
) -> tuple[float, State]:
    """Simulate a point; return its highest rise at full load, and the state with this rise.

    The rise [K] is the one that the criterion compares with its limit, per unit friction
    coefficient. `trunks` caches load steps, which points share: steps of earlier points are reused,
    and those of this point are added.
    """
    under_load = (
        (momentary_rise(case.scene, state, case.conditions), state)
        for state in simulate(case.scene, load, velocity, trunks)
        if state.heat is not None and state.normal_load >= load
    )
    return max(under_load, key=lambda reading: reading[0])


def spread_places(sweep: Sweep, number: int) -> tuple[Target, ...]:
    """Up to `number` different targets, each a load and a variant of the sweep.

    The loads are spread evenly over the sweep, and the variants take turns.
    """
    loads, variants = sweep.loads, sweep.variants.names
    chosen = sorted({round((len(loads) - 1) * k / max(number - 1, 1)) for k in range(number)})
    turns = (divmod(k, len(chosen)) for k in range(number))
    places = (Target(loads[chosen[k]], variants[(k + turn) % len(variants)]) for turn, k in turns)
    return tuple(dict.fromkeys(places))


def points_near_boundary(
    sweep: Sweep, places: Sequence[Target]
) -> tuple[tuple[Point, ...], tuple[float, ...]]:
    """Find a point near the boundary for each target, and d ln(rise)/d ln(velocity) there.

    Derivatives below 0.3 are replaced by 0.3. Both are found with the preset ``standard``.
    `places` are the targets. Velocities from half the sweep's lowest to twice its highest are
    searched. Without a transition there, the point is at the end where the rise is closer to its
    limit.
    """
    scene = with_fidelity(sweep, with_dividing_elements(sweep.scene, PRESETS["standard"]))
    points, exponents = [], []
    moving = [abs(velocity) for velocity in sweep.velocities if velocity]
    if not moving:
        raise InputError("the sweep has no velocity above 0, and so no friction heat; give one")
    limit = rise_limit(sweep.conditions)

    def rise_at(place: Target, velocity: float) -> float:
        return _simulated_rise(scene.case(place.variant), place.load, velocity)[0]

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
    """Velocity [m/s] at which a rise [K] reaches a limit, between `lowest` and `highest`.

    The rise grows with velocity. If it stays below the limit, the result is `highest`; if it stays
    above, `lowest`. The velocity is found by secant steps in logarithms, with bisection if a secant
    returns to an earlier velocity.
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

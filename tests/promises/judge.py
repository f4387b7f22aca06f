"""The true boundary of a scene, and how far a fidelity is from it."""

import math
from dataclasses import replace

from pipeline.sweep.criterion import decisive_rise, rise_limit
from tribo import PRESETS, simulate, warnings

# The reference, twice as fine in everything.
TRUTH = replace(PRESETS["reference"], increments=400, contact_tolerance=5e-6, heat_tolerance=5e-9)
_CLOSE = 5e-4  # relative, of a boundary velocity


def boundary_velocity(sweep, fidelity, load, velocity, ratio=1.0):
    """Where the decisive rise reaches its limit, by secants from a velocity; and its warnings.

    The rise is multiplied by a ratio, such as that of `heat_of_the_past`.
    """
    scene = replace(sweep, fidelity=fidelity)
    limit, exponent, before = rise_limit(sweep.conditions) / ratio, 0.6, None
    for _ in range(12):
        *_, state = simulate(scene, load, velocity)
        short = math.log(decisive_rise(state.heat.rise_quantile, sweep.conditions) / limit)
        if before is not None and abs(math.log(velocity / before[0])) > 1e-6:
            slope = (short - before[1]) / math.log(velocity / before[0])
            exponent = min(max(slope, 0.2), 2.0)
        before = velocity, short
        if abs(short / exponent) < _CLOSE:
            break
        velocity *= math.exp(-short / exponent)
    kinds = {warning.kind.label for warning in warnings(scene, state)}
    return velocity, sorted(kinds)


def heat_of_the_past(sweep, load, velocity):
    """Rise by all the heat so far over that by the present heat, which hardly depends on steps."""
    rises = []
    for model in ("history", "elapsed"):
        fidelity = replace(TRUTH, increments=50, contact_tolerance=1e-4, heat_model=model)
        *_, state = simulate(replace(sweep, fidelity=fidelity), load, velocity)
        rises.append(decisive_rise(state.heat.rise_quantile, sweep.conditions))
    return rises[0] / rises[1]


def true_boundary(sweep):
    """Velocity at each load by the present heat alone, and by all the heat so far."""
    middle = math.sqrt(sweep.velocities[0] * sweep.velocities[-1])
    by_present, by_all = {}, {}
    for load in sweep.loads:
        start, _ = boundary_velocity(sweep, PRESETS["standard"], load, middle)
        by_present[load], _ = boundary_velocity(sweep, TRUTH, load, start)
        ratio = heat_of_the_past(sweep, load, by_present[load])
        by_all[load], _ = boundary_velocity(sweep, TRUTH, load, by_present[load], ratio)
    return by_present, by_all


def largest_error(sweep, fidelity, true):
    """Largest relative error at any load, and the kinds of warnings there."""
    found = [boundary_velocity(sweep, fidelity, load, true[load]) for load in true]
    off = [abs(math.log(one / of)) for (one, _), of in zip(found, true.values(), strict=True)]
    return max(off), sorted({kind for _, kinds in found for kind in kinds})

"""The true boundary of a scene, and how far a fidelity is from it."""

import math
from dataclasses import replace

from pipeline.sweep.criterion import decisive_rise, rise_limit
from tribo import PRESETS, simulate, warnings

# The reference with tolerances half as large. Its rise is mostly within 0.02 % of that in 400
# steps; where whole rows of elements wear heavily, within 0.2 %.
TRUTH = replace(PRESETS["reference"], contact_tolerance=5e-6, heat_tolerance=5e-9)
_PAST_STEPS = 50  # in which the share of the heat of the past is known
_NEARLY = replace(TRUTH, increments=12, contact_tolerance=1e-4, heat_tolerance=1e-6)
_CLOSE = 5e-4  # relative, of a boundary velocity
_SMALL_STEP = 5e-3  # of the logarithm of velocity, over which its known exponent is exact enough


def boundary_velocity(sweep, fidelity, load, velocity, ratio=1.0, exponent=None):
    """Where the decisive rise reaches its limit, by secants from a velocity; and its warnings.

    The rise is multiplied by a ratio, such as that of `heat_of_the_past`. With a known exponent
    d ln(rise)/d ln(velocity) a last small step is trusted.
    """
    scene = replace(sweep, fidelity=fidelity)
    limit, before = rise_limit(sweep.conditions) / ratio, None
    trusted, exponent = exponent is not None, exponent or 0.6
    for _ in range(12):
        *_, state = simulate(scene, load, velocity)
        short = math.log(decisive_rise(state.heat, sweep.conditions) / limit)
        if before is not None and abs(math.log(velocity / before[0])) > 1e-6:
            slope = (short - before[1]) / math.log(velocity / before[0])
            exponent = min(max(slope, 0.2), 2.0)
        before = velocity, short
        if abs(short / exponent) < _CLOSE:
            break
        velocity *= math.exp(-short / exponent)
        if trusted and abs(short / exponent) < _SMALL_STEP:
            break
    kinds = {warning.kind.label for warning in warnings(scene, state)}
    return velocity, sorted(kinds)


def exponent_at(sweep, fidelity, load, velocity, apart=0.03):
    """d ln(rise)/d ln(velocity) about a velocity."""
    scene, rises = replace(sweep, fidelity=fidelity), []
    for at in (velocity * math.exp(-apart), velocity * math.exp(apart)):
        *_, state = simulate(scene, load, at)
        rises.append(math.log(decisive_rise(state.heat, sweep.conditions)))
    return min(max((rises[1] - rises[0]) / (2 * apart), 0.2), 2.0)


def heat_of_the_past(sweep, load, velocity):
    """Rise by all the heat so far over that by the present heat, which hardly depends on steps."""
    rises = []
    for model in ("history", "elapsed"):
        fidelity = replace(
            TRUTH,
            increments=_PAST_STEPS,
            wear_scheme="implicit",
            contact_tolerance=1e-4,
            heat_model=model,
        )
        *_, state = simulate(replace(sweep, fidelity=fidelity), load, velocity)
        rises.append(decisive_rise(state.heat, sweep.conditions))
    return rises[0] / rises[1]


def true_boundary(sweep):
    """Velocity at each load by the present heat alone, and by all the heat so far.

    It is sought with an eighth of the steps, so that few of the whole are left to be done.
    """
    middle = math.sqrt(sweep.velocities[0] * sweep.velocities[-1])
    by_present, by_all = {}, {}
    for load in sweep.loads:
        start, _ = boundary_velocity(sweep, PRESETS["standard"], load, middle)
        start, _ = boundary_velocity(sweep, _NEARLY, load, start)
        exponent = exponent_at(sweep, _NEARLY, load, start)
        present, _ = boundary_velocity(sweep, TRUTH, load, start, exponent=exponent)
        ratio = heat_of_the_past(sweep, load, present)
        lower = present * math.exp(-math.log(ratio) / exponent)
        by_present[load] = present
        by_all[load], _ = boundary_velocity(sweep, TRUTH, load, lower, ratio, exponent)
    return by_present, by_all


def exponents(sweep, true):
    """d ln(rise)/d ln(velocity) at each load of a true boundary."""
    return {load: exponent_at(sweep, PRESETS["draft"], load, true[load]) for load in true}


def boundaries(sweep, fidelity, true, known=None):
    """Velocity at each load by a fidelity, sought from the true one; and the kinds of warnings.

    Fewer points are looked at where the exponents are known.
    """
    known = known or {}
    found = {
        at: boundary_velocity(sweep, fidelity, at, true[at], 1.0, known.get(at)) for at in true
    }
    kinds = {kind for _, each in found.values() for kind in each}
    return {at: velocity for at, (velocity, _) in found.items()}, sorted(kinds)


def largest_error(found, true):
    """Largest relative error of a boundary at any load."""
    return max(abs(math.log(found[load] / velocity)) for load, velocity in true.items())

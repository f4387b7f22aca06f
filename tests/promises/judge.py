"""The true boundary of a scene, and how far a fidelity is from it.

A boundary is a velocity at each place: a load, and the surface where there are several.
"""

import math
from dataclasses import replace

from pipeline.sweep.severity import momentary_rise, rise_limit
from pipeline.tradeoff.probe import Target
from tests.helpers.entries import changed
from tests.promises.scenes import state_at
from tribo import PRESETS, warnings

# The preset `reference` with half the tolerances. Its rise is mostly within 0.02 % of that with
# 400 steps; if whole rows of elements wear heavily, within 0.2 %.
TRUTH = replace(PRESETS["reference"], contact_tolerance=5e-6)
_NEARLY = replace(TRUTH, increments=12, contact_tolerance=1e-4)
_CLOSE = 5e-4  # relative tolerance of a boundary velocity
_APART = 0.03  # step of ln(velocity) for the exponent
_SMALL_STEP = 5e-3  # step of ln(velocity) over which a known exponent is exact enough


def places(sweep):
    """Loads and variants of a sweep at which its boundary is judged."""
    return [Target(load, variant) for variant in sweep.variants.names for load in sweep.loads]


def rise_at(sweep, fidelity, place, velocity):
    """Deciding rise [K] at a place and velocity, and the point's warnings."""
    scene = changed(sweep.take_case(place.variant), fidelity=fidelity).scene
    state = state_at(scene, place.load, velocity)
    return momentary_rise(scene, state, sweep.conditions), warnings(scene, state)


def boundary_velocity(sweep, fidelity, place, velocity, exponent=None):
    """Velocity at which the deciding rise reaches its limit, by secants, and kinds of warnings.

    With a known exponent d ln(rise)/d ln(velocity) a last small step is not checked.
    """
    limit, before = rise_limit(sweep.conditions), None
    trusted, exponent = exponent is not None, exponent or 0.6
    for _ in range(12):
        rise, warnings = rise_at(sweep, fidelity, place, velocity)
        short = math.log(rise / limit)
        if before is not None and abs(math.log(velocity / before[0])) > 1e-6:
            slope = (short - before[1]) / math.log(velocity / before[0])
            exponent = min(max(slope, 0.2), 2.0)
        before = velocity, short
        if abs(short / exponent) < _CLOSE:
            break
        velocity *= math.exp(-short / exponent)
        if trusted and abs(short / exponent) < _SMALL_STEP:
            break
    return velocity, sorted({warning.kind.label for warning in warnings})


def exponent_at(sweep, fidelity, place, velocity):
    """Exponent d ln(rise)/d ln(velocity) about a velocity."""
    low, high = (
        rise_at(sweep, fidelity, place, velocity * math.exp(sign * _APART))[0] for sign in (-1, 1)
    )
    return min(max(math.log(high / low) / (2 * _APART), 0.2), 2.0)


def true_boundary(sweep):
    """True boundary velocity at each place.

    The search begins with an eighth of the steps, so that few full simulations are needed.
    """
    middle, found = math.sqrt(sweep.velocities[0] * sweep.velocities[-1]), {}
    for place in places(sweep):
        start, _ = boundary_velocity(sweep, PRESETS["standard"], place, middle)
        start, _ = boundary_velocity(sweep, _NEARLY, place, start)
        exponent = exponent_at(sweep, _NEARLY, place, start)
        found[place], _ = boundary_velocity(sweep, TRUTH, place, start, exponent)
    return found


def exponents(sweep, true):
    """Exponent d ln(rise)/d ln(velocity) at each place of a true boundary."""
    return {place: exponent_at(sweep, PRESETS["standard"], place, true[place]) for place in true}


def boundaries(sweep, fidelity, true, slopes):
    """Boundary velocity at each place by a fidelity, sought from the true one; kinds of warnings.

    The slopes are the `exponents` at the places.
    """
    results = {
        place: boundary_velocity(sweep, fidelity, place, true[place], slopes[place])
        for place in true
    }
    kinds = {kind for _, labels in results.values() for kind in labels}
    return {place: velocity for place, (velocity, _) in results.items()}, sorted(kinds)


def largest_error(velocities, true):
    """Largest |ln(velocity/true velocity)| of a boundary over all places."""
    return max(abs(math.log(velocities[place] / velocity)) for place, velocity in true.items())

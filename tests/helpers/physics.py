"""An independent proof that the states of a point obey the physics."""

from dataclasses import replace
from itertools import product

import numpy as np

from tribo import Wear, contact_modulus
from tribo.contact import ElasticHalfSpace
from tribo.loading import LoadStep
from tribo.simulation import start
from tribo.simulation.disk_positions import passes, separation_at

EPSILON = np.finfo(float).eps


def assert_sound(scene, before, state, normal_load):
    """Assert that a state obeys the physics, without using the simulation's own checks."""
    fields = [state.pressure, state.wear_depth]
    if state.heat:
        heat = state.heat
        fields += [heat.rise, heat.rise_quantile, np.array([heat.max_rise, heat.mean_rise])]
        assert (np.diff(heat.rise_quantile) >= 0).all()
    assert all(np.isfinite(field).all() for field in fields)
    scene = next(level for level in scene.levels() if level.grid.shape == state.pressure.shape)
    p, grid = state.pressure, scene.grid
    assert p.min() >= 0
    assert p.max() <= scene.hardness
    assert state.wear_depth.min() >= 0
    carried = p.sum() * grid.element_area * scene.pin.windows(grid)
    assert abs(carried - state.normal_load) <= 1e-9 * state.normal_load
    assert state.normal_load <= normal_load * (1 + 1e-12)
    if state.normal_load:
        positions = separations(scene, before, state)
        assert any(is_complementary(scene, before, state, separation) for separation in positions)


def separations(scene, before, state):
    """Yield the separation of the surfaces as it is, and at each position of the disk in a step."""
    yield scene.separation(scene.heights())
    if scene.wears_by_strips and not state.is_requested:  # at one of the positions of the disk
        distance = state.sliding_distance - (before.sliding_distance if before else 0.0)
        begin = before or start(scene)
        step = LoadStep(state.normal_load, state.time, True, state.index, state.impulse)
        wear, velocity = Wear(1e-15), distance / (state.time - begin.time)
        for scheme, sign, part in product(("sdirk2", "implicit"), (1, -1), range(12)):
            step = replace(step, part=part)
            *_, last = passes(scene, begin, step, wear, sign * velocity, False, scheme)
            yield separation_at(scene, last.shift, last.strip_shifts)


def is_complementary(scene, before, state, separation):
    """Whether pressure and gap fulfil the contact conditions, with a separation of the disk."""
    p = state.pressure
    solid = ElasticHalfSpace(scene.grid, contact_modulus(scene.pin.material, scene.disk))
    z = separation + state.wear_depth
    heights = np.abs(separation[p > 0]).max() + np.abs(z[p > 0]).max()
    z = z - z[p > 0].mean()
    gap = solid(p) + z
    free = (p > 0) & (p < scene.hardness)
    if free.any():
        gap -= gap[free].mean()
    else:
        top = gap[p > 0].max()
        gap -= (top + max(top, gap[p == 0].min())) / 2 if (p == 0).any() else top
    unit = solid.self_influence
    if scene.wear and (scene.wear.pattern == "local" or scene.grid.shape[1] == 1):
        step = state.sliding_distance - (before.sliding_distance if before else 0.0)
        unit += scene.wear.specific_wear_rate * step
    violation = max(
        np.abs(gap[free]).max(initial=0.0),
        -gap[p == 0].min(initial=0.0),
        gap[p == scene.hardness].max(initial=0.0),
    )
    rounding = 1e3 * EPSILON * (np.abs(solid(p)).max() + heights)
    return violation <= 1.01 * scene.fidelity.contact_tolerance * unit * p.max() + rounding

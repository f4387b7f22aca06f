"""Friction by temperature on systems of the campaigns, beside a plain iteration with damping."""

import dataclasses

import numpy as np
import pytest

import tribo
from tests.promises.families import cases
from tribo.simulation.coupled_friction import coupled_heat
from tribo.simulation.temperature import bodies_at, refined_scene
from tribo.thermal import contact_quantiles, partition_heat

SYSTEMS = {
    case.name: case
    for case in cases([0])
    if case.family in ("coarse pixels", "lay", "twin disc", "local", "wide summits")
}
_CLOSE = 0.3  # promised error [K]
_STEP, _STILL, _MOST = 0.3, 1e-2, 200  # damping, last change [K], most rounds


def line(bulk, slope):
    """Friction curve over 150 K that changes linearly, by `slope` per kelvin."""
    return ((bulk, 1.0), (bulk + 150.0, 1.0 + 150.0 * slope))


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    """Scene, velocity, bulk temperature and last state of each system, by name."""
    folder, found = tmp_path_factory.mktemp("systems"), {}
    for name, case in SYSTEMS.items():
        sweep = case.sweep(folder, preset="draft")
        load, velocity = sweep.plane.loads[1], sweep.plane.velocities[1]
        *_, state = tribo.simulate(sweep.scene, load, velocity)
        found[name] = sweep.scene, velocity, sweep.conditions.bulk_temperature, state
    return found


def iterated(scene, state, velocity, law, bulk):
    """Rise [K] exceeded by a tenth of the contact, by plain iteration in small steps."""
    scene = refined_scene(scene, state)
    contact, (pin, disk) = state.pressure > 0, bodies_at(scene, state, velocity)
    heat = abs(velocity) * state.pressure
    rise = np.zeros(contact.shape)
    for _ in range(_MOST):
        flux = law.at(velocity, bulk + rise) * heat
        change = partition_heat(pin, disk, flux, contact, tolerance=1e-5).rise - rise
        rise += _STEP * change
        if np.abs(change)[contact].max() < _STILL:
            break
    else:
        pytest.fail("the plain iteration did not end")
    rows = scene.rows_per_element
    quantiles = contact_quantiles(rise.repeat(rows, 1), contact.repeat(rows, 1))
    return quantiles[tribo.QUANTILES.index(0.9)]


@pytest.mark.parametrize("slope", [0.002, -0.005])
@pytest.mark.parametrize("name", SYSTEMS)
def test_straight_lines_are_solved_on_all_systems(states, name, slope):
    scene, velocity, bulk, state = states[name]
    state = dataclasses.replace(state, passing=())
    # Friction by which a tenth of the contact is warmed by more than about 100 K.
    coefficient = 100.0 / state.heat.rise_quantile[tribo.QUANTILES.index(0.9)]
    law = tribo.Friction(coefficient, by_temperature=line(bulk, slope))
    found = coupled_heat(scene, state, velocity, law, bulk)
    assert found.outcome == "solved"
    expected = iterated(scene, state, velocity, law, bulk)
    assert found.rise_quantile[tribo.QUANTILES.index(0.9)] == pytest.approx(expected, abs=_CLOSE)
    assert abs(expected - 100.0) > 10 * _CLOSE

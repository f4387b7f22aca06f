"""Friction by velocity and temperature, beside fixed points that are iterated here."""

import numpy as np
import pytest

import tribo
from tests.helpers import tiny
from tribo.simulation.cache import heat_spectrum
from tribo.thermal import Conductor, contact_quantiles, partition_heat

BULK = 298.15
FALLING = ((298.15, 1.0), (350.0, 0.95), (450.0, 0.7))
RISING = ((320.0, 0.9), (420.0, 1.1))


def iterated(law, rise, bulk):
    """The fixed point T = T_b + µ(T) r by iteration from the bulk, damped."""
    nodes, factors = np.array(law.by_temperature).T
    temperature = np.full_like(rise, bulk)
    for _ in range(400):
        friction = law.coefficient * np.interp(temperature, nodes, factors)
        temperature = (temperature + bulk + friction * rise) / 2
    return temperature


@pytest.mark.parametrize("curve", [FALLING, RISING])
@pytest.mark.parametrize("bulk", [BULK, 340.0, 500.0])
def test_a_temperature_has_the_friction_that_makes_it(curve, bulk):
    law = tribo.Friction(0.12, by_temperature=curve)
    rise = np.linspace(0.0, 4000.0, 41)
    found = law.temperature(rise, bulk)
    np.testing.assert_allclose(found, iterated(law, rise, bulk), rtol=1e-9)
    limits = [law.limit(float(one), bulk) for one in found]
    np.testing.assert_allclose(limits, rise, rtol=1e-9, atol=1e-9)


def test_wear_is_severe_where_the_friction_at_the_limit_makes_more_heat():
    law = tribo.Friction(0.1, by_temperature=FALLING)
    at_limit = 0.1 * (0.95 - 0.25 * (418.15 - 350.0) / 100.0)
    assert law.limit(418.15, BULK) == pytest.approx(120.0 / at_limit, rel=1e-12)


def test_friction_that_runs_away_does_so_at_the_highest_rise_below():
    """From 350 to 360 K it grows fivefold: 518.5 K of rise reach 350 K, and more reach far more."""
    law = tribo.Friction(0.1, by_temperature=((350.0, 1.0), (360.0, 5.0)))
    before = (350.0 - BULK) / 0.1
    assert law.temperature(np.array([before]), BULK) == pytest.approx(350.0)
    assert law.temperature(before + 1.0, BULK) == pytest.approx(BULK + 0.5 * (before + 1.0))
    assert law.limit(360.0, BULK) == law.limit(400.0, BULK) == before


def test_both_forms_multiply_and_a_coefficient_scales_them():
    law = tribo.Friction(0.1, ((1.0, 1.2), (4.0, 0.8)), FALLING)
    assert law.at(1.0, 450.0) == pytest.approx(0.1 * 1.2 * 0.7)
    assert tribo.Friction(0.2, *(law.by_velocity, FALLING)).at(4.0, 298.0) == pytest.approx(0.16)
    assert law.at(velocity=4.0) == pytest.approx(0.08)
    assert law.at(temperature=350.0) == pytest.approx(0.095)
    assert [*tribo.FRICTIONS] == ["coefficient", "by_velocity", "by_temperature"]


@pytest.mark.parametrize("slope", [-0.005, -0.002, 0.002])
def test_beside_heat_with_the_friction_of_each_element_it_keeps_its_error(slope):
    """The heat of each element by its own temperature, partitioned anew until nothing changes."""
    sweep = tiny.sweep(fidelity={"history_coarsening": 1, "heat_model": "elapsed"})
    scene, velocity = sweep.scene, 1.5
    curve = ((BULK, 1.0), (BULK + 150.0, 1.0 + 150.0 * slope))
    parts = tribo.Corrections(friction=tribo.Friction(by_temperature=curve))
    oil = tribo.Conditions(
        friction=0.1, bulk_temperature=BULK, critical_temperature=418.15, corrections=parts
    )
    *_, state = tribo.simulate(scene, 600.0, velocity)
    contact, grid = state.pressure > 0, scene.grid
    bodies = [
        tribo.numerics.Convolution(grid, heat_spectrum(grid, body, (0.0, state.time), (1.0, 1.0)))
        for body in (
            Conductor(scene.pin.material, 0.0, scene.heated_length),
            Conductor(scene.disk, velocity, scene.heated_length),
        )
    ]
    temperature = np.full(grid.shape, BULK)
    for _ in range(60):
        friction = 0.1 * np.interp(temperature, *np.array(curve).T)
        flux = friction * velocity * state.pressure
        temperature = BULK + partition_heat(*bodies, flux, contact).rise
    exceeded = contact_quantiles(temperature, contact)[tribo.QUANTILES.index(0.9)]
    found = tribo.judge(scene, 600.0, velocity, oil).decisive_temperature
    change = abs(np.log(np.interp(exceeded, *np.array(curve).T)))
    assert abs((found - BULK) / (exceeded - BULK) - 1) < 0.14 * change
    constant = tribo.Conditions(friction=0.1, bulk_temperature=BULK)
    plain = tribo.judge(scene, 600.0, velocity, constant).decisive_temperature
    assert (found < plain) == (slope < 0)
    assert abs(plain - exceeded) > 5 * abs(found - exceeded)

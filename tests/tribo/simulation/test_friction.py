"""Friction by velocity and temperature, beside fixed points that are iterated here."""

import numpy as np
import pytest

import tribo

BULK = 298.15
FALLING = ((298.15, 1.0), (350.0, 0.95), (450.0, 0.7))
RISING = ((320.0, 0.9), (420.0, 1.1))


def iterated(law, rise, bulk):
    """Fixed point T = T_b + µ(T) r of the temperature, by damped iteration from the bulk."""
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


def test_where_friction_runs_away_a_little_more_rise_makes_a_contact_far_hotter():
    """Friction grows fivefold from 350 to 360 K: 518.5 K of rise give 350 K, twice it far more."""
    law = tribo.Friction(0.1, by_temperature=((350.0, 1.0), (360.0, 5.0)))
    before = (350.0 - BULK) / 0.1
    assert law.temperature(np.array([before]), BULK) == pytest.approx(350.0)
    assert law.temperature(2.0 * before, BULK) == pytest.approx(BULK + before)
    assert before < law.limit(360.0, BULK) < law.limit(400.0, BULK) < 2 * before


def test_each_rise_has_one_temperature_however_steep_friction_rises():
    law = tribo.Friction(0.1, by_temperature=((350.0, 1.0), (360.0, 5.0), (500.0, 0.5)))
    rise = np.geomspace(1.0, 1e5, 200)
    hot = law.temperature(rise, BULK)
    assert (np.diff(hot) > 0).all()
    np.testing.assert_allclose(law.limit(hot, BULK), rise, rtol=1e-9)


def test_steepness_is_the_exponent_with_which_friction_grows_above_the_bulk():
    """µ ∝ 1 + x with x = 0.004 (T − T_b) has the exponent x/(1 + x), largest at the upper end."""
    law = tribo.Friction(0.1, by_temperature=((BULK, 1.0), (BULK + 100.0, 1.4)))
    assert law.steepness(BULK, BULK + 50.0) == pytest.approx(0.2 / 1.2)
    assert law.steepness(BULK, BULK + 300.0) == pytest.approx(0.4 / 1.4)
    assert law.hottest(500.0, BULK) == pytest.approx(BULK + 0.14 * 500.0)
    assert tribo.Friction(0.1, by_temperature=FALLING).steepness(BULK, 450.0) == 0


def test_both_forms_multiply_and_a_coefficient_scales_them():
    law = tribo.Friction(0.1, ((1.0, 1.2), (4.0, 0.8)), FALLING)
    assert law.at(1.0, 450.0) == pytest.approx(0.1 * 1.2 * 0.7)
    assert tribo.Friction(0.2, *(law.by_velocity, FALLING)).at(4.0, 298.0) == pytest.approx(0.16)
    assert law.at(velocity=4.0) == pytest.approx(0.08)
    assert law.at(temperature=350.0) == pytest.approx(0.095)
    assert [*tribo.FRICTIONS] == ["coefficient", "by_velocity", "by_temperature"]

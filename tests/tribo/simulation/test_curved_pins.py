"""Balls and crowned pins: contact, heat, and wear that is swept along a free y."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.closed_forms import moving_ellipse_rise
from tests.helpers.scenes import STEEL
from tribo.analytic import hertz_ellipse
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.thermal import ConductingHalfSpace

E_STAR = tribo.contact_modulus(STEEL, STEEL)
K, KAPPA = STEEL.thermal_conductivity, STEEL.thermal_diffusivity
NINE_TENTHS = tribo.QUANTILES.index(0.9)


def ball(preset="standard", pattern="swept", side=4e-6, pixels=160, **fidelity):
    """Scene of a ball of radius 5 mm on a rough disk, in a window of 640 µm."""
    return tribo.Scene(
        pin=tribo.Ball(5e-3, STEEL),
        disk=STEEL,
        pixels=tribo.Grid((pixels, pixels), (side, side), (False, False)),
        loading=tribo.Ramp(150.0, 200.0),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 8e-6), 3),
        wear=tribo.Wear(1.2e-15, pattern),
        fidelity=replace(tribo.PRESETS[preset], **fidelity),
    )


@functools.cache
def end(scene, load=200.0, velocity=1.0):
    *_, state = tribo.simulate(scene, load, velocity)
    return state


def hot(state):
    return state.heat.rise_quantile[NINE_TENTHS]


@pytest.mark.parametrize("pin", [tribo.Ball(5e-3, STEEL), tribo.Crowned(5e-3, 45e-3, STEEL)])
def test_a_pin_that_is_all_worn_is_as_deep_as_the_cap_that_its_flat_cuts_off(pin):
    worn = pin.worn(0.0, 1e-13)
    assert worn.depth == pytest.approx(worn.width**2 / (8 * pin.radius))


def ellipse(half_x, half_y, elements=120):
    """Grid around an ellipse with half-axes a and b, and √(1 − x²/a² − y²/b²) on it."""
    sides = 2.4 * half_x / elements, 2.4 * half_y / elements
    grid = tribo.Grid((elements, elements), sides, (False, False))
    x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
    return grid, np.sqrt(np.maximum(1 - (x / half_x) ** 2 - (y / half_y) ** 2, 0.0))


@pytest.mark.parametrize("radii", [(5e-3, 5e-3), (20e-3, 5e-3), (5e-3, 0.2)])
def test_a_crowned_contact_is_the_ellipse_of_hertz(radii):
    expected = hertz_ellipse(200.0, *radii, E_STAR)
    grid, _ = ellipse(expected.half_x, expected.half_y)
    separation = tribo.Crowned(*radii, STEEL).profile(grid)
    contact = solve_contact(ElasticHalfSpace(grid, E_STAR), separation, 200.0, tolerance=1e-7)
    p = contact.pressure
    assert contact.approach == pytest.approx(expected.approach, rel=1e-3)
    assert p.max() == pytest.approx(expected.peak_pressure, rel=1e-3)
    # For Hertz's pressure ∫x²p = Fa²/5, which gives the half-axes better than counted elements.
    for axis, half in ((0, expected.half_x), (1, expected.half_y)):
        square = np.moveaxis(grid.coordinates(axis)[:, None] ** 2 * np.ones((1, 120)), 0, axis)
        assert math.sqrt(5 * np.sum(square * p) / p.sum()) == pytest.approx(half, rel=1e-3)


@pytest.mark.parametrize("peclet_number", [0.0, 1.0, 10.0, 3000.0])
@pytest.mark.parametrize(("half_x", "half_y"), [(1e-4, 1e-4), (1e-4, 1e-3), (1e-3, 1e-4)])
def test_the_flash_temperature_of_an_ellipse_is_exact(half_x, half_y, peclet_number):
    grid, shape = ellipse(half_x, half_y)
    velocity = peclet_number * 2 * KAPPA / half_x
    rise = ConductingHalfSpace(grid, STEEL, velocity, 1e4)(1e9 * shape).max()
    expected = moving_ellipse_rise(1e9, half_x, half_y, velocity, K, KAPPA)
    assert rise == pytest.approx(expected, rel=5e-4)  # 100 elements an axis: 3e-4


def test_a_ball_swept_over_is_hotter_than_one_that_fits_its_patch():
    """A ball that always meets new summits does not conform to them by wear."""
    # True value: the mean over many more patches than the scene uses, each worn locally.
    few = {"pixels": 96, "side": 640e-6 / 96}
    true = hot(end(ball(fewest_elements=0, pixels_per_element=1, increments=20, **few)))
    swept, patch = ball(**few), ball(pattern="local", **few)
    of_ball, of_patch = end(swept), end(patch)
    assert hot(of_ball) == pytest.approx(true, rel=0.01)
    assert hot(of_patch) < 0.96 * true
    worn, fitted = tribo.measures(swept, of_ball), tribo.measures(patch, of_patch)
    assert fitted["contact_fraction"] > 1.6 * worn["contact_fraction"]


def test_a_smooth_pin_wears_swept_as_it_wears_locally():
    # Without roughness each point of the pin wears by the pressure on it.
    swept, local = (
        end(replace(ball(pattern=pattern), pin=tribo.Crowned(5e-3, 10e-3, STEEL), roughness=None))
        for pattern in ("swept", "local")
    )
    assert np.array_equal(swept.wear_depth, local.wear_depth)
    assert np.array_equal(swept.heat.rise, local.heat.rise)

"""Estimated error of the present heat (tribo/simulation/elapsed_heat.py)."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from tests.helpers.closed_forms import uniform_flux_rise
from tests.helpers.scenes import STEEL, last, small_scene
from tests.promises import duhamel
from tribo import Ball, Grid, Material, MeasuredLoad, Ramp, Wear
from tribo.simulation.elapsed_heat import elapsed_heat_excess
from tribo.thermal import ConductingHalfSpace, partition_heat, rise_exceeded

# The closed form depends neither on width nor on shape of the contact.
WITHIN = pytest.approx(1.0, abs=0.2)
WORN = small_scene(increments=20, contact_tolerance=1e-4)
BALL = replace(
    WORN,
    pin=Ball(8e-3, STEEL),
    pixels=Grid((40, 56), (8e-6, 8e-6), (False, False)),
    loading=Ramp(10.0, 20.0),
    wear=None,
)
ALUMINA = Material(
    elastic_modulus=310e9,
    poisson_ratio=0.25,
    hardness=20e9,
    thermal_conductivity=25.0,
    density=3900.0,
    specific_heat=780.0,
)


def with_(scene, **choices):
    return replace(scene, fidelity=replace(scene.fidelity, **choices))


def hottest_tenth(state):
    return float(rise_exceeded(state.heat.rise_quantile, 0.1))


def true_excess(scene, load, velocity):
    """Relative excess of the rise with present heat only over that with all heat so far."""
    present, by_all = duhamel.rises(scene, load, velocity)
    return 1 - by_all / present


# The truth: `tests.promises.duhamel`


def test_any_broken_line_of_flux_is_the_sum_of_its_ramps():
    plane, rng = Grid((3, 4), (1.632e-6, 1.9e-6), (True, True)), np.random.default_rng(4)
    times = np.cumsum(rng.uniform(0.01, 1.0, size=5))
    strengths = rng.uniform(-1e6, 2e6, size=5)
    bodies = duhamel.Conductor(STEEL), duhamel.Conductor(STEEL, velocity=1.25)
    fluxes = [np.full(plane.shape, flux) for flux in strengths]
    everywhere = [np.ones(plane.shape, bool) for _ in times]
    split = duhamel.divide_heat(plane, bodies, times, fluxes, everywhere)
    corners = np.concatenate(([0.0], times))
    slopes = np.diff(np.concatenate(([0.0], strengths / 2))) / np.diff(corners)
    exact = sum(  # each change of slope begins a ramp, which lasts to the end
        2 / 3 * uniform_flux_rise(change * age, age, STEEL.thermal_effusivity)
        for age, change in zip(
            times[-1] - corners[:-1], np.diff(np.concatenate(([0.0], slopes))), strict=True
        )
    )
    scale = uniform_flux_rise(1e6, times[-1], STEEL.thermal_effusivity)
    np.testing.assert_allclose(split.rise, exact, rtol=0, atol=1e-4 * scale)


def test_a_constant_flux_in_many_steps_is_one_that_acted_all_the_time():
    grid = Grid((24, 8), (20e-6, 20e-6))
    flux = np.zeros(grid.shape)
    flux[10:14, 2:5] = 1e8
    bodies = [duhamel.Conductor(STEEL, velocity, 1e-3) for velocity in (0.0, 0.3)]
    times = 1e-9, 0.01, 0.2, 0.5, 1.7
    split = duhamel.divide_heat(grid, bodies, times, [flux] * 5, [flux > 0] * 5)
    elapsed = partition_heat(
        *(ConductingHalfSpace(grid, *body[:2], times[-1], length=body.length) for body in bodies),
        flux,
        flux > 0,
    )
    # The division of the flux differs a little, as heat is older or younger by part of a step.
    assert split.rise.max() == pytest.approx(elapsed.rise.max(), rel=2e-3)
    assert split.pin_share == pytest.approx(elapsed.pin_share, rel=5e-3)


# The estimate


def test_it_is_the_integral_of_its_formula():
    """Heat that was missing while the load grew, over its age τ, with each body's share twice."""
    state = last(WORN, 600.0, 0.001)
    steps = list(WORN.all_load_steps(600.0))
    times, loads = (
        [0.0, *(getattr(load_step, n) for load_step in steps)] for n in ("time", "normal_load")
    )
    both, share = WORN.velocities_at(0.001), state.heat.pin_heat_share

    def warming(age):
        missing, length = 1 - np.interp(times[-1] - age, times, loads) / 600.0, WORN.heated_length
        return missing * sum(
            part**2
            * math.erf(length / (4 * math.sqrt(body.thermal_diffusivity * age)))
            * math.exp(-(velocity**2) * age / (4 * body.thermal_diffusivity))
            / (2 * math.pi * body.thermal_conductivity * age)
            for part, body, velocity in (
                (share, WORN.pin.material, both.pin),
                (1 - share, WORN.disk, both.disk),
            )
        )

    excess, _ = quad(warming, 0, times[-1], limit=500, epsrel=1e-8)
    expected = 600.0 * 0.001 / WORN.pin.length * excess / hottest_tenth(state)
    assert elapsed_heat_excess(WORN, state) == pytest.approx(expected, rel=1e-3)


def test_a_load_that_jumps_at_once_makes_hardly_any():
    at_once = replace(
        WORN, loading=MeasuredLoad(np.array([0.0, 1e-9, 5.0]), np.array([0.0, 599.0, 600.0]))
    )
    assert abs(elapsed_heat_excess(at_once, last(at_once, 600.0, 0.001))) < 1e-3


def test_a_load_that_jumps_late_errs_by_far_more_than_one_that_grows():
    jumping = MeasuredLoad(np.array([0.0, 1.0, 30.0, 30.1]), np.array([0.0, 60.0, 60.0, 600.0]))
    late = with_(replace(WORN, loading=jumping), contact_tolerance=1e-3)
    true = true_excess(late, 600.0, 0.05)
    assert true > 0.1
    foretold = elapsed_heat_excess(late, last(late, 600.0, 0.05))
    assert 0.5 * true < foretold < 1.1 * true


@pytest.mark.parametrize(
    ("scene", "load", "velocity"),
    [
        (small_scene(roughness=False, increments=20), 600.0, 0.001),
        (WORN, 600.0, 1.0),
        (replace(WORN, loading=Ramp(150.0, 750.0, hold=2.0)), 600.0, 0.001),
        (replace(WORN, disk=ALUMINA, wear=Wear(1.2e-14, "local")), 600.0, 0.001),
        (BALL, 20.0, 1.0),
    ],
    ids=["smooth", "worn", "hold", "alumina", "ball"],
)
def test_the_error_of_the_present_heat_is_foretold(scene, load, velocity):
    foretold = elapsed_heat_excess(scene, last(scene, load, velocity))
    assert foretold / true_excess(scene, load, velocity) == WITHIN

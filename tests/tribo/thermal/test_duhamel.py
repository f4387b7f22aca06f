"""Heat partition with all earlier heat (tribo/thermal/duhamel.py), against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, last, small_scene
from tribo import Grid, MeasuredLoad, Ramp, simulate
from tribo.analytic import ramped_flux_rise, uniform_flux_rise
from tribo.numerics import Convolution
from tribo.thermal import (
    ConductingHalfSpace,
    Conductor,
    HeatHistory,
    partition_heat,
    partition_with_history,
)
from tribo.thermal.conduction import flux_history_spectrum

EFFUSIVITY = STEEL.thermal_effusivity
ELEMENT = (1.632e-6, 1.9e-6)
PLANE = Grid((3, 4), ELEMENT, (True, True))


def run(grid, fluxes, times, pin_velocity=0.0, disk_velocity=1.25):
    pin, disk, past = Conductor(STEEL, pin_velocity), Conductor(STEEL, disk_velocity), HeatHistory()
    for time, flux in zip(times, fluxes, strict=True):
        split, past = partition_with_history(grid, pin, disk, past, time, flux, flux != 0)
    return split, past


def test_any_broken_line_of_flux_is_the_sum_of_its_ramps():
    rng = np.random.default_rng(4)
    times = np.cumsum(rng.uniform(0.01, 1.0, size=10))
    strengths = rng.uniform(-1e6, 2e6, size=10)
    split, _ = run(PLANE, [np.full(PLANE.shape, flux) for flux in strengths], times)
    corners = np.concatenate(([0.0], times))
    slopes = np.diff(np.concatenate(([0.0], strengths / 2))) / np.diff(corners)
    exact = sum(  # each change of slope begins a ramp, which lasts to the end
        ramped_flux_rise(change * (times[-1] - corner), times[-1] - corner, EFFUSIVITY)
        for corner, change in zip(corners, np.diff(np.concatenate(([0.0], slopes))), strict=False)
    )
    scale = uniform_flux_rise(1e6, times[-1], EFFUSIVITY)
    np.testing.assert_allclose(split.rise, exact, rtol=0, atol=1e-8 * scale)  # ages have 9 digits


def test_the_contact_has_one_temperature_by_all_the_heat_so_far():
    grid = Grid((30, 12), (10e-6, 10e-6))
    bodies = Conductor(STEEL, 0.0), Conductor(STEEL, 0.3)
    times, past = (2e-4, 3e-4, 7e-4), HeatHistory()
    fluxes = [np.zeros(grid.shape) for _ in times]
    for size, flux in enumerate(fluxes, start=4):
        flux[12 - size : 12 + size, :size] = 1e8 * size
    into_pin = []
    for time, flux in zip(times, fluxes, strict=True):
        split, past = partition_with_history(grid, *bodies, past, time, flux, flux > 0)
        into_pin.append(split.pin_flux)
    ages = [times[-1] - time for time in (0.0, *times)]
    rises = []
    for body, heat in ((bodies[0], into_pin), (bodies[1], np.subtract(fluxes, into_pin))):
        total = np.zeros(grid.shape)
        for step, flux in enumerate(heat, start=1):
            among = ages[step - 1 : step + 2][::-1]
            strengths = [0.0, 1.0, 0.0][-len(among) :] if len(among) == 3 else [1.0, 0.0]
            spectrum = np.zeros((len(past.pin_flux[-1]), 7), dtype=complex)
            hat = flux_history_spectrum(grid, body.material, body.velocity, among, strengths)
            spectrum[:, : hat.shape[1]] = hat
            total += Convolution(grid, spectrum)(flux)
        rises.append(total)
    # The solver's tolerance is 1e-8 of the right-hand side in the mean over the contact.
    on = fluxes[-1] > 0
    np.testing.assert_allclose(split.rise, rises[0], rtol=0, atol=1e-8 * rises[0].max())
    np.testing.assert_allclose(rises[0][on], rises[1][on], rtol=0, atol=1e-6 * rises[0].max())


def test_a_constant_flux_in_many_steps_is_one_that_acted_all_the_time_whatever_the_length():
    grid = Grid((24, 8), (20e-6, 20e-6))
    flux = np.zeros(grid.shape)
    flux[10:14, 2:5] = 1e8
    for length in (1e-3, "nearest-image"):
        bodies, past = [Conductor(STEEL, V, length) for V in (0.0, 0.3)], HeatHistory()
        for time in (1e-9, 0.01, 0.2, 0.5, 1.7):
            split, past = partition_with_history(grid, *bodies, past, time, flux, flux > 0)
        elapsed = partition_heat(
            *(ConductingHalfSpace(grid, *body[:2], time, length=length) for body in bodies),
            flux,
            flux > 0,
        )
        # The division of the flux differs a little, as heat is older or younger by part of a step.
        assert split.rise.max() == pytest.approx(elapsed.rise.max(), rel=2e-3)
        assert split.pin_share == pytest.approx(elapsed.pin_share, rel=5e-3)


def test_no_contact_has_no_temperature_but_goes_on():
    # The load of this record is 0 in the middle, where the pin cools.
    times, loads = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([0.0, 400.0, 0.0, 0.0, 500.0])
    scene = replace(
        small_scene(increments=4, heat_model="history", wear=False),
        loading=MeasuredLoad(times, loads),
    )
    states = list(simulate(scene, 500.0, 1.25))
    assert [state.heat is None for state in states] == [False, True, True, False]
    fresh = small_scene(increments=1, heat_model="history", wear=False)
    unloaded_before = last(replace(fresh, loading=Ramp(500.0, 500.0)), 500.0, 1.25)
    # Heat left by the first pulse warms the second one, by less than its own rise.
    assert 1 < states[-1].heat.mean_rise / unloaded_before.heat.mean_rise < 1.2
    assert math.isfinite(states[-1].heat.max_rise)

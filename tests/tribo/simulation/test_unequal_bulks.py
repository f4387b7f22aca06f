"""Bodies of unequal bulk temperature."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, small_scene
from tribo import (
    PRESETS,
    QUANTILES,
    Conditions,
    Cylinder,
    Fidelity,
    Grid,
    Motion,
    Ramp,
    Scene,
    judge,
    simulate,
)
from tribo.thermal import (
    BULK_RATIOS,
    ConductingHalfSpace,
    add_bulk_ratio,
    contact_quantiles,
    partition_heat,
)

NINE_TENTHS = QUANTILES.index(0.9)


def end(scene, velocity=1.25, load=750.0):
    *_, state = simulate(scene, load, velocity)
    return state


@pytest.fixture(scope="module")
def rough():
    """Scene and last state of a rough contact with 96 × 48 pixels."""
    scene = replace(
        small_scene(increments=3, contact_tolerance=1e-8),
        pixels=Grid((96, 48), (4e-6, 4e-6)),
        unequal_bulks=True,
    )
    return scene, end(scene)


@pytest.mark.parametrize("conductivity", [45.0, 5.0])
def test_fast_bodies_meet_at_the_temperature_of_two_half_spaces(conductivity):
    """Points of both bodies have been in contact for x/u, as if e√u were their effusivities."""
    slow = replace(STEEL, thermal_conductivity=conductivity, hardness=math.inf)
    scene = Scene(
        pin=Cylinder(2e-3, 3.4e-3, slow),
        disk=replace(STEEL, hardness=math.inf),
        pixels=Grid((120, 1), (2e-6, 456e-6)),
        loading=Ramp(150.0, 750.0),
        motion=Motion(slide_roll_ratio=0.5),
        unequal_bulks=True,
        fidelity=Fidelity(increments=1, pixels_per_element=1, contact_tolerance=1e-7),
    )
    state = end(scene, velocity=200.0)
    velocities = scene.velocities_at(200.0)
    pin, disk = (
        body.thermal_effusivity * math.sqrt(u)
        for body, u in zip((slow, STEEL), velocities, strict=True)
    )
    inside = state.heat.bulk_response[state.pressure > 0]
    # At the leading edge some heat is conducted ahead.
    assert inside == pytest.approx(disk / (pin + disk), abs=2e-3)
    assert state.heat.mean_bulk_response == pytest.approx(inside.mean())


@pytest.mark.parametrize(("friction", "difference"), [(0.05, -60.0), (0.0, 20.0)])
def test_the_temperature_is_affine_in_friction_and_difference(rough, friction, difference):
    scene, state = rough
    contact = state.pressure > 0
    pin, disk = (
        ConductingHalfSpace(scene.grid, STEEL, V, state.time, length=scene.heated_length)
        for V in (0.0, 1.25)
    )
    split = partition_heat(
        pin,
        disk,
        friction * 1.25 * state.pressure,
        contact,
        tolerance=1e-9,
        bulk_difference=difference,
    )
    affine = friction * state.heat.rise + difference * state.heat.bulk_response
    assert affine[contact] == pytest.approx(split.rise[contact], abs=1e-6)


def test_the_rise_is_the_same_with_the_response_and_without_bit_for_bit():
    scene = small_scene()
    scene = replace(scene, pixels=Grid((96, 64), (4e-6, 4e-6)), fidelity=PRESETS["standard"])
    alone, both = end(scene).heat, end(replace(scene, unequal_bulks=True)).heat
    assert np.array_equal(alone.rise, both.rise)
    assert np.array_equal(alone.rise_quantile, both.rise_quantile)
    assert alone.bulk_response is None
    assert alone.bulk_rise_quantile is None


def quantiles_at(heat, ratio):
    return add_bulk_ratio(heat.columns, ratio)["rise_quantile"]


def test_quantiles_are_exact_at_the_kept_ratios_and_near_between(rough):
    _, state = rough
    heat, contact = state.heat, state.pressure > 0

    def exact(ratio):
        return contact_quantiles(heat.rise + ratio * heat.bulk_response, contact)

    for ratio in (0.0, *BULK_RATIOS):
        assert quantiles_at(heat, ratio) == pytest.approx(exact(ratio), rel=1e-12)
    scale = heat.mean_rise
    ratios = np.linspace(-1000.0, 1000.0, 41)
    errors = np.array([(quantiles_at(heat, r) - exact(r)) / scale for r in ratios])
    assert np.abs(errors[:, NINE_TENTHS]).max() < 3e-3
    assert np.abs(errors).max() < 2e-2
    assert (errors[:, -1] > -1e-12).all()  # the maximum is convex: never too cold


@pytest.mark.parametrize("heat_model", ["elapsed", "history"])
def test_without_motion_or_friction_the_difference_alone_warms(heat_model):
    for velocity, friction_heat in ((0.0, True), (1.25, False)):
        scene = small_scene(wear=False, heat_model=heat_model)
        scene = replace(scene, friction_heat=friction_heat, unequal_bulks=True)
        heat = end(scene, velocity).heat
        assert not heat.rise.any()
        assert 0.3 < heat.mean_bulk_response < 1.0
        kelvins = quantiles_at(heat, BULK_RATIOS[-1]) / BULK_RATIOS[-1]
        assert 0.0 < kelvins[0] <= kelvins[-1] < 1.0


def test_a_verdict_knows_both_bulk_temperatures(rough):
    scene, state = rough
    oil = Conditions(friction=0.1, bulk_temperature=333.15, disk_temperature=283.15)
    expected = 333.15 + 0.1 * quantiles_at(state.heat, -500.0)[NINE_TENTHS]
    judged = judge(replace(scene, unequal_bulks=False), 750.0, 1.25, oil)
    assert judged.deciding_temperature == pytest.approx(expected, rel=1e-12)

"""Properties that hold for every scene, tried on random ones."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.scenes import last
from tribo import (
    Cylinder,
    Fidelity,
    Grid,
    Material,
    MeasuredRoughness,
    Ramp,
    Scene,
    SelfAffineRoughness,
    Wear,
    simulate,
)
from tribo.simulation import RampCache

few = settings(deadline=None, derandomize=True, max_examples=6)

TOLERANCE = 1e-9


@st.composite
def materials(draw):
    return Material(
        elastic_modulus=draw(st.floats(1e9, 1e12)),
        poisson_ratio=draw(st.floats(0.0, 0.5)),
        thermal_conductivity=draw(st.floats(0.2, 400.0)),
        density=draw(st.floats(900.0, 2e4)),
        specific_heat=draw(st.floats(100.0, 3000.0)),
        hardness=draw(st.floats(5e7, 2e10)),
    )


@st.composite
def scenes(draw):
    """Strategy for random rough line contacts, solved to 1e-9, each with a load it can carry."""
    nx, ny = draw(st.integers(6, 40)), draw(st.integers(2, 20))
    dx = draw(st.floats(5e-7, 1e-5))
    pixels = Grid((nx, ny), (dx, dx * draw(st.floats(0.5, 2.0))))
    pin, disk = draw(materials()), draw(materials())
    length = 3.4e-3
    capacity = min(pin.hardness, disk.hardness) * pixels.size[0] * length
    load = capacity * draw(st.floats(1e-3, 0.6))
    rate = load / draw(st.floats(0.1, 10.0))
    pattern = draw(st.sampled_from(["local", "swept"]))
    amount = draw(st.floats(0.0, 1e-14))
    return load, Scene(
        pin=Cylinder(draw(st.floats(5e-4, 5e-2)), length, pin),
        disk=disk,
        pixels=pixels,
        loading=Ramp(rate, load),
        roughness=SelfAffineRoughness(
            draw(st.floats(1e-8, 1e-6)), draw(st.floats(0.3, 1.0)), (3 * dx, 3 * dx),
            draw(st.integers(0, 1000)),
        ),
        wear=Wear(amount, pattern),
        fidelity=Fidelity(
            pixels_per_element=1, increments=3, contact_tolerance=TOLERANCE
        ),
    )  # fmt: skip


def assert_alike(first, second, tolerance=1e-5):
    """Assert equal pressures and rises, within `tolerance` of their maximum."""
    p = first.pressure
    assert second.pressure == pytest.approx(p, abs=tolerance * p.max())
    rise = first.heat.rise
    assert second.heat.rise == pytest.approx(rise, abs=tolerance * max(rise.max(), 1e-300))


@few
@given(scenes(), st.floats(0.2, 20.0), st.integers(-3, 3), st.integers(-3, 3))
def test_units_scale(drawn, velocity, length_power, force_power):
    # Units of length and force are scaled; seconds and kelvins stay.
    load, scene = drawn
    metre, newton = 10.0**length_power, 10.0**force_power
    stress = newton / metre**2

    def in_units(solid):
        return replace(
            solid,
            elastic_modulus=solid.elastic_modulus * stress,
            hardness=solid.hardness * stress,
            thermal_conductivity=solid.thermal_conductivity * newton,
            density=solid.density / metre**3,
            specific_heat=solid.specific_heat * newton * metre,
        )

    pixels = scene.pixels
    other = replace(
        scene,
        pin=Cylinder(
            scene.pin.radius * metre, scene.pin.length * metre, in_units(scene.pin.material)
        ),
        disk=in_units(scene.disk),
        pixels=Grid(pixels.shape, (pixels.spacing[0] * metre, pixels.spacing[1] * metre)),
        loading=Ramp(scene.loading.rate * newton, load * newton),
        roughness=replace(
            scene.roughness,
            ra=scene.roughness.ra * metre,
            correlation_length=tuple(metre * c for c in scene.roughness.correlation_length),
        ),
        wear=replace(scene.wear, specific_wear_rate=scene.wear.specific_wear_rate / stress),
    )
    here = last(scene, load, velocity)
    there = last(other, load * newton, velocity * metre)
    assert_alike(here, replace(there, pressure=there.pressure / stress))
    assert there.wear_depth / metre == pytest.approx(
        here.wear_depth, abs=1e-5 * max(here.wear_depth.max(), 1e-300)
    )


@few
@given(scenes(), st.floats(0.1, 20.0), st.integers(1, 19))
def test_translation_along_the_period_translates_everything(drawn, velocity, places):
    load, scene = drawn
    heights = scene.roughness.heights(scene.pixels)
    moved = replace(scene, roughness=MeasuredRoughness(np.roll(heights, places, 1)))
    here, there = (last(s, load, velocity) for s in (scene, moved))
    back = replace(
        there,
        pressure=np.roll(there.pressure, -places, 1),
        heat=replace(there.heat, rise=np.roll(there.heat.rise, -places, 1)),
    )
    assert_alike(here, back)


@few
@given(
    scenes(),
    st.floats(0.1, 20.0),
    st.lists(st.floats(0.05, 1.5), min_size=2, max_size=4),
    st.sampled_from([0, 100_000, 2**28]),
)
def test_neither_the_order_of_a_sweep_nor_its_cache_changes_a_bit(drawn, velocity, shares, limit):
    full, scene = drawn
    scene = replace(scene, loading=Ramp(scene.loading.rate, full), fidelity=replace(
        scene.fidelity, contact_tolerance=1e-4
    ))  # fmt: skip
    loads = sorted({share * full for share in shares})
    alone = {load: last(scene, load, velocity) for load in reversed(loads)}
    ramp_cache = RampCache(limit)
    for load in [*loads, *reversed(loads)]:
        states = list(simulate(scene, load, velocity, ramp_cache))
        assert np.array_equal(states[-1].pressure, alone[load].pressure)
        assert np.array_equal(states[-1].wear_depth, alone[load].wear_depth)
        assert np.array_equal(states[-1].heat.rise, alone[load].heat.rise)

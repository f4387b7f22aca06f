"""Properties that hold for every scene, tried on random ones."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import last
from tribo.simulation import RampCache

TOLERANCE = 1e-9
few = pytest.mark.parametrize("seed", range(6))


def material(rng):
    return tribo.Material(
        elastic_modulus=rng.uniform(1e9, 1e12),
        poisson_ratio=rng.uniform(0.0, 0.5),
        thermal_conductivity=rng.uniform(0.2, 400.0),
        density=rng.uniform(900.0, 2e4),
        specific_heat=rng.uniform(100.0, 3000.0),
        hardness=rng.uniform(5e7, 2e10),
    )


def drawn(seed):
    """Generator, and a random rough line contact, solved to 1e-9, with a load it can carry [N]."""
    rng = np.random.default_rng([seed, 5])
    dx = rng.uniform(5e-7, 1e-5)
    pixels = tribo.Grid(
        (rng.integers(6, 41), rng.integers(2, 21)), (dx, dx * rng.uniform(0.5, 2.0))
    )
    pin, disk = material(rng), material(rng)
    length = 3.4e-3
    capacity = min(pin.hardness, disk.hardness) * pixels.size[0] * length
    load = capacity * rng.uniform(1e-3, 0.6)
    scene = tribo.Scene(
        pin=tribo.Cylinder(rng.uniform(5e-4, 5e-2), length, pin),
        disk=disk,
        pixels=pixels,
        loading=tribo.Ramp(load / rng.uniform(0.1, 10.0), load),
        roughness=tribo.SelfAffineRoughness(
            rng.uniform(1e-8, 1e-6), rng.uniform(0.3, 1.0), (3 * dx, 3 * dx), seed
        ),
        wear=tribo.Wear(rng.uniform(0.0, 1e-14), rng.choice(["local", "swept"])),
        fidelity=tribo.Fidelity(pixels_per_element=1, increments=3, contact_tolerance=TOLERANCE),
    )
    return rng, load, scene


def assert_alike(first, second, tolerance=1e-5):
    """Assert equal pressures and rises, within `tolerance` of their maximum."""
    p = first.pressure
    assert second.pressure == pytest.approx(p, abs=tolerance * p.max())
    rise = first.heat.rise
    assert second.heat.rise == pytest.approx(rise, abs=tolerance * max(rise.max(), 1e-300))


@few
def test_units_scale(seed):
    # Units of length and force are scaled; seconds and kelvins stay.
    rng, load, scene = drawn(seed)
    velocity = rng.uniform(0.2, 20.0)
    metre, newton = 10.0 ** rng.integers(-3, 4, 2)
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
        pin=tribo.Cylinder(
            scene.pin.radius * metre, scene.pin.length * metre, in_units(scene.pin.material)
        ),
        disk=in_units(scene.disk),
        pixels=tribo.Grid(pixels.shape, (pixels.spacing[0] * metre, pixels.spacing[1] * metre)),
        loading=tribo.Ramp(scene.loading.rate * newton, load * newton),
        roughness=replace(
            scene.roughness,
            ra=scene.roughness.ra * metre,
            correlation_length=tuple(metre * c for c in scene.roughness.correlation_length),
        ),
        wear=replace(scene.wear, specific_wear_rate=scene.wear.specific_wear_rate / stress),
    )
    state = last(scene, load, velocity)
    scaled = last(other, load * newton, velocity * metre)
    assert_alike(state, replace(scaled, pressure=scaled.pressure / stress))
    assert scaled.wear_depth / metre == pytest.approx(
        state.wear_depth, abs=1e-5 * max(state.wear_depth.max(), 1e-300)
    )


@few
def test_neither_the_order_of_a_sweep_nor_its_cache_changes_a_bit(seed):
    rng, full, scene = drawn(seed)
    velocity, shares = rng.uniform(0.1, 20.0), rng.uniform(0.05, 1.5, rng.integers(2, 5))
    limit = (0, 100_000, 2**28)[seed % 3]
    fidelity = replace(scene.fidelity, contact_tolerance=1e-4)
    scene = replace(scene, loading=tribo.Ramp(scene.loading.rate, full), fidelity=fidelity)
    loads = sorted({share * full for share in shares})
    expected = {load: last(scene, load, velocity) for load in reversed(loads)}
    ramp_cache = RampCache(limit)
    for load in [*loads, *reversed(loads)]:
        states = list(tribo.simulate(scene, load, velocity, ramp_cache))
        assert np.array_equal(states[-1].pressure, expected[load].pressure)
        assert np.array_equal(states[-1].wear_depth, expected[load].wear_depth)
        assert np.array_equal(states[-1].heat.rise, expected[load].heat.rise)

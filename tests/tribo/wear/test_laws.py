"""Wear laws: the shipped example against its closed form, and laws that break their contract."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import small_scene

VELOCITY, LOAD = 1.25, 600.0


def worn_volume(scene, velocity=VELOCITY):
    *_, state = tribo.simulate(scene, LOAD, velocity)
    return tribo.measures(scene, state)["wear_volume"]


def ramped_volume(law, rate, velocity, load):
    """Worn volume ∫ F k dS under a load that grows in proportion to the sliding distance."""
    slid, L = velocity * load / rate, law.distance
    faded = L**2 - L * (L + slid) * math.exp(-slid / L)
    excess = law.initial_rate - law.final_rate
    return rate / velocity * (law.final_rate * slid**2 / 2 + excess * faded)


@dataclass(frozen=True)
class Dimples:
    depth: float = 1e-6
    spoilt: bool = False

    def heights(self, pixels):
        x, y = (np.arange(n) * d for n, d in zip(pixels.shape, pixels.spacing, strict=True))
        waves = np.cos(x[:, None] / 3e-5) * np.cos(y[None, :] / 3e-5)
        return np.where(self.spoilt & (waves > 0.99), np.nan, self.depth * waves)


def test_a_surface_of_one_s_own_is_that_of_its_heights():
    scene = small_scene(wear=False, increments=1)
    measured = tribo.MeasuredRoughness(Dimples().heights(scene.pixels))
    rises = []
    for surface in (Dimples(), replace(Dimples(), depth=2e-6), measured):
        *_, state = tribo.simulate(replace(scene, roughness=surface), LOAD, VELOCITY)
        rises.append(state.heat.mean_rise)
    assert rises[0] == pytest.approx(rises[2], rel=1e-6)
    assert rises[1] != pytest.approx(rises[0], rel=1e-3)

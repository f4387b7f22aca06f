"""A wear law and a surface of one's own (tribo/wear/archard.py)."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import small_scene

VELOCITY, LOAD = 1.25, 600.0


@dataclass(frozen=True)
class RunningIn:
    """A rate that falls from `initial_rate` to `final_rate`, exponentially over a `distance`."""

    initial_rate: float
    final_rate: float
    distance: float
    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        slid_fraction = (end - begin) / self.distance
        faded = -math.exp(-begin / self.distance) * math.expm1(-slid_fraction) / slid_fraction
        rate = self.final_rate + (self.initial_rate - self.final_rate) * faded
        return tribo.Wear(rate, self.pattern)


LAW = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=1.5)


def worn_volume(scene, velocity=VELOCITY):
    *_, state = tribo.simulate(scene, LOAD, velocity)
    return tribo.measures(scene, state)["wear_volume"]


def ramped_volume(law, rate, velocity, load):
    """Worn volume ∫ F k dS under a load that grows in proportion to the sliding distance."""
    slid, L = velocity * load / rate, law.distance
    faded = L**2 - L * (L + slid) * math.exp(-slid / L)
    excess = law.initial_rate - law.final_rate
    return rate / velocity * (law.final_rate * slid**2 / 2 + excess * faded)


def test_a_law_wears_off_what_its_closed_form_says():
    scene = replace(small_scene(increments=40), wear=LAW)
    expected = ramped_volume(LAW, scene.loading.rate, VELOCITY, LOAD)
    assert worn_volume(scene) == pytest.approx(expected, rel=2e-3)  # error of second order in steps


@dataclass(frozen=True)
class ByPressure:
    """A rate in proportion to the pressure, `rate` at a pressure of 1 Pa."""

    rate: float
    pattern: str = "local"

    def mean_wear(self, begin, end, pressure, velocity):
        return tribo.Wear(self.rate * pressure, self.pattern)


@dataclass(frozen=True)
class Hastened:
    """A rate that is a power of the sliding velocity, `rate` at 1 m/s."""

    rate: float
    exponent: float
    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        return tribo.Wear(self.rate * velocity**self.exponent, self.pattern)


def test_a_law_by_pressure_wears_alike_on_all_grids_of_the_last_step():
    """The last step is repeated on finer grids, each at the rate of the state before the step."""
    scene = small_scene(increments=6, history_coarsening=2)
    scene = replace(scene, wear=ByPressure(1e-24, "swept"))
    coarse, fine = (tribo.simulate(level, LOAD, VELOCITY) for level in scene.levels())
    depths = [[*states][-1].wear_depth.mean() for states in (coarse, fine)]
    assert depths[1] == pytest.approx(depths[0], rel=1e-9)


def test_a_law_by_velocity_is_archard_s_with_its_rate():
    velocity, law = 2.0, Hastened(1.2e-15, 0.5)
    archard = tribo.Wear(1.2e-15 * velocity**0.5)
    ramps = tribo.simulation.RampCache()
    scene = replace(small_scene(increments=6), wear=law)
    for other in (0.7, velocity):  # a ramp at another velocity is not shared
        *_, state = tribo.simulate(scene, LOAD, other, ramps)
    *_, constant = tribo.simulate(replace(scene, wear=archard), LOAD, velocity)
    np.testing.assert_allclose(state.wear_depth, constant.wear_depth, rtol=1e-9)
    assert state.heat.max_rise == pytest.approx(constant.heat.max_rise, rel=1e-9)


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


@dataclass(frozen=True)
class Recorded:
    """A constant rate; it records the pressures and velocities that it is called with."""

    calls: list = field(default_factory=list, compare=False, hash=False)
    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        self.calls.append((begin, pressure, velocity))
        return tribo.Wear(1.2e-15, self.pattern)


def test_a_law_sees_the_nominal_pressure_where_a_step_begins_and_the_velocity():
    law = Recorded()
    scene = replace(small_scene(increments=6), wear=law)
    known = {0.0: 0.0}
    for state in tribo.simulate(scene, LOAD, -VELOCITY):
        area = tribo.measures(scene, state)["contact_width"] * scene.pin.length
        known[state.sliding_distance] = state.normal_load / area
    seen = {begin: pressure for begin, pressure, _ in law.calls}
    assert len(seen.keys() & known.keys()) > 3
    for begin in seen.keys() & known.keys():
        assert seen[begin] == pytest.approx(known[begin], rel=1e-12)
    assert {velocity for *_, velocity in law.calls} == {VELOCITY}

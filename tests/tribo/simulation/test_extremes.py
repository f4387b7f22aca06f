"""Extremes: each ends soon, in a result that is proven or an error that says why."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.helpers.physics import assert_sound
from tests.helpers.scenes import STEEL, small_scene
from tribo import Ball, Grid, InputError, Material, MeasuredRoughness, Ramp, Wear, simulate
from tribo.errors import RangeError

SOLVED = "solved"

CAPACITY = 6.6e9 * 48 * 8e-6 * 3.4e-3  # load that the small scene's window carries [N]
SHAPE = (48, 16)


@dataclass(frozen=True)
class Extreme:
    """An extreme scene, and the expected outcome."""

    group: str
    label: str
    scene: Callable
    outcome: str = SOLVED
    error: type | None = None
    load: float = 600.0
    velocity: float = 1.25

    def run(self):
        """Simulate, and assert that each state obeys the physics; return scene and last state."""
        scene, before = self.scene(), None
        for state in simulate(scene, self.load, self.velocity):
            assert_sound(scene, before, state, self.load)
            before = state
        return scene, before


def changed(**parts):
    return lambda: replace(small_scene(), **parts)


def bodies(pin, disk, **parts):
    scene = small_scene()
    return lambda: replace(scene, pin=replace(scene.pin, material=pin), disk=disk, **parts)


def measured(heights):
    return changed(roughness=MeasuredRoughness(heights))


def lasting(seconds, load=600.0, **parts):
    return changed(loading=Ramp(load / seconds, 750.0), **parts)


MATERIALS = {
    "rubber (ν = 0.5)": Material(5e6, 0.5, 0.2, 1100.0, 1900.0, 1e7),
    "polymer": Material(2e9, 0.4, 0.2, 1200.0, 1500.0, 1e8),
    "aerogel": Material(1e5, 0.2, 0.015, 3.0, 1000.0, 1e5),
    "steel": STEEL,
    "ceramic": Material(400e9, 0.22, 30.0, 3900.0, 880.0, 15e9),
    "diamond": Material(1.1e12, 0.07, 2000.0, 3500.0, 500.0, 90e9),
}


def velocities():
    for velocity in (0.0, 1e-6, 1.0, 1e5, -1.25, -1e5):
        yield Extreme("velocity", f"{velocity:g} m/s", small_scene, velocity=velocity)
    shorter = (
        r"^tolerance is \S+; rounding allows no less than \S+ where rows of elements yield \S+ "
        r"times as much as one element does\. If wear makes them yield, use shorter steps$"
    )
    yield Extreme("velocity", "1e12 m/s", small_scene, shorter, InputError, velocity=1e12)
    yield Extreme("velocity", "1e100 m/s", small_scene, shorter, InputError, velocity=1e100)
    without_wear = changed(wear=None)
    yield Extreme("velocity", "1e30 m/s, no wear", without_wear, velocity=1e30)
    yield Extreme(
        "velocity", "1e300 m/s, no wear", without_wear, "too large or too small", RangeError,
        velocity=1e300,
    )  # fmt: skip


def loads():
    for share in (1e-12, 1e-6):
        load = share * 750.0
        yield Extreme("load", f"{share:g} of nominal", small_scene, load=load)
    for share, name in [(0.5, "0.5"), (0.999, "0.999"), (1 - 1e-9, "1 − 1e-9")]:
        ramp = Ramp(150.0, share * CAPACITY)
        yield Extreme("load", f"{name} H·A", changed(loading=ramp), load=share * CAPACITY)
    full = Ramp(150.0, CAPACITY)
    yield Extreme("load", "H·A: p = H", changed(loading=full), load=CAPACITY)
    beyond = 1.001 * CAPACITY
    yield Extreme(
        "load", "1.001 H·A", changed(loading=full), "the window carries", InputError, load=beyond
    )
    yield Extreme("load", "0", small_scene, "normal_load is 0", InputError, load=0.0)
    yield Extreme("load", "inf", small_scene, "normal_load is inf", InputError, load=math.inf)
    elastic = replace(STEEL, hardness=math.inf)
    yield Extreme(
        "load", "1e10 of nominal, no hardness", bodies(elastic, elastic, loading=Ramp(1e9, 7.5e12)),
        load=7.5e12,
    )  # fmt: skip
    yield Extreme(
        "load", "1e12 steps away", bodies(elastic, elastic), "at most 10000 are allowed",
        InputError, load=1e14,
    )  # fmt: skip


def wear():
    # 1e-13 m²/N wears 100 µm a step, 1e-6 m²/N 1 km
    for pattern, rate in itertools.product(("local", "swept"), (0.0, 1e-30, 1e-15, 1e-13, 1e-6)):
        name = f"{pattern} {rate:g} m²/N"
        yield Extreme("wear rate", name, changed(wear=Wear(rate, pattern)))


def times():
    for seconds in (1e-15, 1e-3, 1e9):
        yield Extreme("duration", f"{seconds:g} s", lasting(seconds))
        yield Extreme(
            "duration", f"{seconds:g} s at rest", lasting(seconds, roughness=None), velocity=0.0
        )


def grids():
    for shape in [(1, 1), (1, 16), (48, 1), (2, 2), (47, 17)]:
        pixels = Grid(shape, (8e-6, 8e-6))
        rough = None if shape == (1, 1) else small_scene().roughness
        scene = changed(pixels=pixels, roughness=rough)
        yield Extreme("grid", f"{shape[0]} × {shape[1]}", scene, load=20.0)
    for spacing in [(8e-6, 8e-9), (8e-9, 8e-6), (8e-6, 8e-3), (8e-3, 8e-6)]:
        name = f"elements of {spacing[0]:g} × {spacing[1]:g} m"
        yield Extreme("grid", name, changed(pixels=Grid(SHAPE, spacing)), load=1.0)
    pixels, local = Grid((12, 16), (8e-6, 8e-6)), Wear(1e-15, "local")
    yield Extreme("grid", "contact at the window's edge", changed(pixels=pixels, wear=local))
    free = Grid((12, 16), (8e-6, 8e-6), (False, False))
    short = replace(small_scene().pin, length=free.size[1])
    whole = changed(pixels=free, wear=local, pin=short, loading=Ramp(5.0, 25.0))
    yield Extreme("grid", "contact at the window's edges", whole, load=22.0)
    part = changed(pixels=free, wear=local)
    yield Extreme("grid", "free part of a pin", part, "as long as the pin", InputError)


def surfaces():
    x, y = np.indices(SHAPE)
    noise = 1e-7 * np.random.default_rng(0).uniform(size=SHAPE)
    spike = np.zeros(SHAPE)
    spike[20, 5] = 1e-6
    pit = -spike
    rounded_up = 1.0 + noise
    for name, heights in {
        "flat": np.zeros(SHAPE),
        "one spike": spike,
        "one spike of 1 m": 1e6 * spike,
        "one pit": pit,
        "one pit of 1 m": 1e6 * pit,
        "one step across": np.where(x < 24, 1e-6, 0.0),
        "sawtooth of 2 elements along x": 1e-6 * (x % 2),
        "checkerboard": 1e-6 * ((x + y) % 2),
        "offset of 1 m": rounded_up,
        "offset of 1000 km": 1e6 + 1e-2 * noise,
        "heights of 1e-30 m": 1e-23 * noise,
    }.items():
        yield Extreme("surface", name, measured(heights))
        if name.startswith(("flat", "one spike")):
            yield Extreme("surface", f"{name}, 1e-9 of nominal", measured(heights), load=7.5e-7)
    for radius in (1e-9, 1.0, 1e30):
        pin = replace(small_scene().pin, radius=radius)
        yield Extreme("surface", f"pin of radius {radius:g} m", changed(pin=pin))
    ball = changed(
        pin=Ball(10e-3, STEEL), pixels=Grid((25, 25), (8e-6, 8e-6), (False, False)),
        roughness=None, wear=Wear(1e-15, "local"),
    )  # fmt: skip
    yield Extreme("surface", "ball, one node in contact", ball, load=1e-9)
    yield Extreme("surface", "ball, all nodes in contact", ball, load=180.0)


def materials():
    for share in (0.9, 0.3, 1e-3, 1e-21, 0.0):
        hardness = 1e9 / share if share else math.inf
        steel = replace(STEEL, hardness=hardness)
        label = f"mean pressure {share:g} of the hardness"
        load = 1e9 / 6.6e9 * CAPACITY
        yield Extreme("material", label, bodies(steel, steel, loading=Ramp(150.0, load)), load=load)
    for pin, disk in itertools.product(MATERIALS, repeat=2):
        if pin != disk and "steel" not in (pin, disk):
            continue
        softest = min(MATERIALS[pin].hardness, MATERIALS[disk].hardness)
        load = 0.1 * softest / 6.6e9 * CAPACITY
        yield Extreme(
            "material", f"{pin} on {disk}",
            bodies(MATERIALS[pin], MATERIALS[disk], loading=Ramp(load / 5.0, load)), load=load,
        )  # fmt: skip


EXTREMES = [*velocities(), *loads(), *wear(), *times(), *grids(), *surfaces(), *materials()]


@pytest.mark.parametrize("case", EXTREMES, ids=lambda case: f"{case.group}: {case.label}")
def test_extremes_end_in_a_proven_result_or_a_named_error(case):
    if case.error is None:
        _, state = case.run()
        assert state.heat is not None
    else:
        with pytest.raises(case.error, match=case.outcome):
            case.run()


def test_no_motion_means_no_heat_and_no_wear():
    _, state = Extreme("", "", small_scene, velocity=0.0).run()
    assert state.heat.max_rise == state.wear_depth.max() == 0
    assert math.isnan(state.heat.pin_heat_share)

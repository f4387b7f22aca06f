"""Random scenes, mild to absurd, and an independent proof of what comes out of them."""

import math
import time
from dataclasses import dataclass

import numpy as np

from tribo import (
    Ball,
    Cylinder,
    Fidelity,
    Grid,
    Material,
    MeasuredRoughness,
    Ramp,
    Scene,
    SelfAffineRoughness,
    TriboError,
    Wear,
    contact_modulus,
    simulate,
)
from tribo.contact import ElasticHalfSpace
from tribo.loading import MeasuredLoad

EPSILON = np.finfo(float).eps


@dataclass(frozen=True)
class Point:
    """A scene whose parts are not built yet, since building them may be refused too."""

    parts: dict
    normal_load: float
    velocity: float

    def scene(self):
        return Scene(**{name: part and part() for name, part in self.parts.items()})


class Draw:
    """Random numbers of a wildness from 0, the physical range, to 1, far beyond it."""

    def __init__(self, seed, wildness):
        self.rng = np.random.default_rng(seed)
        self.wildness = wildness

    def log(self, low, high, far=6.0):
        """A positive number: its logarithm even between two, at most `far` decades beyond."""
        decades = self.wildness * far * self.rng.uniform(-1, 1) ** 3
        return float(10 ** (self.rng.uniform(math.log10(low), math.log10(high)) + decades))

    def either(self, *choices):
        return choices[self.rng.integers(len(choices))]

    def chance(self, share):
        return self.rng.uniform() < share

    def integer(self, low, high):
        return int(self.rng.integers(low, high + 1))


def random_point(seed, wildness):
    """A point of a random scene; the same for the same seed."""
    draw = Draw(seed, wildness)
    pin, disk = random_material(draw), random_material(draw)
    block = draw.either(1, 1, 2)
    shape = block * draw.integer(1, 40), block * draw.integer(1, 24)
    dx = draw.log(1e-7, 1e-5)
    spacing = dx, dx * draw.log(0.3, 3.0, far=3.0)
    ball = draw.chance(0.2)
    periodic = False, not ball and draw.chance(0.8)
    pattern = "swept" if periodic[1] and draw.chance(0.7) else "local"
    radius = draw.log(1e-4, 1e-1)
    softest = min(pin["hardness"], disk["hardness"])
    area = math.prod(shape) * math.prod(spacing)
    length = draw.log(1e-4, 1e-2)
    patches = 1.0 if ball else length / (shape[1] * spacing[1])
    stress = softest if math.isfinite(softest) else pin["elastic_modulus"] / 100
    load = area * patches * stress * draw.log(1e-4, 0.7, far=9.0)
    if draw.chance(0.1):
        load = area * patches * stress * draw.either(0.9, 0.999, 1 - 1e-9, 1.0, 1.01)
    reference = load * draw.log(0.3, 3.0, far=0.0)
    velocity = draw.either(-1.0, 1.0, 1.0, 1.0) * draw.log(1e-2, 1e1)
    if draw.chance(0.1):
        velocity = 0.0
    fidelity = {
        "pixels_per_element": block,
        "averaging": draw.either("mean", "sample"),
        "history_coarsening": draw.either(1, 1, 2),
        "increments": draw.integer(1, 8),
        "contact_tolerance": draw.log(1e-8, 1e-3, far=4.0),
        "wear_scheme": draw.either("implicit", "implicit", "sdirk2", "explicit"),
        "heat_model": draw.either("elapsed", "elapsed", "history"),
        "partition": draw.either("local", "local", "uniform"),
        "heat_tolerance": draw.log(1e-8, 1e-4, far=4.0),
    }
    if fidelity["heat_model"] == "history":
        fidelity["history_coarsening"] = 1
    rate = reference / draw.log(0.1, 10.0, far=12.0)
    wear = draw.either(0.0, 1.0, 1.0) * draw.log(1e-18, 1e-13)
    body = (
        (lambda: Ball(radius, Material(**pin)))
        if ball
        else (lambda: Cylinder(radius, length, Material(**pin)))
    )
    return Point(
        parts={
            "pin": body,
            "disk": lambda: Material(**disk),
            "pixels": lambda: Grid(shape, spacing, periodic),
            "loading": random_loading(draw, rate, reference),
            "roughness": random_roughness(draw, shape, spacing),
            "wear": (lambda: Wear(wear, pattern)) if draw.chance(0.85) else None,
            "fidelity": lambda: Fidelity(**fidelity),
        },
        normal_load=load,
        velocity=velocity,
    )


def random_material(draw):
    """Rubber to diamond, and beyond."""
    modulus = draw.log(1e6, 1e12)
    return {
        "elastic_modulus": modulus,
        "poisson_ratio": draw.either(draw.rng.uniform(0.0, 0.5), 0.3, 0.5, -0.5),
        "thermal_conductivity": draw.log(0.1, 2000.0),
        "density": draw.log(500.0, 2e4),
        "specific_heat": draw.log(100.0, 4000.0),
        "hardness": math.inf if draw.chance(0.1) else modulus * draw.log(1e-3, 0.2),
    }


def random_loading(draw, rate, reference):
    """Mostly a ramp, at times with a hold or as a record of its own."""
    kind = draw.either("ramp", "ramp", "ramp", "hold", "record")
    if kind == "ramp":
        return lambda: Ramp(rate, reference)
    hold, stop = reference / rate * draw.rng.uniform(), draw.rng.uniform()
    if kind == "hold":
        return lambda: Ramp(rate, reference, hold=hold, stops=(stop * hold,))
    times = np.cumsum(draw.rng.uniform(0.1, 1.0, 6)) * reference / rate
    loads = np.sort(draw.rng.uniform(-0.1, 1.0, 6)) * reference
    return lambda: MeasuredLoad(times, loads)


def random_roughness(draw, shape, spacing):
    """None, self-affine, or one of the shapes that instruments and defects leave."""
    height = draw.log(1e-9, 1e-6)
    kind = draw.either("none", "affine", "affine", "affine", "spike", "step", "sawtooth", "offset")
    if kind == "none":
        return None
    if kind == "affine":
        length = draw.log(1.0, 10.0, far=2.0) * max(spacing)
        hurst = float(draw.rng.uniform(0.1, 1.0))
        seed = draw.integer(0, 2**31)
        return lambda: SelfAffineRoughness(height, hurst, (length, length), seed)
    heights = np.zeros(shape)
    if kind == "spike":
        heights[tuple(draw.integer(0, n - 1) for n in shape)] = height * draw.either(-1, 1)
    elif kind == "step":
        heights[: shape[0] // 2] = height
    elif kind == "sawtooth":
        heights[::2, ::2] = height
    else:
        heights = 1.0 + height * draw.rng.uniform(size=shape)
    return lambda: MeasuredRoughness(heights)


def outcome(point):
    """'certified', or the kind of error, and how long it took [s]; what is wrong is raised."""
    began = time.perf_counter()
    try:
        scene = point.scene()
        before = None
        for state in simulate(scene, point.normal_load, point.velocity):
            assert_sound(scene, before, state, point.normal_load)
            before = state
        assert before.heat is not None
        result = "certified"
    except TriboError as error:
        result = type(error).__name__
    return result, time.perf_counter() - began


def assert_sound(scene, before, state, normal_load):
    """Hold a state against the physics, with none of the simulation's own checks."""
    fields = [state.pressure, state.wear_depth]
    if state.heat:
        heat = state.heat
        fields += [heat.rise, heat.rise_quantile, np.array([heat.max_rise, heat.mean_rise])]
        assert (np.diff(heat.rise_quantile) >= 0).all()
    assert all(np.isfinite(field).all() for field in fields)
    scene = next(level for level in scene.levels() if level.grid.shape == state.pressure.shape)
    p, grid = state.pressure, scene.grid
    assert p.min() >= 0
    assert p.max() <= scene.hardness
    assert state.wear_depth.min() >= 0
    carried = p.sum() * grid.element_area * scene.pin.patches(grid)
    assert abs(carried - state.normal_load) <= 1e-9 * state.normal_load
    assert state.normal_load <= normal_load * (1 + 1e-12)
    if state.normal_load:
        assert_complementary(scene, before, state)


def assert_complementary(scene, before, state):
    """The conditions on the gap, with the worn shape itself and the elastic map alone."""
    explicit = scene.fidelity.wear_scheme == "explicit"
    worn = state.wear_depth
    if explicit and scene.wear:
        same_grid = before is not None and before.wear_depth.shape == worn.shape
        worn = before.wear_depth if same_grid else 0 * worn
    p = state.pressure
    modulus = contact_modulus(scene.pin.material, scene.disk)
    solid = ElasticHalfSpace(scene.grid, modulus, scene.fidelity.kernel)
    separation = scene.separation(scene.heights())
    z = separation + worn
    heights = np.abs(separation[p > 0]).max() + np.abs(z[p > 0]).max()
    z = z - z[p > 0].mean()
    gap = solid(p) + z
    free = (p > 0) & (p < scene.hardness)
    if free.any():
        gap -= gap[free].mean()
    else:
        top = gap[p > 0].max()
        gap -= (top + max(top, gap[p == 0].min())) / 2 if (p == 0).any() else top
    unit = solid.self_influence
    if scene.wear and not explicit and (scene.wear.pattern == "local" or scene.grid.shape[1] == 1):
        step = state.sliding_distance - (before.sliding_distance if before else 0.0)
        unit += scene.wear.specific_wear_rate * step
    violation = max(
        np.abs(gap[free]).max(initial=0.0),
        -gap[p == 0].min(initial=0.0),
        gap[p == scene.hardness].max(initial=0.0),
    )
    rounding = 1e3 * EPSILON * (np.abs(solid(p)).max() + heights)
    assert violation <= 1.01 * scene.fidelity.contact_tolerance * unit * p.max() + rounding

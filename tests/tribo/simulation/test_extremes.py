"""Extremes: each ends soon, in a result that is proven or an error that says why.

``python -m tests.tribo.simulation.test_extremes`` lists them.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.helpers.random_scenes import assert_sound
from tests.helpers.scenes import STEEL, small_scene
from tests.tribo.thermal.influence import thermal_influence
from tribo import (
    Ball,
    ConvergenceError,
    Fidelity,
    Grid,
    InputError,
    Material,
    MeasuredRoughness,
    Ramp,
    WarningKind,
    Wear,
    measures,
    simulate,
    warnings,
)
from tribo.analytic import uniform_flux_rise
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.errors import RangeError
from tribo.loading import MeasuredLoad
from tribo.simulation import heat
from tribo.surface import self_affine

SOLVED = "solved"

CAPACITY = 6.6e9 * 48 * 8e-6 * 3.4e-3  # load that the small scene's window carries [N]
SHAPE = (48, 16)


@dataclass(frozen=True)
class Extreme:
    """What is extreme, and what must happen."""

    group: str
    what: str
    scene: Callable
    outcome: str = SOLVED
    error: type | None = None
    load: float = 600.0
    velocity: float = 1.25

    def run(self):
        """Go through all states, each held against the physics; return scene and last state."""
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
    shorter = "take shorter steps"
    yield Extreme("velocity", "1e12 m/s", small_scene, shorter, InputError, velocity=1e12)
    yield Extreme("velocity", "1e100 m/s", small_scene, shorter, InputError, velocity=1e100)
    without_wear = changed(wear=None)
    yield Extreme("velocity", "1e30 m/s, no wear", without_wear, velocity=1e30)
    yield Extreme(
        "velocity", "1e300 m/s, no wear", without_wear, "too large or too small", RangeError,
        velocity=1e300,
    )  # fmt: skip
    yield Extreme("velocity", "nan", small_scene, "velocity is nan", InputError, velocity=math.nan)


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
        "load", "1.001 H·A", changed(loading=full), "carries at most", InputError, load=beyond
    )
    yield Extreme("load", "0", small_scene, "normal_load is 0", InputError, load=0.0)
    yield Extreme("load", "inf", small_scene, "normal_load is inf", InputError, load=math.inf)
    elastic = replace(STEEL, hardness=math.inf)
    yield Extreme(
        "load", "1e10 of nominal, no hardness", bodies(elastic, elastic, loading=Ramp(1e9, 7.5e12)),
        load=7.5e12,
    )  # fmt: skip
    yield Extreme(
        "load", "1e12 steps away", bodies(elastic, elastic), "at most 100000 are allowed",
        InputError, load=1e14,
    )  # fmt: skip


def wear():
    # 1e-13 m²/N wears 100 µm a step, 1e-6 m²/N 1 km
    for pattern, rate in itertools.product(("local", "swept"), (0.0, 1e-30, 1e-15, 1e-13, 1e-6)):
        name = f"{pattern} {rate:g} m²/N"
        yield Extreme("wear rate", name, changed(wear=Wear(rate, pattern)))
    for scheme, rate in itertools.product(("sdirk2", "explicit"), (1e-30, 1e-10)):
        fidelity = Fidelity(
            pixels_per_element=1, increments=10, contact_tolerance=1e-6, wear_scheme=scheme
        )
        name = f"{scheme} {rate:g} m²/N"
        yield Extreme("wear rate", name, changed(wear=Wear(rate), fidelity=fidelity))


def times():
    for seconds in (1e-15, 1e-3, 1e9):
        yield Extreme("duration", f"{seconds:g} s", lasting(seconds))
        yield Extreme(
            "duration", f"{seconds:g} s at rest", lasting(seconds, roughness=None), velocity=0.0
        )
    history = Fidelity(
        pixels_per_element=1, increments=4, contact_tolerance=1e-6, heat_model="history"
    )
    for seconds in (1e-15, 1e9):
        yield Extreme(
            "duration", f"{seconds:g} s, heat history", lasting(seconds, fidelity=history)
        )


def peclet_numbers():
    for exponent in range(-6, 7, 3):
        velocity = 10.0**exponent * 2 * STEEL.thermal_diffusivity / 8e-6
        yield Extreme(
            "Péclet number", f"1e{exponent} an element", changed(wear=None), velocity=velocity
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
    for periodic in (True, False):
        pixels = Grid((12, 16), (8e-6, 8e-6), (False, periodic))
        name = "contact at the window's edge" + ("" if periodic else "s")
        yield Extreme("grid", name, changed(pixels=pixels, wear=Wear(1e-15, "local")))


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
    for name, value in {"NaN": math.nan, "inf": math.inf}.items():
        broken = noise.copy()
        broken[3, 4] = value
        yield Extreme(
            "surface", f"with {name}", lambda b=broken: measured(b)(), r"the first at \(3, 4\)",
            InputError,
        )  # fmt: skip
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
        what = f"mean pressure {share:g} of the hardness"
        load = 1e9 / 6.6e9 * CAPACITY
        yield Extreme("material", what, bodies(steel, steel, loading=Ramp(150.0, load)), load=load)
    soft = replace(STEEL, hardness=1e6)
    yield Extreme(
        "material", "hardness below the mean pressure", bodies(soft, soft), "carries at most",
        InputError,
    )  # fmt: skip
    for pin, disk in itertools.product(MATERIALS, repeat=2):
        if pin != disk and "steel" not in (pin, disk):
            continue
        softest = min(MATERIALS[pin].hardness, MATERIALS[disk].hardness)
        load = 0.1 * softest / 6.6e9 * CAPACITY
        yield Extreme(
            "material", f"{pin} on {disk}",
            bodies(MATERIALS[pin], MATERIALS[disk], loading=Ramp(load / 5.0, load)), load=load,
        )  # fmt: skip


def tolerances():
    for tolerance in (1e-1, 1e-9, 1e-12):
        fidelity = Fidelity(pixels_per_element=1, increments=5, contact_tolerance=tolerance)
        yield Extreme("tolerance", f"contact {tolerance:g}", changed(fidelity=fidelity))
    fidelity = Fidelity(pixels_per_element=1, increments=5, contact_tolerance=1e-17)
    yield Extreme(
        "tolerance", "contact 1e-17", changed(fidelity=fidelity), "falls no further",
        ConvergenceError,
    )  # fmt: skip
    for tolerance in (0.9, 1e-12):
        fidelity = Fidelity(pixels_per_element=1, increments=5, heat_tolerance=tolerance)
        yield Extreme("tolerance", f"heat {tolerance:g}", changed(fidelity=fidelity))
    yield Extreme(
        "tolerance", "heat 1e-15",
        lambda: replace(small_scene(), fidelity=Fidelity(heat_tolerance=1e-15)),
        "heat_tolerance is 1e-15", InputError,
    )  # fmt: skip


EXTREMES = [
    *velocities(),
    *loads(),
    *wear(),
    *times(),
    *peclet_numbers(),
    *grids(),
    *surfaces(),
    *materials(),
    *tolerances(),
]


@pytest.mark.parametrize("case", EXTREMES, ids=lambda case: f"{case.group}: {case.what}")
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


@pytest.mark.parametrize(
    ("what", "touching", "yielding"),
    [
        ("ball, one node in contact", 1, 0),
        ("ball, all nodes in contact", 25 * 25, 0),
        ("one spike, 1e-9 of nominal", 1, 0),
        ("H·A: p = H", 48 * 16, 48 * 16),
        ("1 − 1e-9 H·A", 48 * 16, 48 * 16 - 1),
    ],
)
def test_extremes_are_as_extreme_as_their_names_say(what, touching, yielding):
    scene, state = next(case for case in EXTREMES if case.what == what).run()
    assert np.count_nonzero(state.pressure) == touching
    assert np.count_nonzero(state.pressure == scene.hardness) == yielding


# The solver alone, on every kind of window.


def shapes(grid):
    x, y = np.indices(grid.shape)
    spike = np.full(grid.shape, 1e-6)
    spike[grid.shape[0] // 3, 0] = 0.0
    step = 1e-6 * (x < grid.shape[0] / 2)
    return {
        "flat": 0.0 * x,
        "spike": spike,
        "pit": -spike,
        "step": step,
        "sawtooth": 1e-6 * ((x + y) % 2),
        "slope": 1e-6 * x,
        "offset": 1.0 + 1e-7 * np.random.default_rng(0).uniform(size=grid.shape),
    }


def violation(contact, solid, z, hardness):
    """Of the conditions on the gap, in units of the residual, from the pressure alone."""
    p = contact.pressure
    gap = solid(p) + (z - z[p > 0].mean())
    free = (p > 0) & (p < hardness)
    if free.any():
        gap -= gap[free].mean()
    else:
        top, bottom = gap[p > 0].max(), gap[p == 0].min(initial=math.inf)
        gap -= top if bottom == math.inf else (top + bottom) / 2
    worst = max(
        np.abs(gap[free]).max(initial=0.0),
        -gap[p == 0].min(initial=0.0),
        gap[p == hardness].max(initial=0.0),
    )
    return worst / (solid.self_influence * p.max())


@pytest.mark.parametrize("periodic", list(itertools.product((False, True), repeat=2)))
@pytest.mark.parametrize(
    ("shape", "spacing"),
    [((1, 12), (1e-6, 1e-3)), ((13, 1), (1e-6, 1e-3)), ((17, 12), (1e-6, 1e-6))],
)
def test_every_shape_on_every_window_at_every_load(periodic, shape, spacing):
    grid = Grid(shape, spacing, periodic)
    solid = ElasticHalfSpace(grid, 115e9)
    for z in shapes(grid).values():
        for share, hardness in (
            (1e-9, 1e9), (0.05, math.inf), (0.5, 1e9), (1 - 1e-9, 1e9), (1.0, 1e9), (1.0, math.inf)
        ):  # fmt: skip
            load = share * 1e9 * grid.area
            contact = solve_contact(solid, z, load, hardness, tolerance=1e-7)
            assert contact.residual <= 1e-7
            assert contact.load_error <= 1e-12
            assert contact.pressure.sum() * grid.element_area == pytest.approx(load, rel=1e-12)
            assert 0 <= contact.pressure.min() <= contact.pressure.max() <= hardness
            assert violation(contact, solid, z, hardness) <= 1.001e-7 + 1e-12


@pytest.mark.parametrize("periodic", [(False, True), (False, False)])
@pytest.mark.parametrize("saturation", [0.05, 0.7, 0.999, 1 - 1e-13])
def test_mostly_saturated_contacts_certify_themselves(saturation, periodic):
    grid = Grid((64, 60), (1e-6, 1.1e-6), periodic)
    solid = ElasticHalfSpace(grid, 115e9)
    z = -self_affine(grid, ra=0.3e-6, hurst_exponent=0.8, correlation_length=4e-6, seed=3)
    contact = solve_contact(solid, z, saturation * 6.6e9 * grid.area, 6.6e9, tolerance=1e-9)
    assert contact.iterations < 200
    assert violation(contact, solid, z, 6.6e9) <= 1.001e-9
    assert contact.saturated_fraction == np.mean(contact.pressure[contact.pressure > 0] == 6.6e9)
    assert contact.penetration <= 1.001e-9 * solid.self_influence * 6.6e9


@pytest.mark.parametrize("tolerance", [1e-12, 1e-14, 1e-300])
@pytest.mark.parametrize("saturation", [0.02, 0.9])
def test_tolerances_near_rounding_are_kept_or_refused_soon(tolerance, saturation):
    grid = Grid((100, 96), (1e-6, 1e-6))
    solid = ElasticHalfSpace(grid, 115e9)
    z = -self_affine(grid, ra=0.3e-6, hurst_exponent=0.8, correlation_length=4e-6, seed=3)
    load = saturation * 6.6e9 * grid.area
    try:
        contact = solve_contact(solid, z, load, 6.6e9, tolerance=tolerance)
    except ConvergenceError as error:
        contact, said = error.solution, str(error)
        assert "ask for at least" in said
        assert tolerance < 1e-12
        assert contact.residual < 1e-12
    assert contact.iterations < 350
    # The residual is that of the pressure that is given out, to the last digit but rounding.
    rounding = 20 * np.finfo(float).eps * np.abs(solid(contact.pressure)).max()
    unit = solid.self_influence * contact.pressure.max()
    assert violation(contact, solid, z, 6.6e9) <= contact.residual + rounding / unit


def test_no_number_of_iterations_is_exceeded():
    grid = Grid((40, 40), (1e-6, 1e-6))
    solid = ElasticHalfSpace(grid, 115e9)
    z = -self_affine(grid, ra=0.3e-6, hurst_exponent=0.8, correlation_length=4e-6, seed=3)
    for most in (1, 3, 20):
        with pytest.raises(ConvergenceError, match=f"allow more than {most} iterations") as caught:
            solve_contact(solid, z, 2.0, 6.6e9, tolerance=1e-12, max_iterations=most)
        # The last step may have to begin again from its own end.
        assert most <= caught.value.solution.iterations <= most + 2
        assert caught.value.solution.load_error < 1e-10


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"normal_load": 1.1e9 * 30e-12}, "hardness"),
        ({"separation": np.full((6, 5), math.nan)}, "finite"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
        ({"hardness": 0.0}, "hardness is 0.0"),
        ({"normal_load": math.inf, "hardness": math.inf}, "must be finite"),
        ({"normal_load": 1e300, "hardness": math.inf}, "double precision cannot hold"),
        ({"separation": np.full((6, 5), "a")}, "must hold real numbers"),
        ({"separation": [[0.0, 1.0], [2.0]]}, "not an array"),
        ({"initial_pressure": np.full((6, 5), math.nan)}, r"first at \(0, 0\)"),
    ],
)
def test_impossible_arguments_of_the_solver_are_named(change, said):
    solid = ElasticHalfSpace(Grid((6, 5), (1e-6, 1e-6)), 115e9)
    arguments = {"separation": np.zeros((6, 5)), "normal_load": 1e-3, "hardness": 1e9} | change
    with pytest.raises(InputError, match=said):
        solve_contact(solid, **arguments)


# Kernels.


@pytest.mark.parametrize("peclet", [1e3, 1e6, 1e30])
@pytest.mark.parametrize("spacing", [(1e-5, 1e-5), (1e-8, 1e-5)])
def test_sources_that_pass_at_once_heat_in_one_dimension(peclet, spacing):
    velocity = peclet * 2 * STEEL.thermal_diffusivity / spacing[0]
    grid = Grid((24, 8), spacing)
    kernel = thermal_influence(grid, STEEL, velocity, 1e3)
    passages = (np.arange(24) + 0.5) * spacing[0] / velocity
    exact = np.diff(uniform_flux_rise(1.0, 1.0, STEEL.thermal_effusivity) * np.sqrt(passages))
    # Heat does not spread across if it has less time than it needs for 1 % of an element; and
    # what the edges blur is 1/(4 Pe) of the first element's, as found.
    if math.sqrt(STEEL.thermal_diffusivity * passages[-1]) < 0.01 * spacing[1]:
        assert kernel[1:24, 0] == pytest.approx(exact, abs=kernel[0, 0] * (1 / peclet + 1e-6))


# Stability of the wear schemes in time.

STIFFNESSES = (1.9, 3.0, 10.0)


def wavy(pressure):
    """Total variation along x, in that of a single hump: 1 for any smooth contact."""
    profile = np.concatenate(([0.0], pressure[:, 0], [0.0]))
    return np.abs(np.diff(profile)).sum() / (2 * profile.max())


@pytest.mark.parametrize(
    ("scheme", "pattern"),
    [("implicit", "swept"), ("sdirk2", "local"), ("explicit", "swept"), ("explicit", "local")],
)
def test_wear_stays_smooth_or_is_warned_of_at_any_step_length(scheme, pattern):
    results = {}
    for stiffness in STIFFNESSES:
        scene = small_scene(pattern, roughness=False, wear_scheme=scheme, increments=1)
        solid = ElasticHalfSpace(scene.grid, 115.385e9)
        unit = Wear(1.0, pattern).stiffness(solid, 1.0)
        steps, duration = 30, 5.0
        # One step of the loading, then a hold of 30 steps, each of the given k·dS/λ_min.
        wear_rate = stiffness / (unit * 1.25 * duration)
        scene = replace(
            scene,
            wear=Wear(wear_rate, pattern),
            loading=Ramp(
                600.0 / duration,
                600.0,
                hold=steps * duration,
                stops=tuple(duration * number for number in range(1, steps)),
            ),
        )
        *_, state = simulate(scene, 600.0, 1.25)
        kinds = [warning.kind for warning in warnings(scene, state)]
        results[stiffness] = wavy(state.pressure), WarningKind.UNSTABLE_WEAR in kinds
    for stiffness, (waves, is_warned) in results.items():
        if scheme == "explicit":
            assert is_warned == (stiffness >= 2)
            # Every row that the contact gains starts a wave, which dies slowly next to the limit.
            assert is_warned or waves < 1.5
        else:
            assert not is_warned
            assert waves < 1.1
    if scheme == "explicit":
        assert results[10.0][0] > 2  # it does fail where it is warned of


def test_temperature_of_a_state_at_any_peclet_number_grows_with_the_velocity():
    *_, state = simulate(small_scene(wear=False), 600.0, 1.0)
    scene = small_scene(wear=False)
    rises = [heat(scene, state, velocity).mean_rise for velocity in np.geomspace(1e-6, 1e5, 12)]
    assert (np.diff(rises) > 0).all()
    assert measures(scene, state)["mean_rise"] == pytest.approx(heat(scene, state, 1.0).mean_rise)


# Bad input: each says where it is.


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Grid((math.nan, 4), (1.0, 1.0)), "nx is nan"),
        (lambda: Grid((4, 4, 4), (1.0, 1.0)), "shape is .* two values"),
        (lambda: Fidelity(increments=math.inf), "increments is inf"),
        (lambda: Fidelity(heat_tolerance=1.0), "heat_tolerance is 1.0"),
        (lambda: list(Ramp(1.0, 1.0).stations(1.0, math.nan)), "increments is nan"),
        (lambda: MeasuredRoughness(np.zeros((0, 4))), r"shape \(0, 4\)"),
        (lambda: MeasuredRoughness(np.array([["a"]])), "must hold real numbers"),
        (lambda: MeasuredRoughness([[1.0], [math.inf]]), r"1 of 2 places, the first at \(1, 0\)"),
        (lambda: MeasuredLoad([0.0, 1.0], [0.0, math.nan]), "row 1"),
    ],
)
def test_what_is_no_number_shape_or_size_is_named(build, said):
    with pytest.raises(InputError, match=said):
        build()


if __name__ == "__main__":
    for case in EXTREMES:
        print(f"{case.group}: {case.what}: {case.outcome}")

"""Path of a probe along its points, on ramps whose states are made up."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pipeline.sweep.model import Point
from pipeline.tradeoff import probe as module
from pipeline.tradeoff.probe import (
    Target,
    _run,
    critical_velocity,
    fitted,
    near_the_boundary,
    probe,
    some_places,
)
from tests.helpers import tiny
from tribo import PRESETS, QUANTILES, Fidelity, InputError
from tribo.simulation import Heat, start

SWEEP = tiny.sweep(velocities=(-2.0, 0.0, 0.5, 8.0))
START = start(SWEEP.scene)
NODES = START.pressure.size


def state(load, rise=None, iterations=3, heat_iterations=5, on_trunk=True, history=None):
    """A state at a load, on which all touches, with the same temperature everywhere."""
    hot = None
    if rise is not None:
        plane = np.full(START.pressure.shape, rise)
        quantile = np.full(len(QUANTILES), rise)
        hot = Heat(plane, quantile, rise, rise, 0.1, heat_iterations)
    return replace(
        START,
        pressure=np.full(START.pressure.shape, 1e8),
        normal_load=load,
        index=1,
        iterations=iterations,
        work=iterations * NODES,
        heat=hot,
        on_trunk=on_trunk,
        history=history,
    )


@pytest.fixture
def ramps(monkeypatch):
    """Simulations asked for; their states are those of `made`, by load, else one at the load."""
    asked, made = [], {}

    def simulate(scene, load, velocity, trunk=None):
        asked.append((scene, load, velocity, trunk))
        yield from made.get(load, [state(load, rise=abs(velocity) * load)])

    monkeypatch.setattr(module, "simulate", simulate)
    return asked, made


def test_the_hottest_state_under_full_load_is_read(ramps):
    _, made = ramps
    made[300.0] = [
        state(100.0, rise=90.0),
        state(300.0, rise=5.0),
        state(300.0, rise=7.0),
        state(300.0, rise=6.0),
        state(300.0),
    ]
    assert _run(SWEEP, 300.0, 1.0).state.heat.max_rise == 7.0
    made[300.0] = [state(100.0), state(300.0)]
    assert _run(SWEEP, 300.0, 1.0).state is made[300.0][-1]
    with pytest.raises(InputError, match="ended without a temperature"):
        probe(SWEEP, SWEEP.scene.fidelity, [Point(300.0, 1.0)])


def test_a_probe_sums_its_runs_and_reads_its_points_in_their_order(ramps):
    asked, _ = ramps
    points = [Point(600.0, 1.0), Point(300.0, 2.0), Point(300.0, 1.0)]
    changed = replace(SWEEP.scene.fidelity, heat_tolerance=1e-3)
    result = probe(SWEEP, changed, points)
    assert [(load, velocity) for _, load, velocity, _ in asked] == [(300, 1), (600, 1), (300, 2)]
    assert {arguments[0].fidelity for arguments in asked} == {changed}
    assert result.fidelity == changed
    assert [reading.rise for reading in result.readings] == [600.0, 600.0, 300.0]
    assert {reading.contact_nodes for reading in result.readings} == {NODES}
    assert {reading.contact_fraction for reading in result.readings} == {1.0}
    assert (result.convolutions, result.work) == (24, 24.0 * NODES)
    assert result.peak_bytes is None
    assert 0 <= result.seconds < 60


@pytest.mark.parametrize(
    ("shape", "asked", "taken"),
    [((90, 60), 4, 3), ((90, 60), 3, 3), ((90, 64), 4, 2), ((91, 64), 4, 1), ((64, 90), 4, 2)],
)
def test_elements_divide_the_pixels_along_both_axes(shape, asked, taken):
    sweep = SWEEP.changed(pixels=replace(SWEEP.scene.pixels, shape=shape))
    fidelity = fitted(sweep, Fidelity(pixels_per_element=asked, heat_kernel="endless"))
    assert (fidelity.pixels_per_element, fidelity.heat_kernel) == (taken, "pin")


@pytest.mark.parametrize(
    ("number", "chosen"), [(1, (0,)), (2, (0, 4)), (3, (0, 2, 4)), (4, (0, 1, 3, 4)), (9, range(5))]
)
def test_loads_are_some_of_the_sweep_s_with_both_ends(number, chosen):
    sweep = SWEEP.changed(loads=(200.0, 300.0, 400.0, 500.0, 600.0))
    assert [place.load for place in some_places(sweep, number)] == [
        sweep.plane.loads[k] for k in chosen
    ]


def made_up(monkeypatch, exponent, reference_velocity=2.0):
    """Ramps whose rise is a power of the velocity, at the limit where it is asked for."""
    asked = []

    def simulate(scene, load, velocity, trunk=None):
        asked.append(scene.fidelity)
        rise = 1200.0 * (velocity / reference_velocity) ** exponent * (load / 300.0)
        yield state(load, rise=rise)

    monkeypatch.setattr(module, "simulate", simulate)
    return asked


@pytest.mark.parametrize(("exponent", "expected"), [(0.7, 0.7), (0.31, 0.31), (0.1, 0.3)])
def test_points_lie_at_the_boundary_with_its_exponent(monkeypatch, exponent, expected):
    asked = made_up(monkeypatch, exponent)
    (point,), exponents = near_the_boundary(SWEEP, [Target(300.0)])
    assert point.load == 300.0
    assert abs(exponent * math.log(point.velocity / 2.0)) < 0.0101
    assert exponents == (pytest.approx(expected, rel=1e-9),)
    assert set(asked) == {fitted(SWEEP, PRESETS["standard"])}
    made_up(monkeypatch, 0.5)
    points, _ = near_the_boundary(SWEEP, [Target(load) for load in (150.0, 300.0, 450.0)])
    ratios = [point.velocity * (point.load / 300.0) ** 2 for point in points]
    assert ratios == pytest.approx([2.0] * 3, rel=0.025)


def test_the_exponent_is_that_beside_the_boundary(monkeypatch):
    def simulate(scene, load, velocity, trunk=None):
        x = math.log(velocity / 2.0)
        yield state(load, rise=1200.0 * math.exp(0.6 * x + 0.5 * x**3))

    monkeypatch.setattr(module, "simulate", simulate)
    assert near_the_boundary(SWEEP, [Target(300.0)])[1] == (pytest.approx(0.6, abs=0.005),)


@pytest.mark.parametrize(("crossing", "expected"), [(0.01, 0.25), (100.0, 16.0)])
def test_beyond_half_and_twice_the_velocities_the_nearer_end_is_taken(
    monkeypatch, crossing, expected
):
    made_up(monkeypatch, 0.7, crossing)
    (point,), _ = near_the_boundary(SWEEP, [Target(300.0)])
    assert point.velocity == pytest.approx(expected, rel=1e-6)


def test_without_a_velocity_there_is_no_boundary():
    with pytest.raises(InputError, match="no velocity but 0"):
        near_the_boundary(SWEEP.changed(velocities=(0.0,)), [Target(300.0)])


@pytest.mark.parametrize("exponent", [0.05, 1.0, 8.0])
@pytest.mark.parametrize("root", [0.11, 3.0, 9.5])
def test_a_crossing_of_any_power_is_found_within_its_tolerance(exponent, root):
    asked = []

    def rise(velocity):
        asked.append(velocity)
        return 200.0 * (velocity / root) ** exponent

    critical = critical_velocity(rise, 200.0, 0.1, 10.0)
    assert abs(exponent * math.log(critical / root)) <= 0.01
    assert len(asked) <= 20
    assert len(set(asked)) == len(asked)
    assert all(0.1 * (1 - 1e-9) <= v <= 10.0 * (1 + 1e-9) for v in asked)


def test_a_crossing_is_enclosed_where_the_rise_jumps():
    asked = []

    def rise(velocity):
        asked.append(velocity)
        return 100.0 if velocity < 0.7 else 300.0

    assert critical_velocity(rise, 200.0, 0.1, 10.0) == pytest.approx(0.7, rel=1e-4)
    assert len(set(asked)) == len(asked)


def test_without_a_limit_the_middle_is_taken():
    assert critical_velocity(lambda v: math.nan, math.inf, 0.1, 10.0) == pytest.approx(1.0)

"""Only what a scene requires is computed; each economy shown by a count."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, last, small_scene
from tribo import (
    QUANTILES,
    Cylinder,
    Fidelity,
    Grid,
    MeasuredRoughness,
    Wear,
    measures,
    simulate,
    warnings,
)
from tribo.simulation import forget_kernels
from tribo.thermal import duhamel

DECISIVE = QUANTILES.index(0.9)


def rough_scene(**fidelity):
    """192 × 96 pixels, enough for a history on a coarser grid."""
    scene = small_scene(**fidelity)
    return replace(
        scene,
        pixels=Grid((192, 96), (2e-6, 2e-6)),
        roughness=replace(scene.roughness, correlation_length=(4e-6, 4e-6)),
    )


def with_hardness(scene, hardness):
    material = replace(STEEL, hardness=hardness)
    return replace(scene, pin=Cylinder(2e-3, 3.4e-3, material), disk=material)


def total_work(states):
    return sum(s.work + (s.heat.iterations * s.pressure.size if s.heat else 0) for s in states)


# The history of a point on a coarser grid.


def test_a_coarse_history_saves_work_and_hardly_moves_the_temperature():
    full = list(simulate(rough_scene(increments=20, contact_tolerance=1e-3), 600.0, 1.5))
    scene = rough_scene(increments=20, contact_tolerance=1e-3, history_coarsening=2)
    coarse = list(simulate(scene, 600.0, 1.5))
    assert coarse[0].pressure.shape == (96, 48)
    assert coarse[-1].pressure.shape == coarse[-1].heat.rise.shape == (192, 96)
    assert total_work(coarse) < total_work(full) / 2
    # Few summits touch at a time on so small a patch; on the shipped scene it is 0.02 %.
    decisive = [states[-1].heat.rise_quantile[DECISIVE] for states in (full, coarse)]
    assert decisive[1] == pytest.approx(decisive[0], rel=0.01)


@pytest.mark.parametrize("asked", [(), range(0, 100, 2)])
def test_where_few_elements_touch_the_history_is_on_their_own_grid(asked):
    scene = rough_scene()
    heavily_worn = replace(scene, wear=Wear(1e-13, "swept"), pixels=Grid((96, 24), (4e-6, 4e-6)))
    fidelity = replace(heavily_worn.fidelity, history_coarsening=2, fewest_elements=400)
    coarse = replace(heavily_worn, fidelity=fidelity)
    alone = list(simulate(coarse, 300.0, 1.25, asked=asked))
    on_own_grid = list(simulate(heavily_worn, 300.0, 1.25, asked=asked))
    assert alone[0].pressure.shape != alone[-1].pressure.shape
    for state, exact in zip(alone, on_own_grid, strict=True):
        if state.heat:
            assert np.array_equal(state.heat.rise, exact.heat.rise)
            assert np.array_equal(state.wear_depth, exact.wear_depth)
    assert total_work(alone) > total_work(on_own_grid)


@pytest.mark.parametrize("heat_model", ["elapsed", "history"])
def test_where_few_elements_touch_they_are_smaller(heat_model):
    few = {"fewest_elements": 400, "increments": 8, "heat_model": heat_model}
    scene = rough_scene(pixels_per_element=4, **few)
    pixels = replace(scene, fidelity=replace(scene.fidelity, pixels_per_element=1))
    alone, exact = (list(simulate(variant, 300.0, 1.25)) for variant in (scene, pixels))
    assert np.array_equal(alone[-1].heat.rise, exact[-1].heat.rise)
    assert alone[0].pressure.shape == (48, 24)
    assert [state.heat is None for state in alone] == [True] * (len(alone) - 1) + [False]
    assert measures(scene, alone[-1]) == measures(pixels, exact[-1])
    assert warnings(scene, alone[-1]) == []


def test_elements_are_no_smaller_than_is_needed_for_enough_to_touch():
    scene = rough_scene(pixels_per_element=4, fewest_elements=60, increments=8)
    shapes = {load: last(scene, load, 1.25).pressure.shape for load in (50.0, 600.0)}
    assert shapes == {50.0: (96, 48), 600.0: (48, 24)}


@pytest.mark.parametrize(
    ("changes", "coarsening"),
    [
        ({}, 4),
        ({"pixels": Grid((180, 90), (2e-6, 2e-6))}, 3),  # 4 does not divide it
        ({"pixels": Grid((64, 64), (2e-6, 2e-6))}, 2),  # too few elements would be left
        ({"wear": Wear(1.2e-15, "local")}, 1),  # which keeps what the roughness did to it
        ({"fidelity": Fidelity(heat_model="history")}, 1),
    ],
)
def test_the_history_is_as_coarse_as_the_scene_allows(changes, coarsening):
    scene = rough_scene(history_coarsening=4)
    assert replace(scene, **changes).coarsening == coarsening


def test_what_the_elements_decide_is_measured_on_the_scene_s_own_grid_alone():
    scene = rough_scene(history_coarsening=4)
    states = list(simulate(scene, 600.0, 1.25))
    of_contact = "contact_width", "contact_fraction", "max_pressure", "saturated_fraction"
    for state in states[:-1]:
        values = measures(scene, state)
        assert all(np.isnan(values[name]) for name in (*of_contact, "mean_pressure"))
    values = measures(scene, states[-1])
    mean = values["mean_pressure"] * values["contact_fraction"] * scene.grid.area
    assert mean == pytest.approx(600.0 / scene.pin.patches(scene.grid), rel=1e-9)
    assert all(np.isfinite(values[name]) for name in of_contact)
    volumes = [measures(scene, state)["wear_volume"] for state in states]
    assert volumes == pytest.approx(
        [measures(full, state)["wear_volume"] for full in [rough_scene()] for state in
         simulate(full, 600.0, 1.25)], rel=1e-9
    )  # fmt: skip


# No wear.


@pytest.mark.parametrize("wear", [None, Wear(0.0)])
def test_without_wear_a_point_is_one_step(wear):
    scene = with_hardness(small_scene(contact_tolerance=1e-8, heat_tolerance=1e-9), 3e9)
    scene = replace(scene, wear=wear)
    states = list(simulate(scene, 600.0, 1.25))
    assert len(states) == 1
    # The way there changes nothing: a pin that hardly wears gets to the same, plastic yield and
    # all, in 8 steps.
    hardly = list(simulate(replace(scene, wear=Wear(1e-25)), 600.0, 1.25))
    assert len(hardly) == 8
    assert measures(scene, states[0])["saturated_fraction"] > 0
    assert states[0].pressure == pytest.approx(hardly[-1].pressure, abs=1e-5 * 6.6e9)
    assert states[0].heat.rise == pytest.approx(hardly[-1].heat.rise, rel=1e-5)


def test_without_wear_the_steps_are_those_that_are_asked_for():
    scene = small_scene(wear=False)
    alone = list(simulate(scene, 600.0, 1.25, asked=(3, 6)))
    assert [state.normal_load for state in alone] == [225.0, 450.0, 600.0]
    assert all(state.heat is not None for state in alone)


@pytest.mark.parametrize("interval", [1, 3])
def test_without_wear_a_temperature_on_the_way_changes_no_other(interval):
    scene = small_scene(wear=False, contact_tolerance=0.1)
    (*_, alone), (*_, on_the_way) = (
        simulate(scene, 600.0, 1.25, asked=asked) for asked in ((), range(0, 9, interval))
    )
    assert np.array_equal(alone.pressure, on_the_way.pressure)
    assert np.array_equal(alone.heat.rise, on_the_way.heat.rise)


# Both bodies smooth.


def smooth(pattern, **fidelity):
    """A scene that is a plane one, and the same that does not know it."""
    plane = replace(
        small_scene(pattern, roughness=False, contact_tolerance=1e-9, heat_tolerance=1e-9),
        pixels=Grid((96, 64), (4e-6, 4e-6)),
    )
    zero = MeasuredRoughness(np.zeros(plane.pixels.shape))
    return plane, replace(plane, roughness=zero)


@pytest.mark.parametrize("pattern", ["swept", "local"])
def test_a_smooth_scene_is_a_plane_one(pattern):
    plane, full = smooth(pattern)
    assert plane.grid.shape == (96, 1)
    ours, theirs = (list(simulate(scene, 600.0, 1.25)) for scene in (plane, full))
    assert total_work(theirs) > 50 * total_work(ours)
    one, other = ours[-1], theirs[-1]
    assert one.heat.rise_quantile == pytest.approx(other.heat.rise_quantile, rel=1e-6)
    for name in ("pressure", "wear_depth"):
        field = getattr(other, name)
        same = pytest.approx(field, abs=1e-6 * field.max())
        assert np.broadcast_to(getattr(one, name), field.shape) == same
    values, expected = measures(plane, one), measures(full, other)
    for name in ("contact_width", "mean_pressure", "wear_volume", "max_rise", "pin_heat_share"):
        assert values[name] == pytest.approx(expected[name], rel=1e-6)


# No friction, no motion, no hardness.


@pytest.fixture
def kernels(monkeypatch):
    """Velocity and ages of each thermal kernel that is made."""
    made = []

    def counted(grid, material, velocity, ages, *rest, **named):
        made.append((velocity, ages))
        return flux_history_spectrum(grid, material, velocity, ages, *rest, **named)

    flux_history_spectrum = duhamel.flux_history_spectrum
    monkeypatch.setattr(duhamel, "flux_history_spectrum", counted)
    forget_kernels()
    return made


def test_no_motion_needs_no_kernel(kernels):
    state = last(small_scene(), 300.0, 0.0)
    assert not kernels
    assert state.heat.iterations == 0


@pytest.mark.parametrize("heat_model", ["elapsed", "history"])
def test_no_friction_needs_no_heat(kernels, heat_model):
    scene = replace(small_scene(heat_model=heat_model), friction_heat=False)
    *_, state = simulate(scene, 300.0, 1.25)
    assert not kernels
    assert state.heat.iterations == 0
    assert not state.heat.rise.any()
    assert state.heat_history is None
    warm = last(small_scene(heat_model=heat_model), 300.0, 1.25)
    assert np.array_equal(state.pressure, warm.pressure)


def test_without_hardness_the_pressure_is_bounded_below_only():
    soft, hard = (with_hardness(small_scene(), hardness) for hardness in (3e9, np.inf))
    bounded, free = (last(scene, 600.0, 1.25) for scene in (soft, hard))
    assert bounded.pressure.max() == pytest.approx(3e9)
    assert free.pressure.max() > 3e9
    assert measures(soft, bounded)["saturated_fraction"] > 0
    assert measures(hard, free)["saturated_fraction"] == 0

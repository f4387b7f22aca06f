"""A pin at rest wears by the mean pressure over positions of the moving disk, whatever the lay."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from tests.helpers.scenes import STEEL, with_hardness
from tests.promises.moving_disk import FAMILIES, decisive, errors, family_points, oblique_heights
from tests.promises.positions import rises_at_shifts
from tribo.contact import solve_contact
from tribo.simulation import RampCache, fit_elements, heat
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.disk_positions import further_positions, passes, separation_at
from tribo.simulation.loading_step import guess_pressure, start
from tribo.simulation.step_wear import step_parts

LOAD, VELOCITY = 300.0, 1.5
PIXELS = tribo.Grid((128, 96), (4e-6, 4e-6))
HOLD = {
    "window.pixels": [288, 96],
    "window.pixel_size": ["1.632 um", "1.9 um"],
    "disk.roughness.correlation_length": ["4 um", "40 um"],
    "disk.roughness.seed": 1,
    "loading.hold": "30 s",
}
SURFACES = {
    "no lay": tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 8e-6), seed=1),
    "along": tribo.SelfAffineRoughness(0.27e-6, 0.8, (100e-6, 12e-6), seed=1),
    "across": tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 150e-6), seed=1),
    "oblique": tribo.MeasuredRoughness(oblique_heights(PIXELS, 45.0, 1, (8e-6, 150e-6))),
}


def scene_of(surface="across", **fidelity):
    choices = {"pixels_per_element": 1, "increments": 8, "contact_tolerance": 3e-2} | fidelity
    return tribo.Scene(
        pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
        disk=STEEL,
        pixels=PIXELS,
        loading=tribo.Ramp(rate=150.0, reference_load=600.0),
        roughness=SURFACES[surface],
        wear=tribo.Wear(1.2e-15),
        fidelity=tribo.Fidelity(**choices),
    )


def end(scene, ramp_cache=None, load=LOAD):
    *_, state = tribo.simulate(scene, load, VELOCITY, ramp_cache)
    return state


@pytest.mark.parametrize(("surface", "largest"), [
    ("no lay", 0.008), ("along", 0.008), ("across", 0.012), ("oblique", 0.008),
])  # fmt: skip
def test_a_pin_is_as_hot_as_under_a_moving_disk(surface, largest):
    """With the parts of the preset `fine`; with one part a rise errs at random by 0.4 %."""
    found = errors(scene_of(surface, parts=4), LOAD, VELOCITY, steps=64, loops=2)
    assert abs(found.mean()) < largest
    assert abs(found[0]) < 4 * largest  # the pin fits its own position no better than others


LONG = "lay", "measured"  # families whose test takes 13 s each, by ``-m slow`` alone


@pytest.mark.parametrize("family", [
    pytest.param(family, marks=pytest.mark.slow if family in LONG else ()) for family in FAMILIES
])  # fmt: skip
def test_a_pin_of_each_family_is_as_hot_as_under_a_moving_disk(family):
    """Strips change each point at random, by up to 1.3 % of the rise in these scenes."""
    (point,) = family_points(family, 1)
    assert abs(errors(*point, steps=64, loops=2).mean()) < 0.013


def test_a_pin_that_wears_against_a_window_at_rest_is_too_cold_there():
    """The error that positions remove: grooves across sliding, worn by one window."""
    scene = scene_of()
    bodies, worn = elastic_bodies(scene), np.zeros(scene.grid.shape)
    window_load = LOAD / scene.pin.windows(scene.grid)
    distance = VELOCITY * LOAD / scene.loading.rate / 32
    solid = scene.wear.yielding(bodies.solid, distance)
    for step in range(32):
        gap = bodies.separation + worn
        contact = solve_contact(solid, gap, window_load * (step + 0.5) / 32, scene.hardness, 0.03)
        worn = worn + scene.wear.depth(contact.pressure, distance)
    contact = solve_contact(
        bodies.solid, bodies.separation + worn, window_load, scene.hardness, 0.03
    )
    state = end(scene)
    fitting = replace(state, pressure=contact.pressure, passing=())
    assert decisive(heat(scene, fitting, VELOCITY)) < 0.93 * decisive(state.heat)


@pytest.mark.parametrize("surface", SURFACES)
def test_the_worn_volume_is_exact_and_even_along_y(surface):
    scene = scene_of(surface)
    state = end(scene)
    assert np.array_equal(state.wear_depth, np.repeat(state.wear_depth[:, :1], 96, axis=1))
    impulse = LOAD**2 / scene.loading.rate / 2
    volume = tribo.measures(scene, state)["wear_volume"]
    assert volume == pytest.approx(1.2e-15 * VELOCITY * impulse, rel=1e-9)


@pytest.mark.parametrize("fidelity", [{}, {"history_coarsening": 2}, {"parts": 3}])
def test_a_point_is_the_same_alone_and_after_others(fidelity):
    scene, ramp_cache = scene_of(**fidelity), RampCache()
    end(scene, ramp_cache, 450.0)
    cached, alone = end(scene, ramp_cache), end(scene)
    assert np.array_equal(cached.heat.rise_quantile, alone.heat.rise_quantile)
    assert np.array_equal(cached.wear_depth, alone.wear_depth)


def test_strips_lie_at_other_positions_in_each_stage_and_keep_all_heights():
    scene = scene_of()
    heights, shifts = scene.heights(), tuple(range(0, 128, 8))
    profile = scene.pin.profile(scene.grid)
    moved = profile - separation_at(scene, None, shifts)
    for number, shift in enumerate(shifts):
        strip = slice(6 * number, 6 * number + 6)
        expected = np.roll(heights[:, strip], shift, axis=0)
        assert moved[:, strip] == pytest.approx(expected, abs=1e-12)


def strip_shifts(scene, velocity=VELOCITY):
    """Shifts of the strips in all stages of a ramp to 600 N, in elements (stages, strips)."""
    begin = start(scene)
    return np.array(
        [
            contact.strip_shifts
            for load_step in scene.load_steps(600.0)
            for part in step_parts(scene, begin, load_step, velocity)
            for contact in passes(scene, begin, part, scene.wear, velocity, False, "sdirk2")
        ]
    )


@pytest.mark.parametrize(("wear", "velocity"), [(None, VELOCITY), (tribo.Wear(1.2e-15), 0.0)])
def test_a_step_without_wear_is_one_contact(wear, velocity):
    scene = replace(scene_of(), wear=wear)
    first, *_ = scene.load_steps(600.0)
    assert len([*passes(scene, start(scene), first, wear, velocity, False, "sdirk2")]) == 1


def test_no_strip_returns_to_an_element_within_64_stages():
    shifts = strip_shifts(scene_of(parts=4))
    assert shifts.shape == (64, 32)
    assert all(len(set(strip)) == 64 for strip in shifts.T.tolist())


def test_strips_of_a_few_stages_fill_the_window_evenly():
    shifts = strip_shifts(scene_of(parts=4))
    for first in range(60):
        positions = np.sort(shifts[first : first + 4].ravel())  # 128 in 128 elements
        assert np.diff(positions, append=positions[0] + 128).max() <= 4


@pytest.mark.slow
def test_the_rise_after_a_long_hold_hardly_depends_on_positions():
    """With equal parts of its last step, it would scatter by 1.3 % (standard deviation)."""
    scene = pipeline.load_scene("first_try", "standard", HOLD).scene
    rises, _ = rises_at_shifts(scene, 200.0, 3.5)
    assert rises.std(ddof=1) < 0.009


def test_a_long_hold_ends_with_shallow_imprints():
    scene = pipeline.load_scene("first_try", "standard", HOLD).scene
    (hold_step,) = (step for step in scene.load_steps(200.0) if step.time > 31.0)
    before = replace(start(scene), time=20.0, impulse=4000.0, normal_load=200.0)
    ends = [part.time for part in step_parts(scene, before, hold_step, 3.5, ends_hold=True)]
    durations = np.diff([20.0, *ends])
    assert durations[:3] == pytest.approx(11.33 / np.array([2, 4, 8]), rel=1e-3)
    assert durations[-1] < 0.002 * 11.33
    assert durations.sum() == pytest.approx(hold_step.time - 20.0)


def test_a_step_has_as_many_contacts_at_any_velocity():
    """With other numbers of parts, the rise would jump between two velocities."""
    scene = scene_of("across", imprint=0.1, parts=2)
    counts = {len(strip_shifts(scene, velocity)) for velocity in (0.1, 1.5, 1.515, 6.0)}
    assert counts == {32}


@pytest.mark.parametrize(("preset", "parts"), [("standard", 2), ("fine", 4)])
def test_a_finer_preset_has_more_parts_under_strips(preset, parts):
    scene = scene_of()
    scene = replace(scene, fidelity=tribo.PRESETS[preset])
    assert fit_elements(scene, LOAD).fidelity.parts == parts
    rolling = replace(scene, motion=tribo.Motion(slide_roll_ratio=1.0))
    assert fit_elements(rolling, LOAD).fidelity.parts == 1


def test_a_contact_of_many_summits_needs_fewer_positions():
    counts = [len(further_positions(scene_of("no lay"), load)) + 1 for load in (10.0, 600.0)]
    assert counts[0] == 8
    fine = tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=1)
    narrow = replace(scene_of(), roughness=fine)
    assert [len(further_positions(narrow, load)) + 1 for load in (50.0, 200.0, 600.0)] == [8, 4, 2]
    # Hertz's half-width with which 4 positions touch 5000 squares of the correlation length.
    half_width = 5000 / 4 * 4e-6**2 / (2 * 96 * 4e-6)
    load = half_width**2 * np.pi * 115.385e9 * 3.4e-3 / (4 * 2e-3)
    loads = 0.97 * load, 1.03 * load
    assert [len(further_positions(narrow, load)) + 1 for load in loads] == [8, 4]
    assert further_positions(replace(narrow, wear=None), LOAD) == []
    assert further_positions(replace(narrow, motion=tribo.Motion(slide_roll_ratio=1.0)), LOAD) == []


def test_a_guessed_contact_carries_the_load_except_above_the_hardness():
    scene = scene_of()
    state = end(scene)
    shapes = [separation_at(scene, None) + state.wear_depth]
    (elastic,) = guess_pressure(with_hardness(scene, np.inf), state, shapes)
    area = scene.grid.element_area * scene.pin.windows(scene.grid)
    assert elastic.sum() * area == pytest.approx(LOAD)
    hardness = elastic.max() / 2
    (guess,) = guess_pressure(with_hardness(scene, hardness), state, shapes)
    np.testing.assert_array_equal(guess, np.minimum(elastic, hardness))


def test_only_the_end_has_several_positions_and_its_temperature_is_their_mean():
    scene = scene_of()
    states = list(tribo.simulate(scene, LOAD, VELOCITY, requested=range(100)))
    assert [len(state.passing) for state in states[:-1]] == [0] * (len(states) - 1)
    last = states[-1]
    pressures = last.pressure, *last.passing
    assert len(pressures) == 8
    places = [heat(scene, replace(last, pressure=p, passing=()), VELOCITY) for p in pressures]
    for name in ("rise_quantile", "max_rise", "mean_rise", "pin_heat_share"):
        expected = np.mean([getattr(place, name) for place in places], axis=0)
        assert getattr(last.heat, name) == pytest.approx(expected, rel=2e-3)  # as the heat
    assert np.array_equal(last.heat.rise, places[0].rise)


def test_a_group_is_left_out_at_all_positions():
    scene = scene_of()
    state = end(scene)
    sampled = heat(scene, state, VELOCITY, is_sampled=True)
    pressures = state.pressure, *state.passing
    positions = [replace(state, pressure=p, passing=()) for p in pressures]
    heats = [heat(scene, position, VELOCITY, is_sampled=True) for position in positions]
    expected = np.mean([position.quantile_without for position in heats], axis=0)
    assert sampled.quantile_without[:, 5:] == pytest.approx(expected[:, 5:], rel=3e-3)
    assert sampled.jackknife == heats[0].jackknife

"""A cylinder in a window as long as it is, with free ends."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL
from tribo.analytic import hertz_contact
from tribo.contact import ElasticHalfSpace, solve_contact

E_STAR = tribo.contact_modulus(STEEL, STEEL)
LENGTH = 0.6e-3
SHARP = tribo.Cylinder(2e-3, LENGTH, STEEL)
WINDOW = tribo.Grid((64, 96), (5e-6, LENGTH / 96), (False, False))
SCENE = tribo.Scene(
    pin=SHARP,
    disk=STEEL,
    pixels=WINDOW,
    loading=tribo.Ramp(150.0, 100.0),
    roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), 1),
    wear=tribo.Wear(1.2e-15, "swept"),
    fidelity=tribo.Fidelity(pixels_per_element=1, increments=6, contact_tolerance=1e-3),
)

SMOOTH = replace(SCENE, roughness=None, wear=tribo.Wear(1.2e-15, "local"))


def end(scene, load=100.0, velocity=1.0):
    *_, state = tribo.simulate(scene, load, velocity)
    return state


def test_a_relief_of_the_whole_length_makes_a_crowned_roller():
    """A parabola that drops by d over half the length L has the crown radius L²/(8 d)."""
    relief = tribo.Relief(4e-6, LENGTH / 2)
    relieved, load = replace(SHARP, relief=relief), 5.0
    hertz = hertz_contact(load, E_STAR, 2e-3, crown_radius=LENGTH**2 / (8 * relief.depth))
    assert hertz.aspect * hertz.half_width < LENGTH / 2
    grid = tribo.Grid((96, 384), (4 * hertz.half_width / 96, LENGTH / 384), (False, False))
    solid = ElasticHalfSpace(grid, E_STAR)
    contact = solve_contact(solid, relieved.profile(grid), load, tolerance=1e-6)
    assert contact.pressure.max() == pytest.approx(hertz.peak_pressure, rel=5e-3)


def test_sharp_ends_of_the_papers_pin_carry_more_than_its_middle():
    """Shares of the load per length of a smooth, worn pin, by another script on other meshes."""
    grid = tribo.Grid((48, 170), (0.45e-3 / 48, 3.4e-3 / 170), (False, False))
    pin = replace(SHARP, length=3.4e-3)
    state = end(replace(SMOOTH, pin=pin, pixels=grid, loading=tribo.Ramp(150.0, 750.0)), 400.0, 2.3)
    line, y = state.pressure.sum(axis=0) * grid.spacing[0], np.abs(grid.coordinates(1))
    assert line.sum() * grid.spacing[1] == pytest.approx(400.0, rel=1e-6)
    share = line / (400.0 / 3.4e-3)
    assert share[y < 0.34e-3].mean() == pytest.approx(0.945, abs=0.01)
    assert share[y > 1.6e-3].mean() == pytest.approx(1.24, abs=0.03)


def test_a_short_pin_of_over_200_pixels_in_contact_has_no_warning():
    state = end(SCENE)
    assert 200 < np.count_nonzero(state.pressure) < 3000
    kinds = [warning.kind for warning in tribo.warnings(SCENE, state)]
    assert tribo.WarningKind.FEW_NODES not in kinds


def test_a_hardly_worn_sharp_pin_warns_of_hot_ends_and_a_relieved_one_does_not():
    length = 3.4e-3
    pixels = tribo.Grid((64, 544), (5e-6, length / 544), (False, False))
    loading, wear = tribo.Ramp(150.0, 600.0), tribo.Wear(1e-18)
    texts = []
    for relief in (None, tribo.Relief(2e-6, 0.3e-3)):
        pin = replace(SHARP, length=length, relief=relief)
        scene = replace(SCENE, pin=pin, pixels=pixels, loading=loading, wear=wear)
        texts.append([warning.text for warning in tribo.warnings(scene, end(scene, 560.0))])
    (text,) = texts[0]
    assert text == (
        "on the hottest tenth of its contact, an end of 0.4 mm of the pin has a rise 13 % above "
        "that of the whole pin, by which the verdict is given; wear becomes severe there first: "
        "relieve the ends, or let them wear"
    )
    assert texts[1] == []


def test_a_window_with_free_ends_is_the_whole_pin():
    assert SHARP.windows(WINDOW) == 1
    assert SCENE.nominal_area == pytest.approx(WINDOW.area)


def test_a_contact_up_to_the_ends_is_no_contact_at_an_edge():
    state = end(SCENE)
    assert state.pressure[:, [0, -1]].any(axis=0).all()
    assert not [w for w in tribo.warnings(SCENE, state) if w.kind == w.kind.CONTACT_AT_EDGE]
    stages = replace(SMOOTH, loading=tribo.Stages((50.0, 100.0), (1.0, 1.0), 150.0))
    assert tribo.judge(stages, 100.0, 1.0, tribo.Conditions(0.1, 298.0, 418.0)).contact_rise > 0


def test_a_pin_under_free_ends_wears_by_the_disk_at_many_positions():
    """Wear averages over the disk: worn depths hardly follow the heights that lie there at last."""
    state = end(SCENE)
    volume = state.wear_depth.sum() * WINDOW.element_area
    impulse = 100.0**2 / 150.0 / 2  # ∫F dt of the ramp
    assert volume == pytest.approx(1.2e-15 * impulse * 1.0, rel=1e-6)
    rows = state.pressure.any(axis=1)
    depth = state.wear_depth[rows] - state.wear_depth[rows].mean(axis=1, keepdims=True)
    heights = SCENE.heights()[rows] - SCENE.heights()[rows].mean(axis=1, keepdims=True)
    assert abs(np.corrcoef(depth.ravel(), heights.ravel())[0, 1]) < 0.3


def test_wear_over_many_positions_is_that_of_the_coarse_grid_on_the_finest():
    coarse, fine = (
        end(replace(SCENE, fidelity=replace(SCENE.fidelity, **choices))).wear_depth
        for choices in ({"pixels_per_element": 2}, {"history_coarsening": 2})
    )
    expected = coarse
    for axis, size in enumerate(fine.shape):
        middles = ((np.arange(count) + 0.5) / count for count in (size, size // 2))
        expected = np.apply_along_axis(partial(np.interp, *middles), axis, expected)
    twice_the_tolerance = 2 * SCENE.fidelity.contact_tolerance  # each is solved to it
    np.testing.assert_allclose(fine, expected, rtol=twice_the_tolerance)

"""How large elements and how long steps are, by the surface and its wear."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, last, small_scene
from tribo import Grid, SelfAffineRoughness, Wear, simulate
from tribo.simulation.element_size import fit_elements


def rough(lengths, pixels=(128, 128), side=2e-6, ra=1e-6, **changes):
    """Scene with correlation lengths in pixels, and elements of at most 4 × 4 pixels."""
    fidelity = {"pixels_per_element": 4, "fewest_elements": 2}
    scene = small_scene(**fidelity | changes)
    lengths = tuple(side * length for length in lengths)
    roughness = SelfAffineRoughness(ra, 0.8, lengths, seed=0)
    return replace(scene, pixels=Grid(pixels, (side, side)), roughness=roughness)


def chosen(scene, load=600.0):
    fidelity = fit_elements(scene, load).fidelity
    return fidelity.pixels_per_element, fidelity.history_coarsening


def test_narrow_summits_need_small_elements():
    """The highest tenth of summits is 1.9, 4.3 and 7.4 pixels wide, and yields."""
    assert [chosen(rough((n, n)))[0] for n in (1.5, 8, 20)] == [1, 2, 4]
    assert chosen(rough((20, 20), ra=0.3e-6))[0] == 2  # elastic contacts, half as wide


def test_loads_that_share_a_ramp_have_the_same_elements_and_small_loads_smaller_ones():
    scene = rough((20, 20), pixels=(192, 192))
    assert len({chosen(scene, load) for load in (188.0, 300.0, 750.0)}) == 1
    assert chosen(scene, 20.0)[0] < chosen(scene, 750.0)[0]


@pytest.mark.parametrize("hardness", [6.6e9, 1e12])
def test_as_many_pixels_touch_as_expected_within_a_half(hardness):
    """The number expected without wear follows from the hardness, or from the surface's slope.

    Twice the fewest elements touch on the coarser grid of earlier steps, of 2 × 2 pixels here.
    """
    material = replace(STEEL, hardness=hardness)
    scene = rough((5, 5), ra=0.1e-6, fewest_elements=0, pixels_per_element=1, wear=False)
    scene = replace(scene, disk=material, pin=replace(scene.pin, material=material))
    touching = np.count_nonzero(last(scene, 187.5, 1.0).pressure)

    def is_enough(number):
        fidelity = replace(scene.fidelity, fewest_elements=int(number / 8))
        return chosen(replace(scene, fidelity=fidelity), 187.5)[1] >= 2

    assert is_enough(touching / 1.5)
    assert not is_enough(touching * 1.5)


@pytest.mark.parametrize(("length", "sizes"), [(2.2, (1, 1)), (3.5, (2, 1)), (10, (2, 2))])
def test_elements_are_larger_where_the_rise_is_a_mean_over_positions(length, sizes):
    """Summits are 2.1, 2.8 and 4.9 pixels wide: elements of 2 need 2.4 of them, and 3.4 locally."""
    roughness = SelfAffineRoughness(1e-6, 0.8, (length * 4e-6,) * 2, seed=0)
    for pattern, size in zip(("swept", "local"), sizes, strict=True):
        scene = replace(
            small_scene(pattern, pixels_per_element=2, fewest_elements=1, periodic=(False, False)),
            pin=tribo.Ball(5e-3, STEEL),
            pixels=Grid((128, 128), (4e-6, 4e-6), (False, False)),
            roughness=roughness,
        )
        assert chosen(scene)[0] == size


@pytest.mark.parametrize("side", [4e-6, 6e-6, 20e-6, 60e-6])
def test_a_contact_of_few_elements_is_solved_more_tightly(side):
    """In proportion to those within the circle of Hertz, up to 2000; at the least, to 0.1 %."""
    scene = small_scene("local", roughness=False, wear=False, contact_tolerance=0.1,
                        fewest_elements=1)  # fmt: skip
    count = round(600e-6 / side)
    scene = replace(
        scene,
        pin=tribo.Ball(5e-3, STEEL),
        pixels=Grid((count, count), (side, side), (False, False)),
        loading=tribo.MeasuredLoad(np.array([0.0, 5.0]), np.array([0.0, 50.0])),
    )
    radius = (0.75 * 50.0 * 5e-3 / tribo.contact_modulus(STEEL, STEEL)) ** (1 / 3)
    expected = np.clip(0.1 * np.pi * (radius / side) ** 2 / 2000, 1e-3, 0.1)
    fitted = fit_elements(scene, 50.0).fidelity.contact_tolerance
    assert fitted == pytest.approx(expected, rel=1e-4)


def test_a_point_has_the_elements_of_its_surface():
    scene = rough((1.5, 1.5), increments=4)
    pixels = replace(scene, fidelity=fit_elements(scene, 600.0).fidelity)
    states, pixel_states = (list(simulate(case, 600.0, 1.25)) for case in (scene, pixels))
    assert states[-1].pressure.shape == (128, 128)
    for state, pixel_state in zip(states, pixel_states, strict=True):
        assert np.array_equal(state.pressure, pixel_state.pressure)
    assert np.array_equal(states[-1].heat.rise, pixel_states[-1].heat.rise)
    assert tribo.measures(scene, states[-1]) == tribo.measures(pixels, pixel_states[-1])


# Number of steps by the wear


def local(rate=1.2e-15, pattern="local", **fidelity):
    scene = small_scene(pattern, **{"increments": 4} | fidelity)
    return replace(scene, wear=Wear(rate, pattern))


def test_a_deep_imprint_is_worn_in_more_and_shorter_steps():
    cut = last(local(imprint=1.0), 750.0, 1.25)
    once, often = (last(local(increments=n), 750.0, 1.25) for n in (4, 16))
    assert cut.index == once.index == 4
    assert cut.iterations > once.iterations / 4 * 3
    np.testing.assert_allclose(cut.wear_depth, often.wear_depth, rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(cut.heat.rise_quantile, often.heat.rise_quantile, rtol=1e-6)
    assert not np.allclose(cut.wear_depth, once.wear_depth, rtol=1e-3, atol=0)


@pytest.mark.parametrize(
    ("kind", "parts"), [("rough", 1), ("smooth", 3), ("fine", 3), ("flat", 3), ("many", 1)]
)
def test_a_dense_contact_has_three_parts_of_each_step(kind, parts):
    """Smooth bodies, heights below the elastic approach, and flat tops; 48 steps are enough."""
    scene = small_scene(fewest_elements=10, increments=48 if kind == "many" else 16)
    if kind == "fine":
        scene = replace(scene, roughness=replace(scene.roughness, ra=0.01e-6))
    elif kind == "flat":
        heights = np.minimum(scene.heights(), np.quantile(scene.heights(), 0.7))
        scene = replace(scene, roughness=tribo.MeasuredRoughness(heights))
    elif kind != "rough":
        scene = replace(scene, roughness=None)
    assert fit_elements(scene, 600.0).fidelity.parts == parts


def test_parts_of_a_step_are_steps_for_the_wear():
    parts, steps = (
        last(small_scene(roughness=False, **choices), 750.0, 1.25)
        for choices in ({"increments": 4, "parts": 3}, {"increments": 12})
    )
    assert (parts.index, steps.index) == (4, 12)
    np.testing.assert_allclose(parts.wear_depth, steps.wear_depth, rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(parts.heat.rise_quantile, steps.heat.rise_quantile, rtol=1e-6)


@pytest.mark.parametrize(
    "changes", [{"rate": 1e-19}, {"imprint": 1e6}, {"imprint": 0.0}, {"increments": 32}]
)
def test_wear_without_a_deep_imprint_is_not_worn_in_shorter_steps(changes):
    scene = local(**{"imprint": 1.0} | changes)
    plain = replace(scene, fidelity=replace(scene.fidelity, imprint=0.0))
    smooth, plain_state = (last(case, 750.0, 1.25) for case in (scene, plain))
    assert np.array_equal(smooth.pressure, plain_state.pressure)

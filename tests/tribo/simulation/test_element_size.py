"""How large elements and how long steps are, by the surface and its wear."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, last, small_scene
from tribo import Grid, MeasuredRoughness, SelfAffineRoughness, Wear, simulate
from tribo.simulation.element_size import suited

RULES = {"elements_per_summit": 1.0, "fewest_summits": 5, "fewest_elements": 20}


def rough(lengths, pixels=(128, 128), side=2e-6, ra=1e-6, **changes):
    """A scene whose surface has correlation lengths in pixels, of at most 4 × 4 an element."""
    fidelity = {"pixels_per_element": 4, "history_coarsening": 4, "averaging": "sample", **RULES}
    scene = small_scene(**fidelity | changes)
    lengths = tuple(side * length for length in lengths)
    roughness = SelfAffineRoughness(ra, 0.8, lengths, seed=0)
    return replace(scene, pixels=Grid(pixels, (side, side)), roughness=roughness)


def chosen(scene, load=600.0):
    fidelity = suited(scene, load).fidelity
    return fidelity.pixels_per_element, fidelity.history_coarsening


def test_without_the_rule_elements_are_as_the_fidelity_has_them():
    scene = rough((2, 2), elements_per_summit=0.0)
    assert suited(scene, 600.0) is scene


def test_narrow_summits_need_small_elements():
    """Summits of the highest tenth are 1.9, 3.5 and 5.3 pixels wide; steel yields on them."""
    assert [chosen(rough((n, n)))[0] for n in (1.5, 5, 12)] == [1, 2, 4]


def test_the_narrower_way_across_a_summit_counts():
    assert chosen(rough((12, 1)))[0] == chosen(rough((1, 12)))[0] == 1


def test_elastic_summits_touch_on_less_than_half_of_their_width():
    hard = replace(STEEL, hardness=1e12)
    scene = rough((5, 5))
    elastic = replace(scene, disk=hard, pin=replace(scene.pin, material=hard))
    assert (chosen(scene)[0], chosen(elastic)[0]) == (2, 1)


def test_ridges_of_a_pixel_are_seen_on_a_measured_surface():
    heights = np.zeros((128, 128))
    heights[::8] = 1e-6
    scene = rough((12, 12))
    assert chosen(replace(scene, roughness=MeasuredRoughness(heights)))[0] == 1


@pytest.mark.parametrize(("name", "number"), [("fewest_summits", 3000), ("fewest_elements", 3000)])
def test_few_summits_and_few_elements_need_pixels(name, number):
    scene = rough((12, 12))
    fidelity = replace(scene.fidelity, **{name: number})
    assert (chosen(scene)[0], chosen(replace(scene, fidelity=fidelity))[0]) == (4, 1)


def test_a_history_is_as_coarse_as_enough_elements_touch():
    """Some 3200 pixels are expected to touch at a quarter of the reference load."""
    scene = rough((5, 5), pixels=(384, 192), side=1e-6)

    def of(fewest):
        return chosen(replace(scene, fidelity=replace(scene.fidelity, fewest_elements=fewest)))

    assert [of(fewest) for fewest in (20, 40, 90, 180, 600)] == [
        (2, 4),
        (2, 3),
        (2, 2),
        (2, 1),
        (1, 1),
    ]


def test_elements_along_ridges_count_once_for_each_width():
    isotropic, ridges = (rough(lengths, pixels=(192, 192)) for lengths in ((5, 5), (40, 5)))
    assert chosen(isotropic)[1] > chosen(ridges)[1]


@pytest.mark.parametrize("pattern", ["swept", "local"])
def test_a_contact_of_few_elements_has_few_of_them_across(pattern):
    """Of a smooth contact 19 pixels wide; six rows are the least."""
    smooth = replace(rough((5, 5), pattern=pattern), roughness=None)
    hertz = smooth.pin.hertz(187.5, tribo.contact_modulus(STEEL, STEEL))
    side = 2 * hertz.half_width / 19
    pixels = Grid((128, 128), (side, side))
    fidelity = replace(smooth.fidelity, fewest_elements=0)
    assert chosen(replace(smooth, pixels=pixels, fidelity=fidelity)) == (2, 1)


def test_contacts_of_few_elements_are_solved_more_closely():
    scene = rough((5, 5), pixels=(192, 192), contact_tolerance=0.1, imprint=2.0)
    less = replace(scene, pixels=Grid((48, 48), (8e-6, 8e-6)))
    found = [suited(one, 600.0).fidelity for one in (scene, less)]
    for name, given in (("contact_tolerance", 0.1), ("imprint", 2.0)):
        fine, finer = (getattr(one, name) for one in found)
        assert given > fine > finer > 0


def test_loads_that_share_a_ramp_have_the_same_elements_and_small_loads_smaller_ones():
    scene = rough((12, 12), pixels=(192, 192))
    assert len({chosen(scene, load) for load in (188.0, 300.0, 750.0)}) == 1
    assert chosen(scene, 20.0)[0] < chosen(scene, 750.0)[0]


@pytest.mark.parametrize("hardness", [6.6e9, 1e12])
def test_as_many_pixels_touch_as_expected_within_a_half(hardness):
    """Of an unworn contact: by hardness, or by the slope of the surface."""
    material = replace(STEEL, hardness=hardness)
    scene = rough((5, 5), ra=0.1e-6, **dict.fromkeys(RULES, 0), pixels_per_element=1, wear=False)
    scene = replace(scene, disk=material, pin=replace(scene.pin, material=material))
    touching = np.count_nonzero(last(scene, 187.5, 1.0).pressure)

    def is_enough(number):
        rules = {"elements_per_summit": 1e-3, "fewest_elements": int(number / 4)}
        fidelity = replace(scene.fidelity, pixels_per_element=2, **rules)
        return chosen(replace(scene, fidelity=fidelity), 187.5)[0] == 2

    assert is_enough(touching / 1.5)
    assert not is_enough(touching * 1.5)


def test_a_point_has_the_elements_of_its_surface():
    scene = rough((1.5, 1.5), increments=4)
    pixels = replace(scene, fidelity=suited(scene, 600.0).fidelity)
    alone, exact = (list(simulate(one, 600.0, 1.25)) for one in (scene, pixels))
    assert alone[-1].pressure.shape == (128, 128)
    for one, other in zip(alone, exact, strict=True):
        assert np.array_equal(one.pressure, other.pressure)
    assert np.array_equal(alone[-1].heat.rise, exact[-1].heat.rise)
    assert tribo.measures(scene, alone[-1]) == tribo.measures(pixels, exact[-1])


# Steps by the wear.


def local(rate=1.2e-15, pattern="local", **fidelity):
    scene = small_scene(pattern, **{"increments": 4, "wear_scheme": "sdirk2"} | fidelity)
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
    "changes", [{"rate": 1e-19}, {"imprint": 1e6}, {"imprint": 0.0}, {"increments": 32}]
)
def test_other_wear_is_not(changes):
    scene = local(**{"imprint": 1.0} | changes)
    plain = replace(scene, fidelity=replace(scene.fidelity, imprint=0.0))
    one, other = (last(each, 750.0, 1.25) for each in (scene, plain))
    assert np.array_equal(one.pressure, other.pressure)


def test_loads_share_a_ramp_of_cut_steps():
    scene, trunks = local(imprint=1.0), tribo.simulation.Trunks()
    together = [list(simulate(scene, load, 1.25, trunks))[-1] for load in (700.0, 400.0)]
    for state, load in zip(together, (700.0, 400.0), strict=True):
        assert np.array_equal(state.heat.rise, last(scene, load, 1.25).heat.rise)


def test_a_hold_has_steps_of_its_own():
    ramp = tribo.Ramp(rate=150.0, reference_load=750.0, hold=60.0)
    scene = replace(small_scene(increments=4, hold_increments=25), loading=ramp)
    rising, held = (
        [one for one in scene.way(600.0) if one.holding == holding] for holding in (False, True)
    )
    assert [one.normal_load for one in rising] == [187.5, 375.0, 562.5, 600.0]
    expected = [one for one in ramp.stations(600.0, 25) if one.holding]
    assert [one.time for one in held] == [one.time for one in expected]

"""Wear rates (tribo/inverse.py) of widths that the model itself has made."""

from dataclasses import replace

import pytest

from tests.helpers.scenes import last, small_scene
from tribo import Grid, InputError, Wear, measures
from tribo.inverse import specific_wear_rate
from workflows.paper.rig import critical_temperature_rig


@pytest.mark.parametrize(("rate", "rough"), [(1.2e-15, True), (3e-16, False)])
def test_wear_rate_comes_back_from_the_width_that_it_makes(rate, rough):
    scene = small_scene(roughness=rough)
    if not rough:
        scene = replace(scene, pixels=Grid((192, 1), (2e-6, 128e-6)))
    worn = replace(scene, wear=Wear(rate, "swept"))
    width = measures(worn, last(worn, 750.0, 1.25))["contact_width"]
    estimate = specific_wear_rate(scene, width, 750.0, 1.25)
    assert estimate.lowest <= rate <= estimate.highest
    assert estimate.lowest < estimate.value < estimate.highest
    if not rough:  # the rate is known well from elements of 2 µm
        assert estimate.value == pytest.approx(rate, rel=0.1)


def test_a_smooth_contact_tells_a_range_of_wear_rates():
    rig = critical_temperature_rig()
    estimate = specific_wear_rate(rig, 50.0 * rig.grid.spacing[0], 10.0, 0.065)
    assert estimate.lowest < 0.8 * estimate.highest  # the width grows by two elements at a time


def test_a_width_must_differ_from_both_ends_by_half_an_element():
    scene = small_scene(increments=3)
    side = scene.grid.spacing[0]
    plain = replace(scene, wear=None)
    unworn = measures(plain, last(plain, 750.0, 1.25))["contact_width"]
    for width in (unworn + 0.4 * side, scene.grid.size[0] - 0.4 * side):
        with pytest.raises(InputError, match="must lie between"):
            specific_wear_rate(scene, width, 750.0, 1.25)
    assert specific_wear_rate(scene, unworn + 0.6 * side, 750.0, 1.25).lowest > 0

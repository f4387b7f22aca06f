"""Wear rates (tribo/inverse.py) of widths that the model itself has made."""

from dataclasses import replace

import pytest

from tests.helpers.scenes import STEEL, last, small_scene
from tribo import Ball, Grid, InputError, Wear, measures
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


@pytest.mark.parametrize(
    ("rough", "margin", "more"), [(True, 0.5, 0.0), (False, 1.0, 0.9), (False, 1.0, 1.1)]
)
def test_the_ends_of_a_rate_differ_in_width_by_what_elements_resolve(rough, margin, more):
    """A smooth contact grows by two elements; `more` elements are wider than such a width."""
    scene = small_scene(roughness=rough, increments=3)

    def width(rate):
        worn = replace(scene, wear=Wear(rate, "swept"))
        return measures(worn, last(worn, 750.0, 1.25))["contact_width"]

    side_length = scene.grid.spacing[0]
    measured = width(1e-15) + more * side_length
    estimate = specific_wear_rate(scene, measured, 750.0, 1.25)
    for rate, side in ((estimate.lowest, -1), (estimate.highest, 1)):
        limit = measured + side * margin * side_length
        assert width(0.98 * rate) < limit <= width(1.02 * rate)


@pytest.mark.parametrize(
    ("pin", "load", "rate", "pattern"),
    [(None, 750.0, 1e-15, "swept"), (Ball(8e-3, STEEL), 2.0, 3e-14, "local")],
)
def test_a_scene_without_wear_gets_a_pattern_by_its_pin(pin, load, rate, pattern):
    scene = small_scene(periodic=(False, not pin), increments=3)
    scene = replace(scene, pin=pin) if pin else scene
    plain, worn = replace(scene, wear=None), replace(scene, wear=Wear(rate, pattern))
    test = measures(worn, last(worn, load, 1.25))["contact_width"], load, 1.25
    assert specific_wear_rate(plain, *test) == specific_wear_rate(worn, *test)


def test_a_width_must_differ_from_both_ends_by_half_an_element():
    scene = small_scene(increments=3)
    side = scene.grid.spacing[0]
    plain = replace(scene, wear=None)
    unworn = measures(plain, last(plain, 750.0, 1.25))["contact_width"]
    for width in (unworn + 0.4 * side, scene.grid.size[0] - 0.4 * side):
        with pytest.raises(InputError, match="must lie between"):
            specific_wear_rate(scene, width, 750.0, 1.25)
    assert specific_wear_rate(scene, unworn + 0.6 * side, 750.0, 1.25).lowest > 0

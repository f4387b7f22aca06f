"""Inverse problems (tribo/inverse.py), on points that the model itself has made."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import last, small_scene
from tribo import QUANTILES, Grid, InputError, Wear, measures
from tribo.inverse import Transition, critical_temperature, specific_wear_rate
from workflows.paper.rig import critical_temperature_rig

BULK, CRITICAL = 25.0, 145.0
DECISIVE = QUANTILES.index(0.9)


def transition(scene, load, friction, velocities):
    """Velocity of the model's transition, interpolated between a few velocities."""
    rises = [last(scene, load, v).heat.rise_quantile[DECISIVE] for v in velocities]
    wanted = (CRITICAL - BULK) / friction
    assert rises[0] < wanted < rises[-1]
    return Transition(load, float(np.interp(wanted, rises, velocities)), friction)


@pytest.fixture(scope="module")
def transitions():
    scene = small_scene()
    return [
        transition(scene, 750.0, 0.103, [0.8, 1.0, 1.2, 1.4]),
        transition(scene, 200.0, 0.094, [4.0, 4.5, 5.0, 5.5]),
    ]


def test_critical_temperature_comes_back_from_the_model_s_own_transitions(transitions):
    estimate = critical_temperature(small_scene(), transitions, BULK)
    # Linear interpolation over steps of a fifth of the velocity leaves less than 1 °C.
    assert estimate.temperatures == pytest.approx([CRITICAL] * 2, abs=1.0)
    assert estimate.mean == pytest.approx(np.mean(estimate.temperatures))
    assert estimate.spread == pytest.approx(np.std(estimate.temperatures, ddof=1))
    assert estimate.spread < 1.0
    assert math.isnan(critical_temperature(small_scene(), transitions[:1], BULK).spread)


def test_a_smaller_share_is_a_hotter_part_and_none_the_maximum(transitions):
    load, velocity, friction = transitions[0]
    state = last(small_scene(), load, velocity)
    tenth, twentieth, hottest = (
        critical_temperature(small_scene(), transitions[:1], BULK, share).mean
        for share in (0.1, 0.05, 0.0)
    )
    assert tenth < twentieth < hottest
    assert hottest == pytest.approx(BULK + friction * state.heat.max_rise)


@pytest.mark.parametrize(
    ("transitions", "share", "said"),
    [
        ([], 0.1, "no transition"),
        ([(300.0, 1.0, 0.1)], 1.0, "share is 1"),
        ([(300.0, 1.0, 0.0)], 0.1, "friction"),
        ([(-300.0, 1.0, 0.1)], 0.1, "normal_load"),
    ],
)
def test_what_is_no_transition_is_refused(transitions, share, said):
    with pytest.raises(InputError, match=said):
        critical_temperature(small_scene(), transitions, BULK, share)


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
    if not rough:  # elements of 2 µm leave little room
        assert estimate.value == pytest.approx(rate, rel=0.1)


def test_a_smooth_contact_tells_a_range_of_wear_rates():
    rig = critical_temperature_rig()
    estimate = specific_wear_rate(rig, 50.0 * rig.grid.spacing[0], 10.0, 0.065)
    assert estimate.lowest < 0.8 * estimate.highest  # it grows by two elements at a time


def test_no_critical_temperature_is_made_of_an_unknown_bulk():
    with pytest.raises(InputError, match="both must be finite"):
        critical_temperature(
            critical_temperature_rig(), [(10.0, 0.065, 0.1)], 298.15, bulk_difference=math.nan
        )


@pytest.mark.parametrize("width", [1e-4, 4e-4])
def test_a_width_that_no_wear_makes_is_refused(width):
    with pytest.raises(InputError, match=r"lie between 0\.000\d+ m, .* without wear, and the 0\.0"):
        specific_wear_rate(small_scene(), width, 750.0, 1.25)


def test_a_width_must_differ_from_both_ends_by_half_an_element():
    scene = small_scene()
    side = scene.grid.spacing[0]
    plain = replace(scene, wear=None)
    unworn = measures(plain, last(plain, 750.0, 1.25))["contact_width"]
    for width in (unworn + 0.4 * side, scene.grid.size[0] - 0.4 * side):
        with pytest.raises(InputError, match="must lie between"):
            specific_wear_rate(scene, width, 750.0, 1.25)
    assert specific_wear_rate(scene, unworn + 0.6 * side, 750.0, 1.25).lowest > 0

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, last, small_scene
from tribo import (
    QUANTILES,
    Cylinder,
    Grid,
    Material,
    MeasuredRoughness,
    Ramp,
    Scene,
    Wear,
    measures,
    simulate,
)
from tribo.simulation import heat


def test_every_state_carries_its_load_and_the_time_of_the_ramp():
    scene = small_scene()
    loads = []
    for state in simulate(scene, 430.0, 1.25):
        assert state.heat or np.isnan(measures(scene, state)["max_rise"])
        on_patch = state.normal_load / scene.pin.patches(scene.grid)
        assert state.pressure.sum() * scene.grid.element_area == pytest.approx(on_patch)
        assert state.time == pytest.approx(state.normal_load / 150.0)
        assert state.sliding_distance == pytest.approx(1.25 * state.time)
        assert state.pressure.max() <= scene.hardness
        loads.append(state.normal_load)
    assert loads == [75.0, 150.0, 225.0, 300.0, 375.0, 430.0]


def test_direction_of_sliding_is_a_mirror():
    scene = small_scene()
    mirrored = replace(
        scene, roughness=MeasuredRoughness(scene.roughness.heights(scene.pixels)[::-1])
    )
    forth, back = last(scene, 300.0, 1.5), last(mirrored, 300.0, -1.5)
    # Equal within the solvers' tolerance of 1e-6, as numbers are summed in another order.
    assert back.pressure[::-1] == pytest.approx(forth.pressure, abs=1e-4 * forth.pressure.max())
    assert back.heat.rise[::-1] == pytest.approx(forth.heat.rise, rel=1e-3)


def test_temperatures_of_the_paper_s_system_are_those_of_the_trial():
    """Θ10 and Θmax of Table 4 at 200 N on the full grid are in the specification, section 3."""
    scene = Scene(
        pin=Cylinder(2e-3, 3.4e-3, STEEL),
        disk=Material(210e9, 0.3, 45.0, 7800.0, 470.0, 6.6e9),
        pixels=Grid((480, 480), (0.816e-6, 0.95e-6)),
        loading=Ramp(150.0, 750.0),
        roughness=replace(small_scene().roughness, correlation_length=(4e-6, 4e-6)),
        wear=Wear(1.2e-15, "swept"),
    )
    state = last(scene, 200.0, 3.75)
    endless = replace(scene, fidelity=replace(scene.fidelity, heat_kernel="endless"))
    as_tried = heat(endless, state, 3.75)
    ninth = QUANTILES.index(0.9)
    assert 25 + 0.094 * as_tried.rise_quantile[ninth] == pytest.approx(146.0, abs=0.5)
    assert 25 + 0.094 * as_tried.max_rise == pytest.approx(173.0, abs=0.5)
    # Section 4: a pin of finite length is 1.4 K cooler, as a mean over several surfaces.
    cooler = 0.094 * (as_tried.rise_quantile[ninth] - state.heat.rise_quantile[ninth])
    assert cooler == pytest.approx(1.4, abs=0.25)


def test_in_a_hold_the_worn_contact_cools_and_wears_on_at_full_load():
    """As in Fig. 5: with wear the temperature falls as soon as the load no longer grows."""
    scene = small_scene()
    held = replace(scene, loading=replace(scene.loading, hold=4.0))
    states = list(simulate(held, 600.0, 1.25, requested=range(100)))
    rises = [state.heat.mean_rise for state in states]
    assert len(states) == 8 + 2
    assert np.argmax(rises) == 7
    assert (np.diff(rises[7:]) < 0).all()
    assert {state.normal_load for state in states[7:]} == {600.0}
    volumes = [measures(held, state)["wear_volume"] for state in states]
    # Implicit wear at a constant load is exact: k·F·V·t.
    assert volumes[-1] - volumes[7] == pytest.approx(1.2e-15 * 600.0 * 1.25 * 4.0, rel=1e-9)
    unworn = replace(held, wear=None)
    states = simulate(unworn, 600.0, 1.25, requested=range(100))
    rises = [state.heat.mean_rise for state in states]
    assert (np.diff(rises) >= 0).all()

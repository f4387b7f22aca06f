from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import last, small_scene
from tribo import MeasuredRoughness, measures, simulate
from tribo.simulation import add_temperature


def test_direction_of_sliding_is_a_mirror():
    scene = small_scene()
    mirrored = replace(
        scene, roughness=MeasuredRoughness(scene.roughness.heights(scene.pixels)[::-1])
    )
    forth, back = last(scene, 300.0, 1.5), last(mirrored, 300.0, -1.5)
    # Equal within the solvers' tolerance of 1e-6, as numbers are summed in another order.
    assert back.pressure[::-1] == pytest.approx(forth.pressure, abs=1e-4 * forth.pressure.max())
    assert back.heat.rise[::-1] == pytest.approx(forth.heat.rise, rel=1e-3)


def test_in_a_hold_the_worn_contact_cools_and_wears_on_at_full_load():
    """As in Fig. 5: with wear the temperature falls as soon as the load no longer grows."""
    scene = small_scene()
    with_hold = replace(scene, loading=replace(scene.loading, hold=4.0))
    states = list(simulate(with_hold, 600.0, 1.25, requested=range(100)))
    rises = [state.heat.mean_rise for state in states]
    assert len(states) == 8 + 2
    assert np.argmax(rises) == 7
    assert (np.diff(rises[7:]) < 0).all()
    assert {state.normal_load for state in states[7:]} == {600.0}
    volumes = [measures(with_hold, state)["wear_volume"] for state in states]
    # Implicit wear at a constant load is exact: k·F·V·t.
    assert volumes[-1] - volumes[7] == pytest.approx(1.2e-15 * 600.0 * 1.25 * 4.0, rel=1e-9)
    unworn = replace(with_hold, wear=None)
    states = simulate(unworn, 600.0, 1.25, requested=range(100))
    rises = [state.heat.mean_rise for state in states]
    assert (np.diff(rises) >= 0).all()
    # Those not asked for are left out, but the onset and the end of the hold.
    states = list(simulate(unworn, 600.0, -1.25))
    assert [(state.time, state.sliding_distance) for state in states] == [(4.0, 5.0), (8.0, 10.0)]
    assert add_temperature(unworn, states[-1], -1.5).sliding_distance == 12.0


def test_a_scene_tells_its_parts_and_its_size():
    parts = "Cylinder, SelfAffineRoughness, Ramp, Wear"
    assert repr(small_scene()) == f"<Scene: {parts}, 48 × 16 pixels, pin radius 0.002 m>"

"""One specimen under a load that rises in stages."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import small_scene
from tests.promises.families import case_of
from tribo.simulation import RampCache, stages_of, widen_window
from tribo.thermal import rise_exceeded

LOADS = 100.0, 250.0, 400.0
STAGES = tribo.Stages(LOADS, (10.0, 20.0, 10.0), rate=150.0)
DECISIVE = 0.9


def worn_scene(loading=STAGES, **fidelity):
    """A rough pin that stages wear to 0.55 mm, in a window of 0.77 mm."""
    scene = small_scene(increments=8, imprint=0.0, **fidelity)
    return replace(
        scene, loading=loading, pixels=tribo.Grid((96, 24), (8e-6, 8e-6)), wear=tribo.Wear(1.2e-15)
    )


def rises(states):
    return np.array([float(rise_exceeded(s.heat.rise_quantile, 1 - DECISIVE)) for s in states])


@pytest.mark.parametrize("fidelity", [{}, {"history_coarsening": 2}])
def test_a_stage_is_the_same_alone_and_on_the_way_to_the_last(fidelity):
    scene, cached = worn_scene(**fidelity), RampCache()
    states = stages_of(scene, 400.0, 2.0, cached)
    for load, count in ((100.0, 2), (250.0, 4)):
        expected = stages_of(scene, load, 2.0)
        for other in (states[:count], stages_of(scene, load, 2.0, cached)):
            assert len(other) == len(expected) == count
            for a, b in zip(other, expected, strict=True):
                assert a.time == b.time
                assert np.array_equal(a.heat.rise, b.heat.rise)
                assert np.array_equal(a.wear_depth, b.wear_depth)


def test_stages_are_within_1_percent_of_a_record_typed_by_hand():
    scene = worn_scene()
    stage_rises = rises(stages_of(scene, 400.0, 2.0))
    times = np.cumsum([0.0, 100 / 150, 10.0, 1.0, 20.0, 1.0])
    record = tribo.MeasuredLoad(times, np.array([0.0, 100.0, 100.0, 250.0, 250.0, 400.0]))
    typed = replace(scene, loading=record, fidelity=replace(scene.fidelity, increments=96))
    *_, end = tribo.simulate(typed, 400.0, 2.0)
    assert stage_rises[4] == pytest.approx(rises([end])[0], rel=0.01)
    # A fresh pin under the same load is far hotter.
    *_, fresh = tribo.simulate(replace(scene, loading=tribo.Ramp(150.0, 400.0)), 400.0, 2.0)
    assert rises([fresh])[0] > 1.15 * stage_rises[4]


def test_few_steps_of_stages_are_enough_for_a_pin_that_wears_locally(tmp_path):
    """With half as many steps of ramps and holds, the rise would be 0.7 % too high."""
    sweep = case_of("stages", 14).sweep(tmp_path, "standard")
    scene, velocity = sweep.scene, sweep.velocities[1]
    loading = scene.loading
    (low, high, *_), hold, rate = loading.loads, loading.hold_times[0], loading.rate
    times = np.cumsum([0.0, low / rate, hold, (high - low) / rate])
    record = tribo.MeasuredLoad(times, np.array([0.0, low, low, high]))
    many_steps = replace(scene.fidelity, increments=96, contact_tolerance=1e-3)
    *_, end = tribo.simulate(replace(scene, loading=record, fidelity=many_steps), high, velocity)
    assert rises(stages_of(scene, high, velocity))[2] == pytest.approx(rises([end])[0], rel=0.003)


def test_worn_volume_and_distance_add_up_over_the_stages():
    states = stages_of(worn_scene(), 400.0, 2.0)
    ramps = 100.0 * (1 / 1.5) / 2, 175.0 * 1.0, 325.0 * 1.0
    impulse = sum(ramps) + 100.0 * 10 + 250.0 * 20 + 400.0 * 10
    record = tribo.measures(worn_scene(), states[-1])
    assert record["wear_volume"] == pytest.approx(1.2e-15 * 2.0 * impulse, rel=1e-9)
    assert record["sliding_distance"] == pytest.approx(2.0 * (400 / 150 + 40.0))
    assert STAGES.worn_impulse(2.0) == pytest.approx(2.0 * impulse)


def test_a_verdict_is_of_the_hottest_stage_so_far():
    oil = tribo.Conditions(0.1, bulk_temperature=298.15, critical_temperature=418.15)
    loads = 100.0, 120.0, 400.0
    scene = replace(worn_scene(tribo.Stages(loads, (60.0, 10.0, 10.0), 150.0)), roughness=None)
    verdicts = [tribo.judge(scene, load, 2.0, oil) for load in loads]
    temperatures = 298.15 + 0.1 * rises(stages_of(scene, 400.0, 2.0))
    # A worn pin is cooler at 120 N than the unworn one at 100 N.
    assert temperatures[2] < temperatures[0]
    expected = np.maximum.accumulate(temperatures)[1::2]
    governing = [verdict.governing_temperature for verdict in verdicts]
    assert governing == pytest.approx(list(expected), rel=1e-3)
    assert verdicts[1].time == verdicts[0].time == pytest.approx(100 / 150)


def test_without_wear_each_stage_is_a_contact_of_its_own():
    scene = replace(worn_scene(), wear=None)
    states = stages_of(scene, 250.0, 2.0)
    assert [state.normal_load for state in states] == [100.0, 100.0, 250.0, 250.0]
    *_, fresh = tribo.simulate(replace(scene, loading=tribo.Ramp(150.0, 250.0)), 250.0, 2.0)
    assert np.array_equal(states[2].pressure, fresh.pressure)


def test_the_window_holds_the_worn_pin():
    scene = worn_scene(tribo.Stages(LOADS, (60.0,) * 3, 150.0))
    wide = widen_window(scene, 2.0)
    *_, end = stages_of(wide, 400.0, 2.0)
    chord = np.cbrt(12 * 2e-3 * 1.2e-15 * scene.loading.worn_impulse(2.0) / scene.pin.length)
    assert tribo.measures(wide, end)["contact_width"] == pytest.approx(chord, rel=0.05)
    assert 1.25 * chord <= wide.pixels.size[0] < 1.4 * chord
    assert wide.pixels.shape[1] == scene.pixels.shape[1]
    assert wide.grid.shape[0] % 2 == 0
    assert widen_window(scene, 0.01) == scene  # its own is as wide
    assert (
        widen_window(replace(scene, loading=tribo.Ramp(150.0, 400.0)), 2.0).pixels == scene.pixels
    )
    # A ball is worn to a circle.
    ball = replace(
        scene,
        pin=tribo.Ball(5e-3, scene.pin.material),
        pixels=tribo.Grid((64, 64), (4e-6, 4e-6), (False,) * 2),
    )
    round_window = widen_window(ball, 2.0).pixels.shape
    volume = 1.2e-15 * scene.loading.worn_impulse(2.0)
    assert round_window[0] == round_window[1] > 1.25 * (64 * 5e-3 * volume / np.pi) ** 0.25 / 4e-6

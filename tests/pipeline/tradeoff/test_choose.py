"""The choices that an accuracy needs: a preset, and the whole history of the heat."""

from dataclasses import replace

import pipeline
import tribo
from pipeline.scene.written import with_fidelity
from pipeline.sweep.severity import momentary_rise
from tests.helpers.accuracy_scenes import PAPER
from tests.helpers.entries import changed

SHORT = changed(  # loads are reached within 70 and 130 ms
    PAPER,
    loads=(10.0, 20.0),
    velocities=(5.0, 10.0, 20.0),
    loading=tribo.Ramp(rate=150.0, reference_load=40.0),
    pixels=tribo.Grid((64, 32), (3e-6, 3e-6)),
    wear=tribo.Wear(1e-14),
)


def rise(sweep):
    """Decisive rise beside the boundary, at 10 N and 10 m/s."""
    *_, state = tribo.simulate(sweep.scene, 10.0, 10.0)
    return momentary_rise(sweep.scene, state, sweep.conditions)


def test_an_accuracy_takes_the_whole_history_where_present_heat_errs_by_a_third_of_it():
    past = replace(tribo.PRESETS["reference"], heat_model="history")
    exact = rise(with_fidelity(SHORT, past))
    loose, close = (pipeline.choose_accuracy(SHORT, accuracy) for accuracy in ("4%", "2%"))
    assert loose.scene.fidelity == tribo.PRESETS["standard"]
    assert close.scene.remembers_heat
    # Steps of 8 increments err by 0.3 %.
    assert abs(rise(close) / exact - 1) < 0.005 < rise(loose) / exact - 1
    assert "0.76 % too warm beside the boundary" in str(close.notes[-1])


def test_the_whole_history_needs_no_second_entry(irg):
    said = irg("check", "first_try", "--set", "heat_model=history")
    assert "points   24" in said

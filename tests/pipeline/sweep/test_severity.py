"""When wear is severe (pipeline/sweep/severity.py)."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline import Conditions, run_point
from pipeline.answers.error import (
    has_unknown_preset_error,
    preset_bound,
    preset_error_of,
    preset_error_text,
)
from pipeline.sweep.case import allowable_rise
from tests.helpers import synthetic, tiny
from tribo import PRESETS, QUANTILES
from tribo.simulation import heat
from tribo.simulation.verdict import relative_sampling, verdict, worst_rises
from tribo.thermal import failed_share

CONDITIONS = Conditions(friction=0.1, bulk_temperature=298.15, critical_temperature=418.15)
EVEN = 2000.0 * np.array(QUANTILES)
"""Rises spread evenly over the contact area from 0 to 2000 K."""


def columns(*rises, loads):
    return {
        "time": np.arange(1.0, 1 + len(rises)),
        "normal_load": np.array(loads),
        "rise_quantile": np.array(rises),
    }


@pytest.mark.parametrize("share", [0.0, 0.07, 0.5])
def test_at_the_limit_just_the_critical_area_fraction_is_above_the_critical_temperature(share):
    conditions = replace(CONDITIONS, friction=0.05, critical_area_fraction=share)
    at_limit = allowable_rise(conditions)
    rises = EVEN * at_limit / conditions.governing_rise({"rise_quantile": EVEN})
    assert failed_share(rises, allowable_rise(conditions)) == pytest.approx(share, abs=1e-12)
    deciding = conditions.governing_rise({"rise_quantile": rises})
    assert conditions.contact_temperature(deciding) == pytest.approx(
        conditions.critical_temperature
    )
    for factor, is_severe in ((1.001, True), (0.999, False)):
        judged = verdict(columns(factor * rises, loads=[600.0]), 600.0, conditions)
        assert judged.is_severe is is_severe
        assert (judged.failed_area_fraction > share) is is_severe


@pytest.mark.parametrize("share", [0.1, 0.0])
def test_each_critical_area_fraction_decides_by_its_own_temperature_everywhere(share):
    sweep = tiny.sweep(steps="course")
    result = run_point(sweep, 600.0, 1.5)
    contacts = result.state.pressure, *result.state.passing
    states = [replace(result.state, pressure=pressure, passing=()) for pressure in contacts]
    rises = [heat(sweep.scene, state, 1.5).rise[state.pressure > 0] for state in states]
    expected = np.mean([np.quantile(rise, 1 - share) for rise in rises])
    conditions = replace(sweep.conditions, critical_area_fraction=share)
    assert worst_rises(result.columns, 600.0, conditions) == pytest.approx(expected, rel=1e-3)
    judged = result.verdict(conditions)
    assert judged.governing_temperature == pytest.approx(298.15 + 0.1 * expected, rel=1e-3)
    oil = tribo.Conditions(friction=0.1, bulk_temperature=298.15, critical_area_fraction=share)
    judgement = tribo.judge(sweep.scene, 600.0, 1.5, oil)
    assert judgement.governing_temperature == pytest.approx(judged.governing_temperature, rel=1e-9)


def test_a_point_counts_by_its_worst_moment_from_when_its_load_is_reached_on():
    rises = (factor * EVEN for factor in (9.0, 0.5, 0.7, 0.6))
    judged = verdict(columns(*rises, loads=[500.0, 600.0, 600.0, 600.0]), 600.0, CONDITIONS)
    assert judged.time == 3.0
    assert judged.max_temperature == pytest.approx(298.15 + 0.1 * 0.7 * 2000)
    assert judged.governing_temperature == pytest.approx(298.15 + 0.1 * 0.7 * 1800)


def test_the_deviation_of_the_rise_is_that_of_the_contact_s_hottest_tenth_at_the_end():
    known = columns(3 * EVEN, EVEN, loads=[300.0, 600.0])
    known["rise_realization_std"] = np.interp(QUANTILES, [0.8, 1.0], [0.04, 0.06])
    assert relative_sampling(known, CONDITIONS) == pytest.approx(0.05, rel=1e-6)


# Error bounds of presets


@pytest.mark.parametrize(
    ("preset", "changes", "error"),
    [("standard", {}, 0.011), ("fine", {}, 0.0065), ("standard", {"increments": 9}, None)],
)
def test_only_a_preset_has_a_known_error(preset, changes, error):
    case = synthetic.scene(preset=None, fidelity=replace(PRESETS[preset], **changes))
    assert preset_error_of(case) == error
    assert has_unknown_preset_error(case) == (error is None)


@pytest.mark.parametrize("preset", ["standard", "fine"])
def test_a_pin_with_its_ends_states_a_larger_error_by_positions_of_the_disk(preset):
    whole, window = (
        preset_error_text(pipeline.load_scene(name, preset)) for name in ("whole_pin", "first_try")
    )
    assert "positions of the disk at most 1.3 % of the rise" in window
    assert whole == window.replace("at most 1.3 %", "at most 3.7 %")


@pytest.mark.parametrize(
    ("share", "error"), [(0.05, 0.011), (0.2, 0.011), (0.01, 0.05), (0.0, 0.05), (0.3, 0.03)]
)
def test_a_preset_promises_less_where_the_highest_or_most_of_the_contact_decides(share, error):
    assert preset_bound("standard", share) == error
    assert preset_bound("fine", share) == 0.0065
    assert preset_bound("own", share) is None

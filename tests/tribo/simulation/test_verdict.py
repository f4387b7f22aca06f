"""The verdict on a point in one call: that of a sweep, and the sum of its parts."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pipeline
import tribo
from tests.helpers import tiny
from tests.helpers.scenes import STEEL
from tribo.loading import MeasuredLoad
from tribo.simulation.verdict import hottest_step

TRACK = tribo.Track.from_pin(tiny.sweep().scene.pin, STEEL, tribo.Disc(diameter=0.1, width=0.02))
WARM = tribo.Corrections(track=TRACK)
LOADINGS = {
    "ramp": tribo.Ramp(150.0, 750.0),
    "hold": tribo.Ramp(150.0, 750.0, hold=60.0),
    "record": MeasuredLoad([0.0, 1.0, 3.0, 5.0], [0.0, 300.0, 250.0, 750.0]),
}


@pytest.mark.parametrize("loading", LOADINGS)
@pytest.mark.parametrize("parts", [None, WARM])
def test_one_call_gives_the_verdict_of_a_sweep(loading, parts):
    conditions = pipeline.Conditions(0.1, 298.15, 418.15, corrections=parts)
    sweep = tiny.sweep(loading=LOADINGS[loading], conditions=conditions, loads=(600.0,))
    conditions = sweep.conditions
    expected = pipeline.run_point(sweep, 600.0, 1.5).verdict(conditions)
    oil = tribo.Conditions(
        friction=0.1, bulk_temperature=298.15, critical_temperature=418.15, corrections=parts
    )
    verdict = tribo.judge(sweep.scene, 600.0, 1.5, oil)
    assert verdict == expected
    temperature = verdict.bulk_temperature + verdict.contact_rise + verdict.added_rise
    assert verdict.governing_temperature == pytest.approx(temperature, rel=1e-12)
    assert (verdict.added_rise != 0) == (parts is not None)
    assert verdict.is_severe == (verdict.governing_temperature > 418.15)


def test_without_a_critical_temperature_there_is_a_temperature_and_no_verdict():
    verdict = tribo.judge(
        tiny.sweep().scene, 600.0, 1.5, tribo.Conditions(friction=0.1, bulk_temperature=300.0)
    )
    assert (verdict.is_severe, verdict.failed_area_fraction) == (None, None)
    assert verdict.governing_temperature > 300.0


def test_the_script_of_the_page_prints_a_verdict(capsys):
    page = (Path(tribo.__file__).parent / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    assert "pipeline" not in code
    assert len([line for line in code.splitlines() if line]) <= 10
    exec(code, {})
    assert capsys.readouterr().out.startswith("Verdict(is_severe=")


def test_the_bodies_of_a_motion_turn_as_the_scene_says():
    scene = replace(tiny.sweep().scene, motion=tribo.Motion(slide_roll_ratio=0.5))
    both = tribo.Corrections(track=TRACK, pin_track=TRACK)
    corrections, turning = (
        tribo.Conditions(friction=0.1, bulk_temperature=300.0, corrections=parts)
        for parts in (both, replace(both, motion=scene.motion))
    )
    verdict = tribo.judge(scene, 600.0, 1.5, corrections)
    assert verdict == tribo.judge(scene, 600.0, 1.5, turning)


def test_a_hotter_step_below_the_load_does_not_count():
    rises, loads = np.array([9.0, 5.0, 4.0]), np.array([95.0, 100.0, 100.0])
    assert hottest_step(rises, loads, 100.0) == 1

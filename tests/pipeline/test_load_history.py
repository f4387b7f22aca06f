"""Heat that stays in the bodies depends on all of the load before, whatever a store keeps of it."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline import Conditions, run_point
from tests.helpers import tiny
from tests.helpers.answer_at import asked
from tests.pipeline.conftest import commit_all

PIN, STEEL = tiny.sweep().scene.pin, tiny.sweep().scene.disk
TRACK = tribo.Track.under(PIN, STEEL, 0.3)
STAYS = tribo.Corrections(track=TRACK)
ROLLING = tribo.Motion(slide_roll_ratio=0.5, track_length=0.3)
TIMES = np.array([0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 20.0, 21.0])
LOADS = np.array([0.0, 500.0, 500.0, 100.0, 100.0, 0.0, 400.0, 750.0])
RECORD = tribo.MeasuredLoad(TIMES, LOADS)
LOADINGS = {
    "ramp": tribo.Ramp(150.0, 750.0),
    "hold": tribo.Ramp(150.0, 750.0, hold=20.0),
    "record": RECORD,
}
LOAD, VELOCITY = 600.0, 1.0


def sweep_of(loading, motion=None, **changes):
    parts = replace(STAYS, motion=motion, pin_track=TRACK if motion else None)
    conditions = Conditions(0.1, 298.15, 345.0, corrections=parts)
    places = {"loads": (250.0, LOAD), "velocities": (VELOCITY,)}
    little = tribo.Wear(1e-19)  # the contact hardly widens, so that the end is the hottest time
    return tiny.sweep(
        conditions=conditions, loading=loading, motion=motion, wear=little, **places, **changes
    )


@pytest.mark.parametrize(
    ("loading", "steps", "motion"),
    [
        ("ramp", "course", ROLLING), ("hold", "end", None), ("hold", "course", ROLLING),
        ("record", "end", None), ("record", "course", ROLLING),
    ],
)  # fmt: skip
def test_a_store_gives_the_temperature_of_the_point_itself(tmp_path, loading, steps, motion):
    sweep = sweep_of(LOADINGS[loading], motion, steps=steps)
    commit_all(tmp_path / "a.zarr", sweep)
    margin = asked(tmp_path / "a.zarr", LOAD, VELOCITY)
    point = run_point(sweep_of(LOADINGS[loading], motion), LOAD, VELOCITY)
    verdict = point.verdict(sweep.conditions)
    assert margin.governing_temperature == pytest.approx(verdict.governing_temperature, rel=1e-9)

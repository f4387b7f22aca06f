"""What is said of points, inputs, surfaces and durations, in the words that users read."""

import time
from dataclasses import dataclass, replace

import pandas as pd
import pytest

from pipeline.sweep.accuracy import error_in_words, has_unknown_error, velocity_error
from pipeline.sweep.model import Point
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, duration, staged
from pipeline.uncertain.unknown import Fixed, Unknown
from tests.helpers import synthetic
from tests.helpers.entries import changed
from tribo import PRESETS


def test_a_point_is_said_with_its_place_and_variant():
    point = Point(600.0, 1.5, (("pin.radius", 0.002), ("realization", 3)))
    assert str(point) == "600 N, 1.5 m/s, pin.radius 0.002, surface 3"


def test_inputs_are_said_in_the_unit_of_the_scene():
    rate = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1", "mm^3/(N m)")
    assert str(rate) == (
        "wear.specific_wear_rate: log-normal, median 1.2e-06 mm^3/(N m), factor 1.5"
    )
    ra = Unknown("disk.roughness.ra", "uniform", (1e-7, 3e-7), "m", "µm")
    assert str(Fixed(ra, 2e-7)) == "disk.roughness.ra is fixed at 0.2 µm"


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (12.3, "12 s"),
        (1500.0, "25 min"),
        (19_800.0, "5.5 h"),
        (float("nan"), "more than 100 years"),
    ],
)
def test_a_duration_is_said_in_the_unit_that_suits_it(seconds, words):
    assert duration(seconds) == words


PIXELS = {"pixels_per_element": 1, "history_coarsening": 1}
EXACT = PIXELS | {"contact_tolerance": 1e-3}


@pytest.mark.parametrize(
    ("preset", "changes", "error"),
    [
        ("draft", {"increments": 6}, 0.05),
        ("draft", {"increments": 3}, None),
        ("draft", {"contact_tolerance": 0.09, "heat_tolerance": 1e-3}, 0.05),
        ("draft", {"contact_tolerance": 0.26}, None),
        ("draft", {"heat_tolerance": 0.011}, None),
        ("draft", {"fewest_elements": 39}, None),
        ("draft", {"elements_per_summit": 0.7}, None),
        ("draft", {"hold_increments": 7}, None),
        ("draft", {"hold_increments": 0}, None),  # as many as the ramp's 4
        ("draft", {"hold_increments": 0, "increments": 8}, 0.05),
        ("draft", {"imprint": 26.0}, None),
        ("draft", {"imprint": 0.0}, None),  # no step is cut
        ("draft", {"imprint": 0.0, "increments": 25}, 0.05),
        ("draft", PIXELS | {"fewest_elements": 0, "averaging": "mean"}, None),
        ("draft", EXACT | {"fewest_elements": 0, "averaging": "mean"}, 0.05),
        ("draft", {"averaging": "mean"}, None),
        ("draft", {"partition": "uniform"}, None),
        ("draft", {"heat_model": "history", "history_coarsening": 1}, 0.05),
        ("standard", {"history_coarsening": 1, "increments": 100}, 0.015),  # of figures 5 and 8
        ("standard", {"elements_per_summit": 1.6}, 0.05),
        ("fine", {}, 0.005),
        ("fine", {"increments": 15}, 0.015),
        ("reference", {"increments": 50}, 0.005),
    ],
)
def test_choices_that_are_at_least_as_fine_as_a_preset_keep_its_promise(preset, changes, error):
    own = synthetic.scene(preset=None, fidelity=replace(PRESETS[preset], **changes))
    assert velocity_error(own) == error
    assert has_unknown_error(own) == (error is None)


@pytest.mark.parametrize(
    "changes", [{"friction": 0.0}, {"critical_temperature": None}, {"velocities": (0.0,)}]
)
def test_an_error_is_not_missed_where_there_is_no_boundary(changes):
    own = synthetic.scene(preset=None, fidelity=replace(PRESETS["draft"], increments=3))
    assert has_unknown_error(own)
    if "velocities" not in changes:
        changes = {"conditions": replace(own.conditions, **changes)}
    assert not has_unknown_error(changed(own, **changes))


def test_a_store_errs_as_its_preset_whatever_its_heat_model_or_as_was_measured():
    draft, unnamed = synthetic.scene(preset="draft"), synthetic.scene(preset=None)
    history = replace(PRESETS["draft"], heat_model="history", history_coarsening=1)
    picked = synthetic.selection(error=0.03)
    assert velocity_error(draft) == 0.05
    assert velocity_error(unnamed) is None
    assert velocity_error(changed(unnamed, fidelity=history)) == 0.05
    assert velocity_error(changed(draft, selection=picked)) == 0.03
    assert error_in_words(draft) == ("preset draft: boundary velocities may be off by up to 5 %")


def test_an_answer_counts_the_rows_of_its_frames():
    @shown
    @dataclass
    class Answer:
        title: str
        tests: pd.DataFrame
        error: float

    for rows, words in ((0, ""), (1, "1 row"), (2, "2 rows")):
        told = str(Answer("two oils", pd.DataFrame({"load": [1.0] * rows}), float("nan")))
        counted = [line.split("tests")[1].strip() for line in told.splitlines() if "tests" in line]
        assert counted == ([words] if words else [])
        assert "not known" in told


def test_a_stage_is_told_by_its_number_and_by_the_time_that_is_left(monkeypatch):
    monkeypatch.setattr(time, "monotonic", iter((0.0, 0.0, 30.0)).__next__)
    told = []
    assert list(staged([1.0, 3.0], told.append, "stage {:g}".format, weight=float)) == [1.0, 3.0]
    assert told == [
        Progress("1 of 2: stage 1", 0, 2, elapsed=0.0),
        Progress("2 of 2: stage 3 (about 2 min to go)", 1, 2, elapsed=30.0, time_to_go=90.0),
    ]

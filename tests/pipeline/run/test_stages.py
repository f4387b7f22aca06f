"""Specimens loaded in stages: their stored values and their tests."""

import numpy as np
import pytest

import pipeline
from pipeline.answers.evidence import outcome_of
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.sweep import plan
from tests.helpers.scenes import SCENE
from tests.helpers.stores import commit_all
from tribo.simulation.film import film_inlet

STAGES = 'stages = { first = "100 N", step = "20 N", hold = "20 s" }'
TEXT = (
    SCENE.replace('reference_load = "750 N"', STAGES)
    .replace('["200 N", "400 N", "600 N"]', '["100 N", "120 N", "140 N"]')
    .replace('["1 m/s", "2 m/s", "4 m/s"]', '["1 m/s", "2 m/s"]')
    .replace("increments = 10", "increments = 4")
    .replace("[48, 16]", "[96, 16]")
)
TESTS = """
[[tests]]
velocity = "2 m/s"
stages = { first = "100 N", step = "20 N", hold = "20 s" }
mild_up_to = "100 N"
severe_at = "120 N"

[[tests]]
velocity = "2 m/s"
stages = [["60 N", "1 s"], ["400 N", "1 s"]]
mild_up_to = "60 N"
severe_at = "400 N"
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A plane of stages and two tests by stages, computed in this process."""
    folder = tmp_path_factory.mktemp("stages")
    (folder / "lab.toml").write_text(TEXT + TESTS, encoding="utf-8")
    sweep = pipeline.load_scene(folder / "lab.toml")
    commit_all(folder / "lab.zarr", sweep)
    return sweep, folder / "lab.zarr"


def test_onset_and_end_of_each_stage_are_stored(store):
    ds = pipeline.open_sweep(store[1]).sel(velocity=2)
    assert ds.sizes["step"] == 6
    ramps = 100 / 150, 20 / 150, 20 / 150
    ends = np.cumsum([[ramp, 20.0] for ramp in ramps])
    assert ds["time"].sel(load=140).values == pytest.approx(ends)
    assert ds["normal_load"].sel(load=140).values.tolist() == [100, 100, 120, 120, 140, 140]
    first = ds["mean_rise"].sel(load=100).values
    assert np.isnan(first[:4]).all()
    assert first[4:].tolist() == ds["mean_rise"].sel(load=140).values[:2].tolist()


def test_the_deciding_rise_is_the_highest_of_the_specimen_so_far(store):
    ds = pipeline.open_sweep(store[1])
    governing = pipeline.margin(ds, [100.0, 120.0, 140.0], [2.0] * 3)[
        "governing_temperature"
    ].values
    steps = pipeline.temperatures(ds)["temperature_quantile"].sel(
        area_fraction_below=0.9, velocity=2
    )
    temperatures = steps.sel(load=140).values
    # The unworn first stage is hotter than the second.
    assert temperatures[2] < temperatures[0]
    assert governing == pytest.approx(np.maximum.accumulate(temperatures)[1::2], rel=1e-9)
    point = pipeline.run_point(store[0].single_case(), 120.0, 2.0)
    assert point.verdict(store[0].conditions).governing_temperature == pytest.approx(
        governing[1], rel=1e-12
    )


def test_the_film_is_that_of_the_contact_after_the_last_stage(store):
    scene, steps = store[0].scene, plan.choose_stored_steps(store[0])
    result = plan.run_point(scene, steps, plan.Point(140.0, 2.0), with_film=True)
    expected = film_inlet(scene, result.state)
    for values, expected_values in zip(result.film.values(), expected, strict=True):
        assert values == pytest.approx(expected_values, rel=1e-12)


def test_a_test_by_stages_is_one_interval_and_a_transition_where_it_is_no_hotter(store):
    (case,) = cases_of(store[1])
    evidence = verdict_model(case, case.sweep.conditions).evidence
    assert [row.reason for row in evidence.rows] == [""] * 4
    cooler, hotter = map(outcome_of, evidence.specimens)
    assert cooler.severe <= cooler.mild  # 120 N is no hotter than the unworn stage at 100 N
    mild, severe = evidence.specimens[-1]
    assert (hotter.severe, hotter.mild) == (severe.severe, mild.mild)
    assert hotter.severe - hotter.mild > 0.3

"""Friction by temperature from a scene to its answers: solved where a verdict hangs on it."""

import numpy as np
import pytest

import pipeline

BUMP = {
    "friction.by_temperature": [
        {"temperature": "27 degC", "coefficient": 0.1},
        {"temperature": "107 degC", "coefficient": 0.16},
        {"temperature": "187 degC", "coefficient": 0.06},
    ],
    "temperature.critical": "152 degC",
    "without": ["measured"],
}
JUMP = {
    "disk.roughness.ra": "0.6 um",
    "friction.coefficient": 0.08,
    "friction.by_temperature": [
        {"temperature": "25 degC", "coefficient": 0.08},
        {"temperature": "117 degC", "coefficient": 0.08},
        {"temperature": "127 degC", "coefficient": 0.2},
        {"temperature": "700 degC", "coefficient": 0.2},
    ],
    "without": ["measured"],
}


def scene(entries, **changes):
    return pipeline.load_scene("first_try", overrides=entries | changes)


@pytest.fixture(scope="module")
def bump(tmp_path_factory):
    path = tmp_path_factory.mktemp("bump") / "bump.zarr"
    places = {"sweep.loads": ["600 N"], "sweep.velocities": ["0.4 m/s", "1.4 m/s", "1.6 m/s"]}
    pipeline.run_sweep(scene(BUMP, **places), path)
    return path


@pytest.mark.parametrize("preset", ["draft", "standard"])
def test_a_bump_of_friction_is_solved_and_not_taken_part_by_part(preset):
    """Plain iteration in steps of 0.3 gives 155.0 to 155.1 °C; each part alone 149 °C."""
    sweep = pipeline.load_scene("first_try", preset=preset, overrides=BUMP)
    verdict = pipeline.run_point(sweep, "600 N", "1.5 m/s").verdict(sweep.conditions)
    assert verdict.friction == "solved"
    assert 154.9 < verdict.decisive_temperature - 273.15 < 155.3
    # A tenth of the contact is above 155.1 °C.
    assert 0.1 < verdict.failed_fraction < 0.2


def test_a_jump_of_friction_ignites_the_contact_and_the_point_says_so():
    sweep = scene(JUMP)
    cold = pipeline.run_point(sweep, "200 N", "2.2 m/s")
    assert cold.verdict(sweep.conditions).friction == "solved"
    assert 103.0 < cold.verdict(sweep.conditions).decisive_temperature - 273.15 < 103.6
    hot = pipeline.run_point(sweep, "200 N", "2.5 m/s")
    verdict = hot.verdict(sweep.conditions)
    assert (verdict.friction, verdict.is_severe) == ("ignites", True)
    assert [str(one).partition(":")[0] for one in hot.warnings] == ["the contact ignites"]


def test_solved_rises_are_stored_beside_those_at_friction_1(bump):
    ds = pipeline.open_sweep(bump)
    solved = ds["coupled_rise"].sel(load=600.0)
    assert np.isnan(solved.sel(velocity=0.4))  # far below its limit: not solved
    verdict = pipeline.run_point(scene(BUMP), "600 N", "1.6 m/s").verdict(scene(BUMP).conditions)
    temperature = 298.15 + 0.1 * solved.sel(velocity=1.6).item()
    assert temperature == pytest.approx(verdict.decisive_temperature, abs=1e-3)
    assert temperature - 273.15 > 155.0


def test_an_answer_takes_the_solved_temperature_with_no_error_of_friction(bump):
    here = pipeline.margin(bump, "600 N", "1.6 m/s")
    plain = scene(BUMP)
    verdict = pipeline.run_point(plain, "600 N", "1.6 m/s").verdict(plain.conditions)
    assert here.decisive_temperature == pytest.approx(verdict.decisive_temperature, abs=1e-3)
    assert here.error.counted == 0


def test_other_values_than_those_solved_for_have_the_error_of_the_whole_curve(bump):
    """The error is 0.3 of the largest change of ln(friction) between bulk and limit."""
    here = pipeline.margin(pipeline.at(bump, critical_temperature="150 degC"), "600 N", "1.6 m/s")
    assert here.error.counted == 0  # the critical temperature may be changed afterwards
    warm = pipeline.margin(pipeline.at(bump, friction=0.11), "600 N", "1.6 m/s")
    assert warm.error.counted > 6.0  # 149 °C, found for each part alone, is 6 K too low
    assert "only a run of the scene solves" in warm.error.text
    warm = pipeline.margin(pipeline.at(bump, bulk_temperature="30 degC"), "600 N", "1.6 m/s")
    row = {"load": ["600 N"], "velocity": ["1.6 m/s"], "bulk_temperature": ["30 degC"]}
    distance = pipeline.margin(bump, row)["distance [K]"].item()
    assert distance == pytest.approx(warm.distance)

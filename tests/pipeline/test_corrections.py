"""Corrections of the simulated rise, which need no new simulation and act on all answers."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline import Conditions, run_point
from pipeline.answers.results import sweep_of
from tests.helpers import synthetic, tiny
from tests.helpers.answer_at import asked
from tests.helpers.scenes import SCENE
from tests.helpers.stores import commit_all
from tests.helpers.sweeps import with_fields
from tribo import InputError

RISE, ADDED = {"added_rise_fraction": "+6 %"}, 1.06
LINE = "+6 % is added to the rise for effects outside the model (irg help physics)"


def without_tests(ds):
    """The sweep without tests: a measured friction would not follow another one of the scene."""
    return with_fields(ds, tests=())


def test_it_acts_as_more_friction_does():
    ds = without_tests(synthetic.sweep())
    rubbed = {"friction": ADDED * sweep_of(ds).conditions.friction}
    plain, boundary, like = (
        pipeline.boundary(ds, **conditions) for conditions in ({}, RISE, rubbed)
    )
    for name in ("critical_velocity", "critical_load", "critical_velocity_p50"):
        np.testing.assert_allclose(boundary[name], like[name], rtol=1e-12)
        assert not plain[name].equals(boundary[name])
    margin, same = (asked(ds, 600.0, 1.2, **conditions) for conditions in (RISE, rubbed))
    for name in ("governing_temperature", "temperature_margin", "probability", "probability_high"):
        assert getattr(margin, name) == pytest.approx(getattr(same, name), rel=1e-9)
    both = pipeline.temperatures(ds, **RISE), pipeline.temperatures(ds, **rubbed)
    xr.testing.assert_allclose(*(dataset.drop_attrs() for dataset in both), rtol=1e-12)


def test_each_answer_names_it_where_it_is_not_zero(irg, monkeypatch, tmp_path):
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: synthetic.sweep())
    point = "--load=600 N", "--velocity=2 m/s"
    at = "--at", "model.rise=+6 %"
    for command in (("boundary", "a.zarr"), ("margin", "a.zarr", *point)):
        assert irg(*command, *at).count(LINE) == 1
        for none in ((), ("--at", "model.rise=0")):
            assert "outside the model" not in irg(*command, *none)
    assert "25 °C, rise +6 %" in irg("boundary", "a.zarr", *at)
    assert "rise −5 %" in irg("boundary", "a.zarr", "--at", "model.rise=-5 %")
    (tmp_path / "own.toml").write_text(SCENE)
    assert LINE in irg("point", tmp_path / "own.toml", *point, "--set", "model.rise=+6 %")


def test_a_critical_temperature_from_tests_contains_it():
    ds = synthetic.sweep()
    plain, added = (
        pipeline.infer(ds, **conditions)["critical_temperature"].item() - 298.15
        for conditions in ({}, RISE)
    )
    assert added == pytest.approx(ADDED * plain, rel=0.01)  # the prior stays where it is


# Corrections for bodies that are no half-spaces

PIN, STEEL = tiny.sweep().scene.pin, tiny.sweep().scene.disk
WARM = tribo.Corrections(track=tribo.Track.from_pin(PIN, STEEL, 0.34))
CONDITIONS = Conditions(0.1, 298.15, 345.0)


def test_corrections_cost_no_point_and_change_no_stored_number(copy):
    plain = pipeline.open_sweep(copy).load()
    sweep = tiny.full(conditions=replace(CONDITIONS, corrections=WARM))
    assert not pipeline.run_sweep(sweep, copy, workers=1).computed
    ds = pipeline.open_sweep(copy)
    assert ds.drop_attrs().equals(plain.drop_attrs())
    assert "earlier revolutions of the disk" in pipeline.boundary(ds).attrs["conditions"]


def test_bodies_that_roll_have_a_track_each(tmp_path):
    """A diameter gives the circumference as track length, over which the pin's wear spreads."""
    (tmp_path / "plain.toml").write_text(SCENE)
    entries = {"motion": {"slide_roll_ratio": 0.5}, "pin.diameter": "10 cm", "pin.width": "1 cm"}
    entries |= {"disk.track_length": "40 cm"}
    scene = pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)
    corrections = scene.conditions.corrections
    assert corrections.pin_track.length == pytest.approx(np.pi * 0.1) == scene.scene.track_length
    assert corrections.track.length == 0.4 == scene.scene.motion.disk_track_length
    assert corrections.motion == scene.scene.motion


@pytest.mark.parametrize(
    ("lengths", "texts"),
    [
        ({"pin_track_length": 0.3, "disk_track_length": 0.4}, ("the pin and the disk",)),
        (
            {"pin_track_length": 0.3},
            ("the pin (", "the disk (unknown; set motion.disk_track_length)"),
        ),
        (
            {},
            (
                "the pin (unknown; set motion.pin_track_length)",
                "the disk (unknown; set motion.disk_track_length)",
            ),
        ),
    ],
)
def test_an_answer_says_of_which_body_the_heat_of_earlier_revolutions_is_unknown(lengths, texts):
    motion = tribo.Motion(slide_roll_ratio=0.5, **lengths)
    text = pipeline.boundary(synthetic.sweep(motion=motion, tests=())).attrs["not_included"]
    for words in texts:
        assert f"heat from earlier revolutions of {words}" in text
    assert text.count("unknown; set") == 2 - len(lengths)


def test_no_answer_mentions_heat_that_the_measured_bulk_temperature_includes():
    motion = tribo.Motion(slide_roll_ratio=0.5, pin_track_length=0.3)
    for includes, count in ((False, 2), (True, 0)):
        ds = synthetic.sweep(motion=motion, tests=(), includes_earlier_revolutions=includes)
        assert pipeline.boundary(ds).attrs["not_included"].count("revolutions") == count


# Heat stored in the bodies depends on the whole loading history, whichever steps are stored.

TRACK = tribo.Track.from_pin(PIN, STEEL, 0.3)
STAYS = tribo.Corrections(track=TRACK)
ROLLING = tribo.Motion(slide_roll_ratio=0.5, pin_track_length=0.3)
TIMES = np.array([0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 20.0, 21.0])
LOADS = np.array([0.0, 500.0, 500.0, 100.0, 100.0, 0.0, 400.0, 750.0])
RECORD = tribo.MeasuredLoad(TIMES, LOADS)
LOADINGS = {
    "ramp": tribo.Ramp(150.0, 750.0),
    "hold": tribo.Ramp(150.0, 750.0, hold=20.0),
    "record": RECORD,
}
LOAD, VELOCITY = 600.0, 1.0


def sweep_under(loading, motion=None, **changes):
    parts = replace(STAYS, motion=motion, pin_track=TRACK if motion else None)
    conditions = replace(CONDITIONS, corrections=parts)
    axes = {"loads": (250.0, LOAD), "velocities": (VELOCITY,)}
    little = tribo.Wear(1e-19)  # the contact hardly widens, so that the end is the hottest time
    return tiny.sweep(
        conditions=conditions, loading=loading, motion=motion, wear=little, **axes, **changes
    )


@pytest.mark.parametrize(
    ("loading", "steps", "motion"),
    [
        ("ramp", "course", ROLLING), ("hold", "end", None), ("hold", "course", ROLLING),
        ("record", "end", None), ("record", "course", ROLLING),
    ],
)  # fmt: skip
def test_a_store_gives_the_temperature_of_the_point_itself(tmp_path, loading, steps, motion):
    sweep = sweep_under(LOADINGS[loading], motion, steps=steps)
    commit_all(tmp_path / "a.zarr", sweep)
    margin = asked(tmp_path / "a.zarr", LOAD, VELOCITY)
    point = run_point(sweep_under(LOADINGS[loading], motion), LOAD, VELOCITY)
    verdict = point.verdict(sweep.conditions)
    assert margin.governing_temperature == pytest.approx(verdict.governing_temperature, rel=1e-9)


# A scene without a critical temperature

UNKNOWN = replace(tiny.sweep().conditions, critical_temperature=None)


def test_without_a_critical_temperature_temperatures_are_known_and_no_boundary(tiny_store):
    ds = with_fields(pipeline.open_sweep(tiny_store), conditions=UNKNOWN)
    temperatures = pipeline.temperatures(ds)
    assert np.isfinite(temperatures["max_temperature"].values).any()
    assert "failed_area_fraction" not in temperatures
    for judge in (pipeline.boundary, lambda ds: pipeline.plot(ds, "diagram", "figure.png")):
        with pytest.raises(InputError, match=r"temperature is needed.*--critical-temperature"):
            judge(ds)
    crossings = pipeline.boundary(ds, critical_temperature=330.0)
    assert crossings["critical_velocity"].notnull().any()


def test_a_scene_file_may_leave_it_out(tmp_path, irg):
    (tmp_path / "known.toml").write_text(SCENE)
    scene = tmp_path / "scene.toml"
    scene.write_text('extends = "known.toml"\nwithout = ["temperature.critical"]\n')
    assert pipeline.load_scene(scene).conditions == UNKNOWN
    point = ["--load", "200 N", "--velocity", "1 m/s"]
    (row,) = irg("point", scene, *point, "--json")
    assert "verdict" not in row
    assert row["highest temperature [°C]"] > 25
    assert "without temperature.critical there is no verdict" in irg("point", scene, *point)
    out = str(tmp_path / "out.zarr")
    assert "a critical temperature is needed" in irg(
        "run", scene, "--accuracy", "2%", "-o", out, "--workers", "1", code=2
    )

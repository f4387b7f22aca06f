"""Notes on what a scene leaves out: earlier turns, and sharp ends of the pin."""

from dataclasses import replace

import pytest

import pipeline
import tribo
from pipeline.scene.doubts import note_on_ends, note_on_turns
from tests.helpers import synthetic
from tests.helpers.scenes import SCENE, STEEL

ROLLING = {"motion": {"slide_roll_ratio": 0.5, "track_length": "314 mm"}}
BALL = {"without": ["pin.length"], "pin.shape": "ball"}
CROWNED = {"without": ["pin.length"], "pin.shape": "crowned", "pin.crown_radius": "50 mm"}


@pytest.fixture
def scene(tmp_path):
    """Function that loads a scene with other values of entries, by path."""
    (tmp_path / "plain.toml").write_text(SCENE)
    return lambda entries=None: pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)


def test_earlier_turns_that_are_not_counted_are_said(scene):
    said = note_on_turns(scene(ROLLING))
    assert said.startswith("earlier turns of the pin and the disk are not counted")
    assert said.endswith("; give pin.diameter and disk.diameter and width, or track_length")
    alone = note_on_turns(scene(ROLLING | {"disk.track_length": "314 mm"}))
    assert "turns of the pin are not" in alone
    assert "give pin.diameter and width" in alone
    for entries in ({}, {"motion": {"slide_roll_ratio": 2}}, {"motion": {"slide_roll_ratio": -2}}):
        assert note_on_turns(scene(entries)) is None
    assert note_on_turns(scene(ROLLING | {"sweep.velocities": ["0 m/s"]})) is None
    counted = {"pin.track_length": "314 mm", "disk.track_length": "314 mm"}
    assert note_on_turns(scene(ROLLING | counted)) is None


@pytest.mark.parametrize(
    ("entries", "is_said"), [({}, True), (BALL, False), (ROLLING, False), (CROWNED, False)]
)
def test_sharp_ends_are_said_of_a_cylinder_at_rest(scene, entries, is_said):
    note = note_on_ends(scene(entries))
    assert (note is not None) == is_said
    assert note is None or note.startswith("sharp pin ends, not computed: severe")


def test_a_boundary_says_where_wear_turns_severe_on_tracks_that_earlier_turns_warm(tmp_path, irg):
    motion = tribo.Motion(slide_roll_ratio=0.5, track_length=0.314)
    cold = synthetic.sweep(motion=motion, measured=())
    cold.drop_vars("message").to_netcdf(tmp_path / "cold.nc")
    track = tribo.Track.under(synthetic.scene().scene.pin, STEEL, 0.314)
    warm = tribo.Corrections(motion=motion, track=track, pin_track=track)
    conditions = replace(pipeline.results(cold).conditions, corrections=warm)
    found = pipeline.boundary(synthetic.sweep(motion=motion, measured=(), conditions=conditions))
    place = "--load=400 N", "--velocity=1.4 m/s"
    first, last = found["critical_velocity"].values[[0, -1]]
    severe = f"with them wear is severe from {first:.3g} m/s at 200 N, from {last:.3g} m/s at 750 N"
    for command, *options in (("boundary",), ("margin", *place)):
        assert severe in " ".join(irg(command, tmp_path / "cold.nc", *options).split())
        (*_, record) = irg(command, tmp_path / "cold.nc", *options, "--json")
        assert f"earlier turns are left out: {severe}" in record["notes"].split(" | ")
    cold.sel(velocity=cold["velocity"] > last).drop_vars("message").to_netcdf(tmp_path / "cut.nc")
    said = " ".join(irg("boundary", tmp_path / "cut.nc").split())
    assert ", at every velocity computed at 750 N" in said
    judged = ["rise_quantile", "rise_sampling", "mean_rise", "mean_rise_sampling"]
    few = cold[["status", "normal_load", *judged, "warning_flags", "time", "message"]]
    for ds, friction in ((few, 0.1), (cold, 0.15)):  # for which that velocity is unknown
        rows = {"load": [400.0], "velocity": [1.4], "friction": [friction]}
        (notes,) = pipeline.margin(ds, rows)["notes"]
        assert "earlier turns are left out: with them wear turns severe at lower" in notes

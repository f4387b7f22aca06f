"""Notes on what a scene leaves out: earlier turns, and sharp ends of the pin."""

import pytest

import pipeline
from pipeline.answers.scene_notes import warning_text
from tests.helpers.scenes import SCENE

ROLLING = {"motion": {"slide_roll_ratio": 0.5, "track_length": "314 mm"}}
BALL = {"without": ["pin.length"], "pin.shape": "ball"}
CROWNED = {"without": ["pin.length"], "pin.shape": "crowned", "pin.crown_radius": "50 mm"}


@pytest.fixture
def scene(tmp_path):
    """Function that loads a scene with other values of entries, by path."""
    (tmp_path / "plain.toml").write_text(SCENE)
    return lambda entries=None: pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)


def said_of(sweep, code):
    """The warning of a code on a scene as text; None without it."""
    found = [warning_text(one) for one in sweep.all_warnings if one.code == code]
    return found[0] if found else None


def test_earlier_turns_that_are_not_counted_are_said(scene):
    said = said_of(scene(ROLLING), "cold_tracks")
    assert said.startswith("heat from earlier revolutions of the pin and the disk is not included")
    assert ": set pin.diameter and disk.diameter and width, or track_length, or enter" in said
    alone = said_of(scene(ROLLING | {"disk.track_length": "314 mm"}), "cold_tracks")
    assert "revolutions of the pin is not" in alone
    assert "set pin.diameter and width" in alone
    for entries in ({}, {"motion": {"slide_roll_ratio": 2}}, {"motion": {"slide_roll_ratio": -2}}):
        assert said_of(scene(entries), "cold_tracks") is None
    assert said_of(scene(ROLLING | {"sweep.velocities": ["0 m/s"]}), "cold_tracks") is None
    counted = {"pin.track_length": "314 mm", "disk.track_length": "314 mm"}
    assert said_of(scene(ROLLING | counted), "cold_tracks") is None


@pytest.mark.parametrize(
    ("entries", "is_said"), [({}, True), (BALL, False), (ROLLING, False), (CROWNED, False)]
)
def test_sharp_ends_are_said_of_a_cylinder_at_rest(scene, entries, is_said):
    note = said_of(scene(entries), "sharp_ends")
    assert (note is not None) == is_said
    assert note is None or note.startswith(
        "pin.length: the pin's sharp ends are not modelled; severe"
    )

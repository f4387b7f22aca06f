"""Notes on what a scene leaves out: earlier turns, and sharp ends of the pin."""

import math

import pytest

import pipeline
from pipeline.sweep.physics import columns_in_closed_form, note_on_ends, note_on_turns
from tests.helpers.scenes import SCENE

ROLLING = {"motion": {"slide_roll_ratio": 0.5, "track_length": "314 mm"}}
BALL = {"without": ["pin.length"], "pin.shape": "ball"}
CROWNED = {"without": ["pin.length"], "pin.shape": "crowned", "pin.crown_radius": "50 mm"}


@pytest.fixture
def scene(tmp_path):
    """A scene with other values of some entries, by their paths."""
    (tmp_path / "plain.toml").write_text(SCENE)
    return lambda entries=None: pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)


def test_columns_in_closed_form_are_those_of_a_smooth_line_contact(scene):
    """Hertz: p₀ = √(E* F / (π R L)), 2 a = 4 F / (π p₀ L); alike bodies share by √ of speeds."""
    sweep = scene({"motion": {"slide_roll_ratio": 0.5}})
    columns = columns_in_closed_form(sweep, 400.0, 2.0, 1000.0)
    per_length, modulus = 400.0 / 3.4e-3, 210e9 / (1 - 0.3**2) / 2
    peak = math.sqrt(modulus * per_length / (math.pi * 2e-3))
    # Slip is half of the mean speed: 4 m/s, so that the bodies run at 5 and 3 m/s or 3 and 5.
    speeds = sweep.scene.velocities_at(2.0)
    assert sorted(map(abs, speeds)) == [3.0, 5.0]
    share = math.sqrt(abs(speeds.pin)) / (math.sqrt(3) + math.sqrt(5))
    assert columns["mean_pressure"] == pytest.approx(peak)
    assert columns["contact_width"] == pytest.approx(4 * per_length / (math.pi * peak))
    assert columns["pin_heat_share"] == pytest.approx(share)
    assert columns["time"][-1] == pytest.approx(400 / 150)
    assert columns["sliding_distance"][-1] == pytest.approx(2.0 * 400 / 150)
    assert columns["normal_load"][-1] == 400.0
    *before, end = columns["mean_rise"].tolist()
    assert end == 1000.0
    assert all(math.isnan(rise) for rise in before)
    assert {len(values) for values in columns.values()} == {len(columns["time"])}
    at_rest = columns_in_closed_form(scene(), 400.0, 2.0, 1000.0)
    assert at_rest["pin_heat_share"].tolist() == [0.0] * len(at_rest["time"])


def test_earlier_turns_that_are_not_counted_are_said_with_what_they_would_warm(scene):
    said = note_on_turns(scene(ROLLING))
    assert said.startswith(
        "earlier turns of the pin and the disk are not counted, as if each met a cold track: on "
        "tracks of 314 mm they would warm the contact by about "
    )
    assert said.endswith(
        " K more at 400 N and 2 m/s; give pin.diameter and disk.diameter and width, or track_length"
    )
    # All heat of the earlier turns is on the track at the next; half of it as the pin's is half.
    warming = [
        float(note.partition("about ")[2].split()[0])
        for note in (
            said,
            note_on_turns(scene(ROLLING | {"friction.coefficient": 0.2})),
            note_on_turns(scene(ROLLING | {"disk.track_length": "314 mm"})),
            note_on_turns(scene(ROLLING), 800.0, 2.0),
        )
    ]
    assert warming[1] == pytest.approx(2 * warming[0], rel=0.1)
    assert 0 < warming[2] < warming[0] < warming[3]
    at_load = note_on_turns(scene(ROLLING), 800.0, 3.0)
    assert "K more at 800 N and 3 m/s" in at_load
    alone = note_on_turns(scene(ROLLING | {"disk.track_length": "314 mm"}))
    assert "turns of the pin are not" in alone
    assert "give pin.diameter and width" in alone
    for entries in ({}, {"motion": {"slide_roll_ratio": 2}}, {"motion": {"slide_roll_ratio": -2}}):
        assert note_on_turns(scene(entries)) is None
    assert note_on_turns(scene(ROLLING), velocity=0.0) is None
    counted = {"pin.track_length": "314 mm", "disk.track_length": "314 mm"}
    assert note_on_turns(scene(ROLLING | counted)) is None


@pytest.mark.parametrize(
    ("entries", "is_said"), [({}, True), (BALL, False), (ROLLING, False), (CROWNED, False)]
)
def test_sharp_ends_are_said_of_a_cylinder_at_rest(scene, entries, is_said):
    note = note_on_ends(scene(entries))
    assert (note is not None) == is_said
    assert note is None or note.startswith("only the pin's middle is computed: at sharp ends")

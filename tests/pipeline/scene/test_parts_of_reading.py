"""Details of reading a scene: rotations, seeds, pairs of values, and doubts about grooves."""

import math

import pytest

import pipeline
import tribo
from pipeline import to_si
from tests.helpers.entries import changed
from tests.pipeline.scene.test_contact_estimate import SMOOTH
from tests.pipeline.scene.test_scene_warnings import said_of, surface

# Rotations


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("600 rpm at radius 30 mm", 2 * math.pi * 10 * 0.03),
        ("600 1/min at diameter 60 mm", 2 * math.pi * 10 * 0.03),
        ("-60 U/min at radius 1 m", -2 * math.pi),
    ],
)
def test_a_rotation_is_the_velocity_of_its_track(text, value):
    assert to_si(text, like="1 m/s") == pytest.approx(value, rel=1e-14)


# Seeds


def seeds(wanted, **entries):
    scene = pipeline.load_scene("first_try", overrides={"sweep.realizations": wanted} | entries)
    names = [dict(name)["realization"] for name in scene.case_table.names]
    return names, scene.scene.roughness.seed


def test_realizations_begin_at_the_seed_of_the_scene_or_are_those_given():
    assert seeds(3, **{"disk.roughness.seed": 5}) == ([5, 6, 7], 5)
    assert seeds(2, without=["disk.roughness.seed"]) == ([0, 1], 0)
    assert seeds([9, 4], **{"disk.roughness.seed": 5}) == ([4, 9], 4)
    with pytest.raises(pipeline.SceneFileError, match=r"2 needs a rough disk, .disk.roughness."):
        seeds(2, without=["disk.roughness"])


# Doubts


@pytest.mark.parametrize(
    ("lay", "measured", "pattern", "said"),
    [
        (30.0, True, "swept", True),
        (30.1, True, "swept", False),
        (0.0, True, "local", False),
        (0.0, False, "swept", True),
        (0.0, False, None, False),
        (None, True, "swept", False),
    ],
)
def test_grooves_along_sliding_are_doubted(lay, measured, pattern, said):
    scene = changed(SMOOTH, wear=tribo.Wear(1.2e-15, pattern) if pattern else None)
    found = said_of(scene, surface=surface(lay=lay, measured=measured))
    assert any("the grooves run along the sliding direction" in one for one in found) is said

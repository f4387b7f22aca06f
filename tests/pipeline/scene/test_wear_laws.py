"""Wear laws that ship have names in a scene, as pins and criteria do."""

import pytest

import pipeline
import tribo
from pipeline.scene.stored_text import parse_sweep, sweep_text
from pipeline.sweep.laws import given_laws

RUNNING_IN = {
    "law": "running-in",
    "initial_rate": "6e-6 mm^3/(N m)",
    "final_rate": "1e-6 mm^3/(N m)",
    "distance": "2 m",
}
WITHOUT = ["wear.specific_wear_rate", "wear.pattern"]


def named(**changes):
    return pipeline.load_scene(
        "first_try", overrides={"without": WITHOUT, "wear": RUNNING_IN | changes}
    )


def test_a_law_that_ships_is_named_and_no_code_of_the_user_s():
    sweep = named(pattern="local")
    assert sweep.scene.wear == tribo.RunningIn(6e-15, 1e-15, 2.0, "local")
    assert given_laws(sweep.scene) == []
    assert parse_sweep(sweep_text(sweep), {}) == sweep


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"distance": None}, "wear.distance"),
        ({"initial_rate": "2 m"}, "wear.initial_rate"),
        ({"specific_wear_rate": "1e-6 mm^3/(N m)"}, "wear.specific_wear_rate: unknown key"),
        ({"law": "walking-in"}, 'wear.law: "walking-in" is unknown; give "running-in"'),
    ],
)
def test_a_law_is_told_what_it_needs(changes, said):
    entries = {k: v for k, v in (RUNNING_IN | changes).items() if v is not None}
    with pytest.raises(pipeline.SceneFileError) as error:
        pipeline.load_scene("first_try", overrides={"without": WITHOUT, "wear": entries})
    assert said in str(error.value)

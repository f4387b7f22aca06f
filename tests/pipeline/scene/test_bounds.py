"""Numbers that no machine has are faults of the scene, by the paths of their entries."""

import pytest

import pipeline

MANY_STEPS = {
    "loading.hold": "1e9 s",
    "loading.reference_load": "1e-6 N",
    "loading.hold_steps": 10**9,
    "fidelity.increments": 10**9,
}


@pytest.mark.parametrize(("path", "value"), MANY_STEPS.items(), ids=MANY_STEPS)
def test_an_entry_that_asks_for_a_billion_steps_is_named(path, value):
    with pytest.raises(pipeline.SceneFileError, match=rf": {path}[: ].*1000000|1e\+06"):
        pipeline.load_scene("first_try", overrides={path: value})


def test_the_hold_of_a_test_that_asks_for_a_billion_steps_is_named():
    tested = [{"load": "200 N", "velocity": "1 m/s", "outcome": "mild", "hold": "1e9 s"}]
    with pytest.raises(pipeline.SceneFileError, match=r"tested\[0\].hold: 1e\+09 s takes 1e\+09"):
        pipeline.load_scene("first_try", overrides={"tested": tested})

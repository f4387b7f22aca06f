"""Runs of a scene by their stages, and what no specimen does."""

import pytest

import pipeline


@pytest.fixture
def tested(tmp_path):
    def load(*entries):
        text = "".join(f"\n[[tests]]\n{entry}\n" for entry in entries)
        head = 'extends = "first_try"\nwithout = ["tests"]\n'
        (tmp_path / "lab.toml").write_text(head + text, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml").tests

    return load


def places(tests):
    return [(test.normal_load, test.velocity, test.outcome, test.number) for test in tests]


def test_stages_of_load_or_velocity_are_the_last_mild_test_and_the_severe_one(tested):
    by_load = 'velocity = "2 m/s"\nmild_up_to = "400 N"\nsevere_at = "450 N"\nnumber = 7'
    by_velocity = 'load = "300 N"\nmild_up_to = "2 m/s"\nsevere_at = "150 m/min"\nnumber = "b"'
    assert places(tested(by_load, by_velocity)) == [
        (400.0, 2.0, "mild", "7"),
        (450.0, 2.0, "severe", "7"),
        (300.0, 2.0, "mild", "b"),
        (300.0, 2.5, "severe", "b"),
    ]


def test_a_run_may_end_beyond_its_last_stage_or_at_its_first(tested):
    beyond = 'velocity = "2 m/s"\nmild_up_to = "700 N"\nfriction = 0.1'
    mild, severe = tested(beyond, 'velocity = "2 m/s"\nsevere_at = "100 N"\nnumber = "A7"')
    assert (mild.outcome, mild.normal_load, mild.friction) == ("mild", 700.0, 0.1)
    assert (severe.outcome, severe.normal_load, severe.number) == ("severe", 100.0, "A7")
    assert mild.number != severe.number

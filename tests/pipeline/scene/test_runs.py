"""Runs of a scene by their stages, and what no specimen does."""

import pytest

import pipeline


@pytest.fixture
def tested(tmp_path):
    def load(*entries):
        text = "".join(f"\n[[tested]]\n{entry}\n" for entry in entries)
        (tmp_path / "lab.toml").write_text(f'extends = "first_try"\n{text}', encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml").about.tested

    return load


def places(tests):
    return [(test.normal_load, test.velocity, test.outcome, test.run) for test in tests]


def test_stages_of_load_or_velocity_are_the_last_mild_test_and_the_severe_one(tested):
    by_load = 'velocity = "2 m/s"\nmild_up_to = "400 N"\nsevere_at = "450 N"\nrun = 7'
    by_velocity = 'load = "300 N"\nmild_up_to = "2 m/s"\nsevere_at = "150 m/min"\nrun = "b"'
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
    assert mild.run != severe.run


STAGE = 'velocity = "2 m/s"\nmild_up_to = "400 N"\nrun = 1'


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        (['load = "3 N"\nvelocity = "2 m/s"\nmild_up_to = "4 N"'], "both load and velocity are"),
        (['mild_up_to = "400 N"'], "neither load nor velocity is given beside stages"),
        (['velocity = "2 m/s"\nmild_up_to = "4 m/s"'], "mild_up_to: .*cannot be converted to N"),
        (
            ['velocity = "2 m/s"\nmild_up_to = "4 N"\nsevere_at = "3 N"'],
            "severe_at: 3 N is not above mild_up_to, 4 N",
        ),
        (
            [STAGE, 'velocity = "2 m/s"\nload = "300 N"\noutcome = "severe"\nrun = 1'],
            "1 is severe at 300 N and 2 m/s, and mild at 400 N and 2 m/s, which no specimen is",
        ),
        (
            [STAGE, 'velocity = "2 m/s"\nsevere_at = "500 N"\nrun = 1\noil = "B"'],
            "1 has two oils",
        ),
    ],
)
def test_a_run_that_cannot_be_is_named_by_its_entry(tested, entries, words):
    with pytest.raises(pipeline.SceneFileError, match=words):
        tested(*entries)

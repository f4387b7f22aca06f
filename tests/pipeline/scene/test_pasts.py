"""What is told of tests whose specimen has another past than the plane's: kind, and direction."""

import pytest

PLACE = 'load = "400 N"\nvelocity = "2 m/s"\noutcome = "severe"\n'
STAGES = 'stages = { first = "100 N", step = "100 N", hold = "60 s" }\n'
FRESH = "one specimen at several points, but each is simulated as a fresh specimen and thus too hot"


@pytest.fixture
def told(tmp_path, irg):
    """Meanings in the table of `irg check`, for a scene with tests written so."""

    def ask(*tests):
        scene = tmp_path / "scene.toml"
        begin = 'extends = "first_try"\nwithout = ["tests"]\n'
        scene.write_text(begin + "".join(f"[[tests]]\n{one}" for one in tests))
        return [row["meaning"] for row in irg("check", scene, "--json")["statements"]]

    return ask


@pytest.mark.parametrize(
    ("own", "words"),
    [
        (
            STAGES,
            "loaded in stages, while the sweep uses a ramp: worn earlier, it is cooler",
        ),
        (
            'with = { "loading.rate" = "15 N/s" }\n',
            "the load grows more slowly (more wear, lower temperature)",
        ),
        (
            'with = { "loading.rate" = "1500 N/s" }\n',
            "the load grows faster (higher temperature) than",
        ),
        (
            'with = { "loading.hold" = "30 s" }\n',
            "held longer than in the sweep, which matters",
        ),
    ],
)
def test_another_past_is_told_with_its_effect(told, own, words):
    (line,) = [one for one in told(PLACE, PLACE + own) if one.startswith("test ")]
    assert line.startswith(f"test 2: {words}")


def test_a_specimen_of_several_places_without_stages_is_doubted(told):
    run = 'velocity = "2 m/s"\nmild_up_to = "300 N"\nsevere_at = "400 N"\n'
    assert [line for line in told(run) if line.startswith(f"test 1: {FRESH}")]
    assert not [line for line in told(run + STAGES) if "simulated as a fresh" in line]


def test_more_stages_of_the_same_kind_are_no_other_past(tmp_path, irg):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'extends = "srv"\n[sweep]\nloads = ["200 N"]\n[[tests]]\nvelocity = "0.1 m/s"\n'
        'mild_up_to = "300 N"\n[[tests]]\nvelocity = "0.1 m/s"\nmild_up_to = "200 N"\n'
        'stages = { first = "100 N", step = "100 N", hold = "30 s" }\n'
    )
    said = [row["meaning"] for row in irg("check", scene, "--json")["statements"]]
    told = "test 2: the load stages differ from the sweep's; longer stages wear the contact more"
    (line,) = (line for line in said if line.startswith("test ") and "load stages" in line)
    assert line.startswith(told)

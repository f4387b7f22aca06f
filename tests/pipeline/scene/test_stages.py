"""Stages of one specimen in a scene: how they are written, read, stored and refused."""

import pytest

import pipeline
from pipeline.store.resume import mismatches
from tests.helpers.scenes import SCENE
from tests.helpers.stored import parse_sweep, sweep_text
from tribo import Stages

RAMP = '[loading]\nrate = "150 N/s"\nreference_load = "750 N"'
EVEN = '[loading]\nrate = "150 N/s"\nstages = { first = "200 N", step = "200 N", hold = "5 s" }'
LISTED = (
    '[loading]\nrate = "150 N/s"\nstages = [["200 N", "5 s"], ["400 N", "5 s"], ["600 N", "1 min"]]'
)
WINDOW = "pixels = [48, 16]"


@pytest.fixture
def load(tmp_path):
    def read(loading=EVEN, *tests, change=("", "")):
        text = SCENE.replace(RAMP, loading).replace(*change)
        text += "".join(f"\n[[tests]]\n{test}\n" for test in tests)
        (tmp_path / "lab.toml").write_text(text, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return read


def test_stages_are_read_in_both_forms(load):
    even, listed = load(), load(LISTED)
    loads = 200.0, 400.0, 600.0
    assert even.scene.loading == Stages(loads, (5.0,) * 3, 150.0)
    assert listed.scene.loading == Stages(loads, (5.0, 5.0, 60.0), 150.0)
    # The reference load of a scene that this one extends is not used.
    assert load(f'{EVEN}\nreference_load = "750 N"') == even


@pytest.mark.parametrize("loading", [EVEN, LISTED])
def test_stages_are_read_again_from_a_store(load, loading):
    tests = 'stages = { first = "1 m/s", step = "1 m/s", hold = "5 s" }\nload = "400 N"\n'
    sweep = load(loading, f'{tests}mild_up_to = "2 m/s"\nsevere_at = "3 m/s"')
    again = parse_sweep(sweep_text(sweep), {})
    assert again.scene == sweep.scene
    assert [test.case.scene for test in again.tests] == [test.case.scene for test in sweep.tests]


def test_the_window_is_as_wide_as_the_stages_wear_the_pin(load):
    sweep = load()  # up to 600 N and 4 m/s
    volume = 1.2e-15 * sweep.scene.loading.worn_impulse(4.0) / 3.4e-3
    chord = (12 * 2e-3 * volume) ** (1 / 3)
    side = sweep.scene.pixels.size[0]
    assert 384e-6 < 1.25 * chord <= side < 1.4 * chord
    wider = load(change=(WINDOW, "pixels = [300, 16]"))
    assert wider.scene.pixels.shape == (300, 16)


def test_a_run_by_stages_is_one_specimen_up_to_its_last_stage(load):
    stages = 'stages = { first = "100 N", step = "100 N", hold = "60 s" }\nvelocity = "2 m/s"\n'
    mild, severe = load(RAMP, f'{stages}mild_up_to = "200 N"\nsevere_at = "300 N"').tests
    assert mild.case.scene == severe.case.scene
    assert mild.case.scene.loading == Stages((100.0, 200.0, 300.0), (60.0,) * 3, 150.0)
    assert (mild.normal_load, mild.outcome) == (200.0, "mild")
    assert (severe.normal_load, severe.outcome) == (300.0, "severe")
    assert mild.number == severe.number


def test_the_stages_of_a_test_may_be_of_velocity(load):
    stages = 'stages = [["1 m/s", "60 s"], ["1.5 m/s", "90 s"], ["2 m/s", "60 s"]]\n'
    (test,) = load(RAMP, f'{stages}load = "400 N"\nmild_up_to = "1.5 m/s"').tests
    loading = test.case.scene.loading
    assert loading == Stages((400.0,), (60.0, 90.0), 150.0, velocities=(1.0, 1.5))


def test_a_test_without_stages_of_its_own_has_those_of_the_scene(load):
    single = 'load = "{} N"\nvelocity = "2 m/s"\noutcome = "mild"'
    inside, above = load(EVEN, single.format(400), single.format(1000)).tests
    assert inside.case.scene.loading.loads == (200.0, 400.0, 600.0)
    assert above.case.scene.loading.loads == (200.0, 400.0, 600.0, 800.0, 1000.0)


def test_stages_of_velocity_are_refused_beside_the_whole_history(load):
    test = 'stages = [["1 m/s", "5 s"], ["2 m/s", "5 s"]]\nload = "400 N"\nsevere_at = "2 m/s"'
    with pytest.raises(pipeline.SceneFileError, match="heat_model is 'history'"):
        load(RAMP, test, change=("increments = 10", 'increments = 10\nheat_model = "history"'))


def test_a_store_of_a_ramp_does_not_take_stages(load):
    stored = parse_sweep(sweep_text(load(RAMP)), {})
    words = "; ".join(mismatches(stored, load(EVEN)))
    assert "loading: Ramp in the store, Stages in the scene" in words
    assert "loading.hold" not in words
    assert list(mismatches(parse_sweep(sweep_text(load(EVEN)), {}), load(EVEN))) == []

"""Tests that change entries of the scene, and steps of transitions."""

from dataclasses import replace

import pytest

import pipeline
import tribo
from tests.helpers.stored import parse_sweep, sweep_text

WEAR = 'with = { "wear.specific_wear_rate" = "3.7e-7 mm^3/(N m)" }'


@pytest.fixture
def load(tmp_path):
    def load_tests(*tests, top=""):
        listed = "".join(f"\n[[tests]]\n{entries}\n" for entries in tests)
        scene = f'extends = "first_try"\nwithout = ["tests"]\n{top}{listed}'
        (tmp_path / "lab.toml").write_text(scene, encoding="utf-8")
        return pipeline.load_scene(tmp_path / "lab.toml")

    return load_tests


def transition(*entries, outcome="transition"):
    return "\n".join(['load = "400 N"', 'velocity = "2 m/s"', f'outcome = "{outcome}"', *entries])


def test_a_test_has_the_scene_with_its_own_entries(load):
    own = transition(WEAR, "friction = 0.12", 'bulk_temperature = "60 degC"')
    changed, plain = load(own, transition()).tests
    scene = pipeline.load_scene("first_try")
    with_wear = scene.changed("wear.specific_wear_rate", "3.7e-7 mm^3/(N m)")
    assert changed.case.scene == with_wear.scene
    conditions = changed.case.conditions
    assert (conditions.friction, conditions.bulk_temperature) == (0.12, 333.15)
    assert plain.case.scene == scene.scene
    assert plain.case.conditions == replace(scene.conditions, critical_temperature=None)


def test_tests_without_own_entries_share_the_scene_of_the_sweep(load):
    sweep = load(transition("friction = 0.12"), transition('bulk_temperature = "50 degC"'))
    assert all(test.case.scene is sweep.scene for test in sweep.tests)


def test_a_test_is_of_the_scene_without_its_rows_and_surfaces(load):
    rows = '[sweep]\nover = { "pin.radius" = ["3 mm", "1 mm"] }\nrealizations = [7, 5]\n'
    (test,) = load(transition(), top=rows).tests
    assert (test.case.scene.pin.radius, test.case.scene.roughness.seed) == (0.002, 5)


@pytest.mark.parametrize(
    ("step", "before"), [("0.25 m/s", (400.0, 1.75)), ("50 N", (350.0, 2.0)), (None, None)]
)
def test_a_step_leads_from_the_last_mild_place_to_the_transition(load, step, before):
    (test,) = load(transition(*([f'step = "{step}"'] if step else []))).tests
    assert test.places == ((before,) if before else ()) + ((400.0, 2.0),)


def test_a_measured_friction_replaces_the_curve_of_the_scene(load):
    curve = (
        '[friction]\ncoefficient = 0.1\nby_velocity = [{ velocity = "1 m/s", coefficient = 0.2 }]\n'
    )
    own, others = load(transition("friction = 0.12"), transition(), top=curve).tests
    assert own.case.conditions.friction_at(1.0) == pytest.approx(0.12)
    assert others.case.conditions.friction_at(1.0) == pytest.approx(0.2)


def test_a_store_keeps_what_a_test_changes_whatever_the_library_has_later(load):
    own = 'with = { "pin.material" = "100Cr6", "fidelity.preset" = "fine" }'
    sweep = load(
        transition(own, 'step = "0.5 m/s"'),
        f'load = "300 N"\nvelocity = "1 m/s"\noutcome = "mild"\n{WEAR}',
    )
    stored = parse_sweep(sweep_text(sweep), {})
    assert stored == sweep
    assert [test.case for test in stored.tests] == [test.case for test in sweep.tests]
    assert stored.tests[0].case.scene.fidelity == tribo.PRESETS["fine"]
    assert sweep_text(stored) == sweep_text(sweep)


FAULTS = {
    'with = { "wear.specific_wear_rat" = "1e-7 mm^3/(N m)" }':
        r'tests\[0\].with: wear.specific_wear_rat: unknown key \(did you mean "specific_wear',
    'with = { "pin.radius" = "3 N" }': r"tests\[0\].with: pin.radius: .*give a length",
    'with = { "sweep.loads" = ["3 N"] }': r'"sweep.loads" is the same in all tests of a scene',
    'with = { "temperature.critical" = "200 degC" }': r"is the same in all tests of a scene",
    'friction = 0.1\nwith = { "friction.coefficient" = 0.2 }': "set by the friction of this test",
    "with = 3": r"tests\[0\].with: 3 is not a table; give a table of entries by their paths",
    'step = "3 m/s"': r'tests\[0\].step: "3 m/s" is not below the velocity, 2 m/s; give less',
    'step = "400 N"': r'"400 N" is not below the load, 400 N',
    'step = "3 mm"': r'"3 mm" is another quantity; give a velocity above 0, such as',
}  # fmt: skip


@pytest.mark.parametrize("entry", FAULTS)
def test_a_fault_of_a_test_is_named_at_its_place(load, entry):
    with pytest.raises(pipeline.SceneFileError, match=FAULTS[entry]):
        load(transition(entry))


def test_all_faults_of_all_tests_are_named_at_once(load):
    bad = 'with = { "pin.radius" = "3 N", "wear.patern" = "local" }'
    with pytest.raises(pipeline.SceneFileError) as caught:
        load(transition(bad), transition(), transition('with = { "a.b" = 1 }'))
    places = [fault.partition(":")[0] for fault in caught.value.faults]
    assert places == ["tests[0].with", "tests[0].with", "tests[2].with"]

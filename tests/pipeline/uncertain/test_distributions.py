"""The table [unknown] of a scene file: what it means, and every way to get it wrong."""

import numpy as np
import pytest

import pipeline
from pipeline.scene.faults import SceneFileError
from pipeline.scene.resume import join, misfits
from pipeline.sweep.variants import Variants
from pipeline.uncertain.samples import Draw
from tests.helpers.entries import changed
from tests.helpers.scenes import SCENE
from tests.helpers.sweeps import inputs_of

UNKNOWN = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }
"disk.roughness.correlation_length" = { from = "12 um", to = "24 um" }
"friction.coefficient" = { mean = 0.1, sd = 0.005 }
"temperature.critical" = { mean = "145 degC", sd = "8 K" }
"disk.roughness.seed" = [0, 1, 2, 3]
"""


def scene(tmp_path, unknown=UNKNOWN, samples=8, text=SCENE):
    sampled = "[sweep]" if samples is None else f"[sweep]\nsamples = {samples}"
    (tmp_path / "scene.toml").write_text(text.replace("[sweep]", sampled) + unknown)
    return tmp_path / "scene.toml"


def faults(path, overrides=None):
    with pytest.raises(SceneFileError) as caught:
        pipeline.load_scene(path, overrides=overrides)
    return caught.value.faults


def test_quantities_are_read_in_si(tmp_path):
    sweep = pipeline.load_scene(scene(tmp_path))
    rate, length, friction, critical, seed = Draw.of(sweep.variants.draw).unknown
    assert (rate.kind, rate.parameters) == ("log-normal", (1.2e-15, 1.5))
    assert (length.kind, length.parameters, length.unit) == ("uniform", (12e-6, 24e-6), "m")
    assert (friction.kind, friction.parameters) == ("normal", (0.1, 0.005))
    assert (critical.parameters, critical.unit) == (pytest.approx((418.15, 8.0)), "K")
    assert (seed.kind, seed.parameters) == ("list", (0.0, 1.0, 2.0, 3.0))
    assert len(sweep.variants) == 8


def test_friction_and_temperatures_are_not_simulated(tmp_path):
    sweep = pipeline.load_scene(scene(tmp_path))
    design = Draw.of(sweep.variants.draw).design
    assert [entry.path for entry in design.inputs] == [
        "wear.specific_wear_rate",
        "disk.roughness.correlation_length",
        "disk.roughness.seed",
    ]
    assert (design.layers, design.per_contact) == (("wear rate", "contact", "contact"), 4)
    only = '[unknown]\n"temperature.critical" = { mean = "145 degC", sd = "8 K" }\n'
    judged = Draw.of(pipeline.load_scene(scene(tmp_path, only)).variants.draw).design
    # Samples that share a contact differ in the wear rate, though it is known.
    assert (judged.layers, judged.per_contact) == (("wear rate",), 2)


KNOWN_CONTACT = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }
"temperature.critical" = { mean = "145 degC", sd = "8 K" }
"""


def test_no_more_samples_are_drawn_than_suffice(tmp_path):
    sweep = pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT, samples=500))
    assert len(sweep.variants) == Draw.of(sweep.variants.draw).design.sufficient == 64
    assert any(
        note.worded.startswith("sweep.samples: 64 are computed") for note in sweep.about.notes
    )
    lists = '"disk.roughness.seed" = [0, 1, 2, 3, 4, 5, 6, 7]\n'
    assert len(pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT + lists, 500)).variants) == 128
    drawn = '"disk.roughness.correlation_length" = { from = "12 um", to = "24 um" }\n'
    assert len(pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT + drawn, 100)).variants) == 100


def test_samples_of_a_contact_have_its_inputs_and_its_wear_number(tmp_path):
    samples = pipeline.load_scene(scene(tmp_path, samples=16)).variants
    values, velocities = inputs_of(samples), np.array(samples.labels("velocity"))
    number = values[:, 0] * velocities
    for begin in range(0, 16, 4):
        assert np.ptp(values[begin : begin + 4, 1:], axis=0).max() == 0.0
        assert number[begin : begin + 4] == pytest.approx(number[begin], rel=1e-12)
        assert len(set(velocities[begin : begin + 4])) == 4
    fewer = pipeline.load_scene(scene(tmp_path)).variants
    assert np.array_equal(inputs_of(fewer), inputs_of(samples)[:8])
    assert fewer.labels("velocity") == samples.labels("velocity")[:8]


def test_a_sample_is_the_scene_with_its_values_typed_in(tmp_path):
    path = scene(tmp_path)
    sweep = pipeline.load_scene(path)
    rate, length, seed = inputs_of(sweep.variants)[5].tolist()
    values = {
        "wear.specific_wear_rate": f"{rate!r} m^2/N",
        "disk.roughness.correlation_length": f"{length!r} m",
        "disk.roughness.seed": round(seed),
    }
    typed = pipeline.load_scene(scene(tmp_path, "", None), overrides=values)
    assert sweep.variant((("variant", 5),)) == typed


def reasons_against(one, other):
    """Reasons why a sweep does not go on with the store of another one."""
    return [*misfits(join(None, one), other)]


def test_what_is_unknown_counts_only_with_samples(tmp_path):
    plain = pipeline.load_scene(scene(tmp_path, "", None))
    sweep = pipeline.load_scene(scene(tmp_path, UNKNOWN, None))
    assert tuple(note.worded for note in sweep.about.notes) == (
        "unknown: 5 inputs not known exactly; give sweep.samples to draw them",
    )
    assert changed(sweep, notes=()) == plain
    assert not reasons_against(plain, sweep)


def test_samples_are_part_of_what_a_store_is_of_but_conditions_are_not(tmp_path):
    sweep = pipeline.load_scene(scene(tmp_path))
    wider = pipeline.load_scene(scene(tmp_path, UNKNOWN.replace("8 K", "9 K")))
    other = pipeline.load_scene(scene(tmp_path, UNKNOWN.replace("factor = 1.5", "factor = 1.6")))
    assert not reasons_against(sweep, wider)
    assert reasons_against(sweep, other)
    assert reasons_against(sweep, changed(sweep, variants=Variants()))


def test_another_spelling_of_the_same_quantities_is_shown_and_is_the_same_scene(tmp_path):
    si = {
        "1.2e-6 mm^3/(N m)": "1.2e-15 1/Pa",
        '"12 um", to = "24 um"': '"0.012 mm", to = "24000 nm"',
        "145 degC": "418.15 K",
    }
    spelled = UNKNOWN
    for before, after in si.items():
        spelled = spelled.replace(before, after)
    sweep = pipeline.load_scene(scene(tmp_path))
    other = pipeline.load_scene(scene(tmp_path, spelled))
    assert other == sweep
    assert not reasons_against(sweep, other)
    said = str(Draw.of(other.variants.draw).unknown[3])
    assert said.endswith("normal, mean 418.15 K, sd 8 K")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            '"disk.roughness.ra" = { mean = "0.27 um", sd = "0.15 um" }',
            'reaches -0.285 µm in the outermost samples: disk.roughness.ra: "-0.285 µm" is '
            "out of range; give a length above 0",
        ),
        ('"wear.specific_rate" = [1, 2]', "wear.specific_rate: unknown key (did you mean"),
        (
            '"pin.radios" = { median = "2 mm", factor = 1.1 }',
            'unknown."pin.radios": pin.radios: unknown key (did you mean "radius"?)',
        ),
        ('"temperature.critical" = { mean = "145 degC", sd = "8 degC" }', 'such as "8 K"'),
        ('"pin.radius" = { mean = "2 mm", sd = 0.1 }', "give all with a unit, or none"),
        ('"pin.radius" = { from = "3 mm", to = "1 mm" }', "from 3 mm to 1 mm does not rise"),
        ('"wear.pattern" = ["swept", "local"]', '"swept" is not a number followed by a unit'),
        ('"sweep.loads" = ["1 N", "2 N"]', "cannot be unknown"),
        ('"loading.reference_load" = ["750 N", "400 N"]', "number of steps"),
    ],
)
def test_a_fault_says_what_is_wrong_and_with_which_input(tmp_path, line, words):
    messages = faults(scene(tmp_path, f"[unknown]\n{line}\n"))
    assert len(messages) == 1
    assert messages[0].startswith(f"unknown.{line.partition(' =')[0]}")
    assert words in messages[0]


PAIR = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5, correlated = CORRELATED }
"friction.coefficient" = { mean = 0.1, sd = 0.005 }
"disk.roughness.seed" = [0, 1, 2, 3]
[unknown."temperature.critical"]
mean = "145 degC"
sd = "8 K"
correlated = { friction.coefficient = -0.2 }
"""
WEAR = 'unknown."wear.specific_wear_rate".correlated'
CRITICAL = 'unknown."temperature.critical".correlated'


def test_either_of_two_inputs_may_say_that_they_are_correlated(tmp_path):
    path = scene(tmp_path, PAIR.replace("CORRELATED", '{ "temperature.critical" = 0.6 }'))
    sweep = pipeline.load_scene(path)
    rate, friction, _, critical = Draw.of(sweep.variants.draw).unknown
    assert rate.correlated == friction.correlated == ()
    assert critical.correlated == (
        ("wear.specific_wear_rate", 0.6),
        ("friction.coefficient", -0.2),
    )
    plain = pipeline.load_scene(scene(tmp_path, PAIR.replace("CORRELATED", "{}")))
    # Samples fill the ranges of the inputs, which correlations leave as they are.
    assert np.array_equal(inputs_of(plain.variants), inputs_of(sweep.variants))
    assert not reasons_against(plain, sweep)


@pytest.mark.parametrize(
    ("pairs", "key", "words"),
    [
        ('{ "temperature.critica" = 0.6 }', f'{WEAR}."temperature.critica"', "(did you mean"),
        ('{ "wear.specific_wear_rate" = 0.6 }', WEAR, "not another input of [unknown]"),
        ('{ "disk.roughness.seed" = 0.6 }', WEAR, "neither a list nor"),
        ('{ "temperature.critical" = 1.0 }', WEAR, "1.0 is out of range; give a number without a"),
        (
            '{ "friction.coefficient" = 0.9, "temperature.critical" = 0.6 }',
            CRITICAL,
            "the correlations of this input cannot all be; give smaller ones, or leave one out",
        ),
    ],
)
def test_a_correlation_that_cannot_be_is_told(tmp_path, pairs, key, words):
    (message,) = faults(scene(tmp_path, PAIR.replace("CORRELATED", pairs)))
    assert message.startswith(key)
    assert words in message


def test_an_input_that_changes_nothing_is_told(tmp_path):
    idle = SCENE.split("[materials.steel]")[1].split("[pin]")[0]
    text = SCENE.replace("[pin]", f"[materials.idle]{idle}[pin]")
    (message,) = faults(
        scene(
            tmp_path, '[unknown]\n"materials.idle.density" = ["1 g/cm^3", "2 g/cm^3"]\n', text=text
        )
    )
    assert "depends on it; leave it out" in message


def test_a_measured_transition_may_say_how_it_scatters(tmp_path):
    entry = '[[measured]]\nload = "400 N"\nvelocity = "2 m/s"\nfriction = 0.1\n'
    scatter = 'load_scatter = "8 N"\nvelocity_scatter = "10 cm/s"\nfriction_scatter = 0.004\n'
    (plain,) = pipeline.load_scene(scene(tmp_path, UNKNOWN + entry)).about.measured
    place = {"normal_load": 400.0, "velocity": 2.0, "friction": 0.1}
    assert plain.as_dict() == place | {"number": "1"}
    (transition,) = pipeline.load_scene(scene(tmp_path, UNKNOWN + entry + scatter)).about.measured
    assert transition.as_dict() == plain.as_dict() | {
        "load_scatter": 8.0,
        "velocity_scatter": 0.1,
        "friction_scatter": 0.004,
    }


# Inputs that vary from part to part


def test_an_input_varies_from_part_to_part_if_it_says_so_and_a_seed_always(tmp_path):
    parts = (
        '"wear.specific_wear_rate" = { median = "1e-6 mm^3/(N m)", factor = 1.5, varies = true }\n'
        '"friction.coefficient" = { mean = 0.1, sd = 0.005 }\n"disk.roughness.seed" = [0, 1]\n'
    )
    drawn = pipeline.load_scene(scene(tmp_path, f"[unknown]\n{parts}")).variants.draw
    assert [one.varies for one in Draw.of(drawn).unknown] == [True, False, True]
    assert str(Draw.of(drawn).unknown[0]).endswith("factor 1.5, from part to part")
    tied = parts.replace("0.005", '0.005, correlated = { "wear.specific_wear_rate" = 0.5 }')
    with pytest.raises(pipeline.SceneFileError, match="an input that alone varies"):
        pipeline.load_scene(scene(tmp_path, f"[unknown]\n{tied}"))


# Inputs whose value is given above their distribution


def test_an_input_given_by_a_setting_is_fixed_in_the_draw_too(tmp_path):
    path = scene(tmp_path)
    drawn = pipeline.load_scene(path)
    setting = {"disk.roughness.correlation_length": "15 um"}
    fixed = pipeline.load_scene(path, overrides=setting)
    assert [str(one) for one in Draw.of(fixed.variants.draw).fixed] == [
        "disk.roughness.correlation_length is fixed at 15 µm"
    ]
    assert "disk.roughness.correlation_length" not in [
        one.path for one in Draw.of(fixed.variants.draw).unknown
    ]
    assert fixed.variant((("variant", 5),)).scene.roughness.correlation_length == (15e-6, 15e-6)
    assert any("is fixed at 15 µm" in note.words for note in fixed.about.notes)
    assert reasons_against(drawn, fixed)
    assert Draw.of(drawn.variants.draw).fixed == ()


def test_a_scene_that_extends_another_fixes_what_it_gives(tmp_path):
    scene(tmp_path)
    above = tmp_path / "above.toml"
    above.write_text('extends = "scene.toml"\n[friction]\ncoefficient = 0.12\n')
    (friction,) = Draw.of(pipeline.load_scene(above).variants.draw).fixed
    assert (friction.unknown.path, friction.value) == ("friction.coefficient", 0.12)
    above.write_text(
        'extends = "scene.toml"\n[friction]\ncoefficient = 0.12\n[unknown]\n'
        '"friction.coefficient" = { mean = 0.12, sd = 0.001 }\n'
    )
    assert Draw.of(pipeline.load_scene(above).variants.draw).fixed == ()  # beside its distribution

"""The table [unknown] of a scene file: what it means, and every way to get it wrong."""

import pytest

import pipeline
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
    # Samples that share a contact have different wear rates, even if the scene's is known.
    assert (judged.layers, judged.per_contact) == (("wear rate",), 2)


KNOWN_CONTACT = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }
"temperature.critical" = { mean = "145 degC", sd = "8 K" }
"""


def test_no_more_samples_are_drawn_than_suffice(tmp_path):
    sweep = pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT, samples=500))
    assert len(sweep.variants) == Draw.of(sweep.variants.draw).design.sufficient == 64
    assert any(note.text.startswith("sweep.samples: 64 are computed") for note in sweep.notes)
    lists = '"disk.roughness.seed" = [0, 1, 2, 3, 4, 5, 6, 7]\n'
    assert len(pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT + lists, 500)).variants) == 128
    drawn = '"disk.roughness.correlation_length" = { from = "12 um", to = "24 um" }\n'
    assert len(pipeline.load_scene(scene(tmp_path, KNOWN_CONTACT + drawn, 100)).variants) == 100


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
    """Reasons why a sweep cannot resume the store of another one."""
    return [*misfits(join(None, one), other)]


def test_what_is_unknown_counts_only_with_samples(tmp_path):
    plain = pipeline.load_scene(scene(tmp_path, "", None))
    sweep = pipeline.load_scene(scene(tmp_path, UNKNOWN, None))
    assert tuple(note.text for note in sweep.notes) == (
        "unknown: inputs: 5; give sweep.samples to draw them",
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
    with pytest.raises(pipeline.SceneFileError, match="nor can inputs that differ in `varies`"):
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
    assert any("is fixed at 15 µm" in note.words for note in fixed.notes)
    assert reasons_against(drawn, fixed)
    assert Draw.of(drawn.variants.draw).fixed == ()

"""Surfaces and conditions as users read them."""

import math
from dataclasses import replace

import pytest

import tribo
from pipeline.sweep.condition_words import judged_by
from pipeline.sweep.surface import SurfaceFacts, surface_facts
from tests.helpers import tiny

BENT = tribo.Corrections(friction=tribo.Friction(by_velocity=((1.0, 1.2), (4.0, 0.8))))


@pytest.mark.parametrize(
    ("lengths", "lay"),
    [((8e-6, 4e-6), 0.0), ((4e-6, 8e-6), 90.0), ((7.9e-6, 4e-6), None), ((4e-6, 7.9e-6), None)],
)
def test_a_large_random_surface_has_the_lay_of_lengths_that_differ_by_two(lengths, lay):
    rough = tribo.SelfAffineRoughness(0.27e-6, 0.8, lengths, seed=0)
    facts = surface_facts(
        tiny.sweep(roughness=rough, pixels=tribo.Grid((1001, 1000), (1e-6, 1e-6)))
    )
    assert (facts.lay, facts.slope, facts.ra) == (lay, None, 0.27e-6)
    assert facts.rq == pytest.approx(0.27e-6 * math.sqrt(math.pi / 2))
    assert (facts.mean_height, facts.rise) == (0.0, (0.0, 0.0))


def test_conditions_of_several_are_said_once_each():
    own = tiny.sweep().conditions
    warm = replace(own, critical_temperature=438.15)
    bent = replace(warm, corrections=BENT)
    assert judged_by([own]) == (
        "severe wear: more than 10 % of the contact above 145 °C; friction 0.1, bulk 25 °C"
    )
    assert judged_by([own, warm, warm]) == (
        "severe wear: more than 10 % of the contact above 145 °C or more than 10 % of the contact "
        "above 165 °C; friction 0.1, bulk 25 °C"
    )
    assert judged_by([bent]).endswith(f"above 165 °C; friction 0.1, bulk 25 °C; {BENT.text}")
    assert judged_by([own, bent]).endswith(f"no correction or {BENT.text}")


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        (SurfaceFacts(False, 0.27e-6, 0.338e-6), "random: Ra 0.27 µm, Rq 0.338 µm, no lay"),
        (
            SurfaceFacts(False, 0.27e-6, 0.338e-6, lay=89.7, slope=0.123),
            "random: Ra 0.27 µm, Rq 0.338 µm, rms slope 0.12, grooves at 90° to sliding",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 1e-13, (1e-13, -1.9e-13)),
            "measured: Ra 0.1 µm, Rq 0.2 µm, no lay; level",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 0.0, (0.0, -3e-6), lay=0.0),
            "measured: Ra 0.1 µm, Rq 0.2 µm, grooves at 0° to sliding; mean plane at 0 µm, rising "
            "by 0 µm along x and -3 µm along y over the window",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 5e-6),
            "measured: Ra 0.1 µm, Rq 0.2 µm, no lay; mean plane at 5 µm, rising by 0 µm along x "
            "and 0 µm along y over the window",
        ),
    ],
)
def test_a_surface_is_said_by_its_heights_its_lay_and_its_level(facts, words):
    assert facts.words == words

"""Warnings of values outside their usual range (tribo/simulation/usual_values.py)."""

from dataclasses import replace

import pytest

import pipeline
import tribo
from tests.helpers.kept import assert_as_kept
from tests.helpers.scenes import STEEL, small_scene
from tribo.simulation.usual_values import USUAL

SCENE = small_scene(increments=2)
OIL = tribo.Conditions(0.1, 298.0, 418.0)


def unusual(scene=SCENE, conditions=OIL, velocity=1.25):
    """Texts of the warnings of a verdict that are about values."""
    warnings = tribo.judge(scene, 600.0, velocity, conditions).warnings
    return [w.text for w in warnings if w.kind == tribo.WarningKind.UNUSUAL_VALUE]


def test_usual_values_carry_no_warning():
    assert unusual() == []


UNUSUAL = {
    "wear rate": lambda: unusual(replace(SCENE, wear=tribo.Wear(1.2e-9))),
    "wear rate that no unit explains": lambda: unusual(replace(SCENE, wear=tribo.Wear(3e-28))),
    "bulk temperature": lambda: unusual(conditions=tribo.Conditions(0.1, 25.0, 418.0)),
    "both temperatures": lambda: unusual(conditions=tribo.Conditions(0.1, 25.0, 145.0)),
    "density": lambda: unusual(replace(SCENE, disk=replace(STEEL, density=7.8))),
    "radius": lambda: unusual(replace(SCENE, pin=tribo.Cylinder(2.0, 3.4e-3, STEEL))),
    "friction": lambda: unusual(conditions=tribo.Conditions(10.0, 298.0, 418.0)),
}


def test_unusual_values_are_named_with_their_likely_unit_in_words_that_are_kept():
    texts = {name: "\n".join(warn()) for name, warn in UNUSUAL.items()}
    assert_as_kept("unusual_values", texts)


@pytest.mark.parametrize("velocity", [1.25, -1.25])
def test_an_error_of_a_simulation_has_the_warnings_as_notes(velocity):
    with pytest.raises(tribo.ConvergenceError) as error:
        unusual(replace(SCENE, wear=tribo.Wear(1.2e-6)), velocity=velocity)
    assert error.value.__notes__ == [
        "wear.specific_wear_rate: 1.2e-06 m²/N is unusual (1e-11 to 0.01 mm³/(N m) is common): "
        "convert the number to SI, if it is in mm³/(N m)"
    ]


def test_a_verdict_has_the_warnings_of_its_point():
    narrow = replace(SCENE, pixels=tribo.Grid((16, 16), (4e-6, 8e-6)))
    verdict = tribo.judge(narrow, 600.0, 1.25, OIL)
    assert tribo.WarningKind.CONTACT_AT_EDGE in {warning.kind for warning in verdict.warnings}


@pytest.mark.parametrize(
    ("quantity", "low", "high"),
    [
        ("thermal_conductivity", 0.05, 2500), ("density", 500, 25e3), ("specific_heat", 100, 5e3),
        ("length", 1e-4, 1.0), ("crown_radius", 1e-4, 100.0), ("slide_roll_ratio", -20, 20),
        ("duration", 0.05, 1e6), ("added_rise_fraction", 0, 0.5),
    ],
)  # fmt: skip
def test_usual_values_end_where_no_real_contact_is(quantity, low, high):
    usual, margin = USUAL[quantity], 1e-3 * high
    assert usual.contains(high - margin)
    assert not usual.contains(high + margin)
    assert usual.contains(low + 1e-3 * abs(low))
    assert not usual.contains(low - 1e-3 * (abs(low) or high))


def test_units_have_the_sizes_that_pint_gives():
    for usual in USUAL.values():
        for unit, size in ((usual.unit, usual.size), *usual.mistaken):
            if size != 1 and unit != "%":
                assert pipeline.to_si(f"1 {unit}", like=f"1 {unit}") == pytest.approx(
                    size, rel=1e-12
                )

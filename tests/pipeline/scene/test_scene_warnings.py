"""At which values a scene begins to be doubted (pipeline/scene/scene_warnings.py).

Which warnings there are is in test_facts.py.
"""

import re
from dataclasses import replace

import pytest

import tribo
from pipeline import load_scene
from pipeline.answers.scene_notes import warning_text
from pipeline.scene.contact_estimate import Span, estimate_contact
from pipeline.scene.scene_warnings import warnings_of_case
from pipeline.sweep.notes import SceneWarning
from tests.helpers.entries import bare_test, changed
from tests.pipeline.scene.test_contact_estimate import BALL, CROWNED, SMOOTH
from tribo.simulation.lubrication import SurfaceSummary

SOURCE = load_scene("first_try").source


def with_test(load):
    velocity = max(SMOOTH.velocities)
    return changed(SMOOTH, loads=(200.0, 750.0), tests=(bare_test(load, velocity),))


def said_of(sweep, **facts):
    named = replace(sweep, source=SOURCE)
    found = warnings_of_case(named, replace(estimate_contact(sweep), **facts))
    return [warning_text(one) for one in found]


def surface(**changes):
    return SurfaceSummary(**({"measured": True, "ra": 0.3e-6, "rq": 0.4e-6} | changes))


# The usual ranges, stated here independently of the code: wide enough for any real scene, narrow
# enough to notice a wrong unit.
STEELS = "materials.steel"
USUAL = [
    (f"{STEELS}.elastic_modulus", 1, 1200, "GPa", {f"{STEELS}.hardness": "20 MPa"}),
    (f"{STEELS}.hardness", 0.21, 42, "GPa", {f"{STEELS}.elastic_modulus": "210 GPa"}),
    ("pin.radius", 0.1, 1000, "mm", {}),
    ("temperature.bulk", -50, 250, "degC", {"temperature.critical": "700 degC"}),
    ("wear.specific_wear_rate", 1e-11, 1e-2, "mm^3/(N m)", {}),
    ("disk.roughness.ra", 0.001, 10, "um", {}),
    ("sweep.velocities", 0, 100, "m/s", {}),
    ("friction.coefficient", 0, 1, "", {"without": ["friction.band"]}),
    ("oil.kinematic_viscosity", 0.5, 1e5, "mm^2/s", {"oil": {"density": "860 kg/m^3"}}),
    ("loading.reference_load", 7.5, 75e3, "N", {"sweep.loads": ["750 N"]}),
]


@pytest.mark.parametrize(
    ("path", "low", "high", "unit", "beside"), USUAL, ids=[r[0] for r in USUAL]
)
def test_values_are_doubted_beyond_the_usual_and_not_within(path, low, high, unit, beside):
    def is_doubted(value):
        entry = f"{value!r} {unit}" if unit else value
        if path == "sweep.velocities":
            entry = [entry]
        if path == "oil.kinematic_viscosity":
            higher, lower = (value, 0.9 * value) if value > 10 else (1.1 * value, value)
            entry = [f"{higher!r} {unit}", f"{lower!r} {unit}"]
        scene = load_scene("first_try", overrides={**beside, path: entry})
        key = path.rpartition(".")[2]
        found = *scene.warnings, *warnings_of_case(scene, estimate_contact(scene))
        unusual = (one.place.split("[")[0] for one in found if one.code == "unusual")
        return any(place.endswith(key) for place in unusual)

    def beyond(end, less):
        return end + less * 1e-3 * abs(end)

    for value in (beyond(low, -1), beyond(high, 1)) if low else (beyond(high, 1),):
        assert is_doubted(value), value
    for value in (beyond(low, 1), beyond(high, -1)) if low else (beyond(high, -1),):
        assert not is_doubted(value), value


@pytest.mark.parametrize(("load", "is_far"), [(19.9, 1), (20.1, 0), (7499.0, 0), (7501.0, 1)])
def test_a_test_far_outside_the_sweep_is_doubted(load, is_far):
    assert sum("the test at" in doubt for doubt in said_of(with_test(load))) == is_far


def test_a_ratio_in_percent_is_doubted_or_read():
    def doubted(ratio):
        rolling = load_scene("twin_disc", overrides={"motion.slide_roll_ratio": ratio})
        return any(note.place == "motion.slide_roll_ratio" for note in rolling.warnings)

    assert [doubted(ratio) for ratio in (-21.0, -20.0, 0.5, 20.0, 50.0)] == [1, 0, 0, 0, 1]
    read = load_scene("twin_disc", overrides={"motion.slide_roll_ratio": "50 %"})
    assert read.scene.motion.slide_roll_ratio == 0.5


@pytest.mark.parametrize(
    ("length", "words"),
    [(0.33, None), (0.34, "more than a third of the window")],
)
def test_a_correlation_length_is_small_beside_the_window(length, words):
    nx, dx = SMOOTH.scene.pixels.shape[0], SMOOTH.scene.pixels.spacing[0]
    length *= nx * dx
    ny, dy = SMOOTH.scene.pixels.shape[1], SMOOTH.scene.pixels.spacing[1]
    rough = tribo.SelfAffineRoughness(0.3e-6, 0.8, (length, 0.2 * ny * dy))
    said = said_of(changed(SMOOTH, roughness=rough), surface=surface(measured=False))
    doubts = [doubt for doubt in said if "correlation_length: along x it is" in doubt]
    assert len(doubts) == bool(words)
    assert not words or words in doubts[0]


@pytest.mark.parametrize(
    ("half_width", "expected", "said"),
    [
        (49e-6, 99e-6, ()),
        (50e-6, 99e-6, ("may grow to 100 µm, beyond the window's 100 µm",)),
        (49e-6, 100e-6, ("may grow to 100 µm, beyond the window's 100 µm",)),
    ],
)
def test_a_contact_has_to_fit_into_the_window(half_width, expected, said):
    doubts = said_of(
        SMOOTH,
        hertz_half_width=Span(1e-6, half_width),
        contact_width=Span(90e-6, max(expected, 90e-6)),
        window=(100e-6, 20e-6),  # periodic along y
    )
    doubts = [doubt for doubt in doubts if "sharp ends" not in doubt]
    assert len(doubts) == bool(said)
    assert all(text in doubts[0] for text in said)


def test_sharp_ends_turn_severe_at_lower_velocities():
    ((nearest, farthest),) = re.findall(
        r"(\d+)–(\d+) % lower", warning_text(SceneWarning("sharp_ends"))
    )
    # Rises are 4 to 11 % higher, and grow about as the square root of velocity (PHYSICS.md).
    falls = [100 * (1 - (1 + rise) ** -2.0) for rise in (0.04, 0.11)]
    assert falls == pytest.approx([int(nearest), int(farthest)], rel=0.25)


def test_under_a_ball_or_a_crowned_pin_it_has_to_fit_along_y_too():
    contact = {"hertz_half_width": Span(1e-6, 49e-6), "contact_width": Span(70e-6, 80e-6)}
    wide, narrow = (1.0, 90e-6), (1.0, 110e-6)
    assert said_of(BALL, **contact, window=narrow) == said_of(BALL)
    assert any("the window's 90 µm" in doubt for doubt in said_of(BALL, **contact, window=wide))
    ratio = tribo.analytic.hertz_ellipse(1.0, 2e-3, 8e-3, 1e11)
    longer = ratio[1] / ratio[0]
    for room, fits in ((0.97, False), (0.99, True)):  # the contact is 98 µm wide
        window = (1.0, room * 100e-6 * longer)
        doubts = said_of(CROWNED, **contact, window=window)
        assert any("beyond the window" in doubt for doubt in doubts) is not fits


def test_a_surface_is_described_without_the_doubts_about_it():
    rough = load_scene("first_try", overrides={"disk.roughness.ra": "50 um"})
    assert "disk.roughness.ra" in [one.place for one in rough.warnings]

"""Closed-form estimates of scenes, compared with simulations, and warnings about scenes."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

import tribo
from pipeline import load_scene, run_point
from pipeline.scene import scene_warnings
from pipeline.scene.contact_estimate import Span, estimate_contact
from pipeline.scene.scene_warnings import warnings_of_all
from tests.helpers import laws, tiny
from tests.helpers.entries import bare_test, changed
from tests.helpers.kept import assert_as_kept
from tests.helpers.scenes import SCENE, STEEL
from tribo.simulation.lubrication import SurfaceSummary, summarize_surface

SMOOTH = tiny.sweep(
    pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
    pixels=tribo.Grid((900, 2), (1e-6, 200e-6)),
    roughness=None,
    fidelity={"contact_tolerance": 1e-4},
    increments=25,
    friction_band=None,
)
BALL = changed(
    SMOOTH,
    pin=tribo.Ball(radius=5e-3, material=STEEL),
    pixels=tribo.Grid((96, 96), (3e-6, 3e-6), periodic=(False, False)),
    wear=None,
    loading=tribo.Ramp(rate=2.0, reference_load=10.0),
    loads=(10.0,),
    velocities=(1.0,),
)


def rough(array, **changes):
    """Sweep on a measured surface with these heights."""
    grid = tribo.Grid(array.shape, (1e-6, 2e-6))
    return changed(SMOOTH, pixels=grid, roughness=tribo.MeasuredRoughness(array), **changes)


def waves(nx=64, ny=32, along=0):
    """Heights of grooves along one axis, amplitude 0.3 µm, wavelength 8 pixels."""
    position = np.indices((nx, ny))[along]
    return 0.3e-6 * np.sin(2 * np.pi * position / 8)


@pytest.mark.parametrize(("rate", "load", "velocity"), [(0.0, 600.0, 4.0), (1.2e-14, 200.0, 0.5)])
def test_width_and_depth_are_those_of_a_smooth_cylinder(rate, load, velocity):
    sweep = changed(SMOOTH, wear=tribo.Wear(rate), loads=(load,), velocities=(velocity,))
    facts, columns = estimate_contact(sweep), run_point(sweep, load, velocity).columns
    assert facts.contact_width.low == pytest.approx(columns["contact_width"][-1], rel=0.03)
    if rate:
        assert facts.wear_depth.low == pytest.approx(columns["wear_depth_max"][-1], rel=0.1)
    else:
        assert facts.wear_depth.low == 0.0
        assert facts.hertz_pressure.low == pytest.approx(columns["max_pressure"][-1], rel=0.01)
    assert facts.duration.low == pytest.approx(columns["time"][-1], rel=1e-12)
    assert facts.sliding_distance.low == pytest.approx(columns["sliding_distance"][-1], rel=1e-12)


def test_a_law_of_a_user_wears_by_its_mean_from_the_first_metre_to_the_last():
    law = laws.Tabled(laws.Table(distances=(0.0, 20.0), rates=(4e-15, 1e-15)))
    by_law, by_rate = (
        estimate_contact(changed(SMOOTH, wear=wear, loads=(600.0,), velocities=(4.0,)))
        for wear in (law, tribo.Wear(2.8e-15))
    )
    assert by_law.sliding_distance.low == pytest.approx(16.0)  # 4 s at 150 N/s; rate at 8 m
    assert by_law.wear_depth.low == pytest.approx(by_rate.wear_depth.low, rel=1e-9)


def test_roughness_widens_the_contact_as_in_the_simulation():
    sweep = changed(
        SMOOTH,
        pixels=tribo.Grid((240, 240), (1.632e-6, 1.9e-6)),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=0),
        loads=(200.0,),
        velocities=(0.5,),
    )
    width = run_point(sweep, 200.0, 0.5).columns["contact_width"][-1]
    facts = estimate_contact(sweep)
    assert facts.contact_width.low == pytest.approx(width, rel=0.12)
    assert width > 1.25 * 2 * facts.hertz_half_width.low


def test_the_greatest_load_is_the_last_that_the_window_carries():
    greatest = SMOOTH.scene.greatest_load
    edge = changed(SMOOTH, wear=None, loading=tribo.Ramp(150.0, greatest))
    run_point(edge, greatest * (1 - 1e-9), 0.0)
    with pytest.raises(tribo.InputError):
        run_point(edge, greatest * (1 + 1e-6), 0.0)


@pytest.mark.parametrize(("along", "lay"), [(0, 90.0), (1, 0.0)])
def test_grooves_lie_across_the_direction_in_which_heights_change(along, lay):
    assert summarize_surface(rough(waves(along=along)).scene).lay == pytest.approx(lay, abs=1e-6)


# Warnings about a scene, and the values from which they are given.

SOURCE = load_scene("first_try").source


def warning_texts(sweep, **facts):
    named_sweep = replace(sweep, source=SOURCE)
    estimate = replace(estimate_contact(sweep), **facts)
    with mock.patch.object(scene_warnings, "estimate_contact", return_value=estimate):
        return [warning.text for warning in warnings_of_all(named_sweep)]


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
    ("path", "low", "high", "unit", "other_entries"), USUAL, ids=[r[0] for r in USUAL]
)
def test_values_are_doubted_beyond_the_usual_and_not_within(path, low, high, unit, other_entries):
    def is_doubted(value):
        entry = f"{value!r} {unit}" if unit else value
        if path == "sweep.velocities":
            entry = [entry]
        if path == "oil.kinematic_viscosity":
            higher, lower = (value, 0.9 * value) if value > 10 else (1.1 * value, value)
            entry = [f"{higher!r} {unit}", f"{lower!r} {unit}"]
        scene = load_scene("first_try", overrides={**other_entries, path: entry})
        key = path.rpartition(".")[2]
        unusual = (
            warning.path.split("[")[0]
            for warning in warnings_of_all(scene)
            if "is unusual" in warning.words
        )
        return any(warning_place.endswith(key) for warning_place in unusual)

    def beyond(end, less):
        return end + less * 1e-3 * abs(end)

    for value in (beyond(low, -1), beyond(high, 1)) if low else (beyond(high, 1),):
        assert is_doubted(value), value
    for value in (beyond(low, 1), beyond(high, -1)) if low else (beyond(high, -1),):
        assert not is_doubted(value), value


def test_a_test_with_its_own_entries_repeats_no_warning_of_the_scene():
    test = {"load": "400 N", "velocity": "2 m/s", "outcome": "mild",
            "with": {"wear.specific_wear_rate": "1e-6 mm^3/(N m)"}}  # fmt: skip
    scene = load_scene("first_try", overrides={"disk.roughness.ra": "11 um", "tests": [test]})
    assert [w.path for w in scene.all_warnings if "11 µm is" in w.words] == ["disk.roughness.ra"]


@pytest.mark.parametrize(
    ("load", "factor", "is_far"),
    [(19.9, 1, 1), (20.1, 1, 0), (7499.0, 1, 0), (7501.0, 1, 1), (200.0, 9.9, 0), (200.0, 10.1, 1)],
)
def test_a_test_far_outside_the_sweep_is_doubted(load, factor, is_far):
    test = bare_test(load, factor * max(SMOOTH.velocities))
    doubts = warning_texts(changed(SMOOTH, loads=(200.0, 750.0), tests=(test,)))
    place = f"{load:g} N at {test.velocity:g} m/s"
    words = f"the test at {place} lies far outside the sweep: check its units"
    assert sum(words in doubt for doubt in doubts) == is_far


@pytest.mark.parametrize(
    ("half_width", "expected", "count"),
    [(49e-6, 99e-6, False), (50e-6, 99e-6, True), (49e-6, 100e-6, True)],
)
def test_a_contact_has_to_fit_into_the_window(half_width, expected, count):
    doubts = warning_texts(
        SMOOTH,
        hertz_half_width=Span(1e-6, half_width),
        contact_width=Span(90e-6, max(expected, 90e-6)),
        window=(100e-6, 20e-6),  # periodic along y
    )
    beyond = "may grow to 100 µm, wider than the window (100 µm)"
    assert sum(beyond in doubt for doubt in doubts) == count


@pytest.mark.parametrize(
    ("lay", "measured", "pattern", "is_warned"),
    [
        (30.0, True, "swept", True),
        (30.1, True, "swept", False),
        (0.0, True, "local", False),
        (0.0, False, "swept", True),
        (None, True, "swept", False),
    ],
)
def test_grooves_along_sliding_are_doubted(lay, measured, pattern, is_warned):
    scene = changed(SMOOTH, wear=tribo.Wear(1.2e-15, pattern))
    texts = warning_texts(scene, surface=surface(lay=lay, measured=measured))
    words = (
        "the grooves run along the sliding direction; if the same grooves pass the pin again, "
        'pattern = "swept" makes the rise about 50 % too high: use pattern = "local"'
    )
    assert any(words in text for text in texts) is is_warned


@pytest.mark.parametrize(
    ("path", "facts", "is_warned"),
    [
        ("loading", {"duration": Span(1.0, 1.1e6)}, True),
        ("loading", {"duration": Span(0.04, 1.0)}, False),
        ("disk.roughness.ra", {"surface": surface(ra=11e-6)}, True),
        ("disk.roughness.ra", {"surface": surface(ra=11e-6, measured=False)}, False),
    ],
)
def test_the_longest_loading_and_the_ra_of_a_scan_are_doubted(path, facts, is_warned):
    texts = warning_texts(SMOOTH, **facts)
    assert any(text.startswith(f"{path}: ") and "unusual" in text for text in texts) is is_warned


# Missing entries, and tests with another loading history

ROLLING = {"motion": {"slide_roll_ratio": 0.5, "pin_track_length": "314 mm"}}
COLD = {
    "pin and disk": ROLLING,
    "pin": ROLLING | {"disk.track_length": "314 mm"},
    "a pin at rest": {"motion": {"slide_roll_ratio": 2}},
    "none": ROLLING | {"pin.track_length": "314 mm", "disk.track_length": "314 mm"},
    "none without sizes": ROLLING | {"temperature.includes_earlier_revolutions": True},
}
"""Bodies whose heat from earlier revolutions scenes leave out, and entries of the scenes."""


def test_heat_that_a_scene_leaves_out_is_warned_of_in_words_that_are_kept(tmp_path):
    (tmp_path / "plain.toml").write_text(SCENE)
    scenes = {name: load_scene(tmp_path / "plain.toml", overrides=COLD[name]) for name in COLD}
    texts = {
        name: "\n".join(warning.text for warning in scene.all_warnings)
        for name, scene in scenes.items()
    }
    assert_as_kept("heat_left_out", texts)


def test_specimens_that_are_simulated_as_several_are_told_in_one_line():
    run = {"velocity": "2 m/s", "mild_up_to": "300 N", "severe_at": "400 N"}
    scene = load_scene("first_try", overrides={"tests": [run] * 2})
    (line,) = [warning.text for warning in scene.all_warnings if "specimen" in warning.text]
    assert line.startswith("tests 1, 2: one specimen at several points")

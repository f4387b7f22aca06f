"""``irg check`` says what a scene means, and what it costs."""

import math
from pathlib import Path

import numpy as np
import pytest

SCENE = str(Path(__file__).parents[3] / "workflows" / "first_try.toml")


@pytest.fixture
def check(irg):
    return lambda *options, scene=SCENE, code=0: irg("check", scene, *options, code=code)


def test_a_check_says_what_a_scene_means(check):
    output = check()
    for words in (
        "Hertz: maximum pressure 1.04 to 2.01 GPa, half-width 36 to 69.8 µm",
        "Ra 0.27 µm, Rq 0.338 µm, rms slope 0.15, no lay",
        "duration 1.33 to 5 s, sliding distance 1.33 to 20 m",
        "0.616 to 9.81 µm deep",
        "Péclet number V a/(2 κ) 1.47 to 11.4",
        "288 × 240 elements",
        "MB of memory per worker",
    ):
        assert words in output
    assert len(output.splitlines()) <= 20
    assert max(map(len, output.splitlines())) <= 100
    rows = {row["subject"]: row["meaning"] for row in check("--json")["statements"]}
    assert "repeats along y; pin ends: not modelled" in output
    assert "warning" not in rows
    assert {"contact", "window", "surface", "motion", "wear", "heat", "points", "time"} < {*rows}


def test_the_roughness_of_a_curved_scan_is_told_without_its_curvature(check, tmp_path):
    x = 2.5e-6 * np.arange(80)
    heights = np.random.default_rng(0).normal(0.0, 1e-8, (60, 80)) - x**2 / 0.2
    np.save(tmp_path / "a.npy", heights)
    scan = f'disk.roughness={{ file = "{tmp_path}/a.npy", height_unit = "m" }}'
    window = "window.pixels=[80, 60]", 'window.pixel_size=["2.5 um", "2.5 um"]'
    settings = "without=disk.roughness", scan, *window
    output = check(*(part for setting in settings for part in ("--set", setting)))
    assert "; Ra and Rq exclude the curvature, R 100 mm along x;" in " ".join(output.split())


@pytest.mark.parametrize("options", [(), ("--set", "model.rise=0")])
def test_a_check_of_a_reciprocating_contact_says_the_word_and_the_size(check, options):
    coarse = "--set", "window.pixels=[120,120]"
    output = " ".join(check(*coarse, *options, scene="srv").split())
    assert "reciprocation is not modelled: heat of earlier strokes adds 11 to 14 %" in output


def test_each_row_is_described_at_its_own_place_and_a_warning_stands_once(check):
    """Points A and E of the gears: Hertz contact of cylinders and flank velocities by hand."""
    document = check("--json", scene="gear_mesh")
    first, *_, last = document["cases"]
    assert (first["case"], last["case"]) == ("A", "E")
    modulus = 209e9 / (2 * (1 - 0.28**2))
    for row, radius in ((first, 7.403e-3), (last, 5.094e-3)):
        line, half = 2976 / 20e-3, row["hertz_half_width"]
        assert half == pytest.approx((4 * line * radius / (math.pi * modulus)) ** 0.5, rel=1e-3)
        assert row["hertz_pressure"] == pytest.approx(2 * line / (math.pi * half), rel=1e-3)
        mean = (row["pin_velocity"] + row["disk_velocity"]) / 2
        ratio = (row["disk_velocity"] - row["pin_velocity"]) / mean
        assert row["slide_roll_ratio"] == pytest.approx(ratio)
    assert (last["pin_velocity"], last["disk_velocity"]) == pytest.approx((0.938, 6.53), rel=1e-3)
    assert "earlier revolutions" not in str(document["statements"])  # the scene measured the teeth
    cold = "temperature.includes_earlier_revolutions=false"
    document = check("--json", "--set", cold, scene="gear_mesh")
    words = [
        statement["meaning"]
        for statement in document["statements"]
        if "earlier revolutions" in statement["meaning"]
    ]
    assert len(words) == 1
    assert words[0].endswith("(in all cases; numbers are of case A)")


def test_load_factors_are_counted_and_the_contact_is_that_of_the_highest(check):
    factors, one_row = "sweep.load_factors=[0.5, 1, 2]", "sweep.along=[{%s}]"
    row = one_row % 'load = "4 kN", velocity = "2 m/s", place = "D"'
    rows = check("--set", factors, scene="gear_mesh")
    assert "24: 8 cases, each at its own load and velocity, 3 load factors from 0.5 to 2" in rows
    document = check("--json", "--set", factors, "--set", row, scene="gear_mesh")
    assert (document["cases"][0]["load"], document["cost"]["points"]) == (4000.0, 3)
    low, high = document["contact"]["hertz_pressure"]
    assert high / low == pytest.approx(2.0)  # the pressure of a line grows with the root of load


@pytest.mark.parametrize(
    ("entries", "has_boundary"),
    [
        ((), True),
        (("friction.coefficient=0",), False),
        (("sweep.velocities=['0 m/s']",), False),
        (('without=["temperature.critical", "tests"]',), False),
    ],
)
def test_only_a_sweep_with_a_boundary_has_its_error(check, entries, has_boundary):
    words = [word for entry in entries for word in ("--set", entry)]
    subjects = [row["subject"] for row in check("--json", *words)["statements"]]
    assert ("error" in subjects) == has_boundary


def test_what_cannot_be_run_fails_here_and_in_a_run(check, irg, tmp_path):
    setting, message = 'sweep.loads=["75 kN"]', "sweep.loads: 75000 N exceeds what the window of"
    assert message in check("--set", setting, code=2)
    assert message in irg("run", SCENE, "--set", setting, "-o", tmp_path / "out.zarr", code=2)
    assert not [*tmp_path.iterdir()]


def test_a_scene_that_needs_more_memory_than_there_is_is_refused(check, monkeypatch):
    monkeypatch.setattr("pipeline.cli.check.worker_bytes", lambda sweep: 3e9)
    monkeypatch.setattr("pipeline.cli.check.machine_memory", lambda: 2e9)
    assert check(code=2).strip() == (
        "irg: the scene needs about 3000 MB of memory per worker, but this machine has 2 GB; "
        "reduce window.pixels, or choose coarser settings in [fidelity]"
    )

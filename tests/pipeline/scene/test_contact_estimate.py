"""ContactEstimate of a scene in closed form, against its simulation."""

from dataclasses import replace

import numpy as np
import pytest

import tribo
from pipeline import load_scene, run_point
from pipeline.answers.scene_notes import warning_text
from pipeline.scene.contact_estimate import estimate_contact
from pipeline.scene.scene_warnings import warnings_of_case
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.scenes import STEEL
from tribo.simulation.lubrication import summarize_surface

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


CROWNED = changed(
    BALL,
    pin=tribo.Crowned(radius=2e-3, crown_radius=8e-3, material=STEEL),
    pixels=tribo.Grid((120, 120), (1.5e-6, 4e-6), periodic=(False, False)),
)


def test_width_and_depth_are_those_of_a_smooth_crowned_pin():
    sweep = changed(CROWNED, wear=tribo.Wear(1e-15, "local"))
    facts, columns = estimate_contact(sweep), run_point(sweep, 10.0, 1.0).columns
    assert facts.contact_width.low == pytest.approx(columns["contact_width"][-1], rel=0.05)
    assert facts.wear_depth.low == pytest.approx(columns["wear_depth_max"][-1], rel=0.15)


def rough(array, **changes):
    """Sweep on a measured surface with these heights."""
    grid = tribo.Grid(array.shape, (1e-6, 2e-6))
    return changed(SMOOTH, pixels=grid, roughness=tribo.MeasuredRoughness(array), **changes)


def waves(nx=64, ny=32, along=0):
    """Heights of grooves along one axis, amplitude 0.3 µm, wavelength 8 pixels."""
    place = np.indices((nx, ny))[along]
    return 0.3e-6 * np.sin(2 * np.pi * place / 8)


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


def test_spans_cover_all_loads_and_velocities():
    facts = estimate_contact(changed(SMOOTH, loads=(200.0, 800.0), velocities=(0.0, 2.0)))
    assert facts.hertz_pressure.high == pytest.approx(2 * facts.hertz_pressure.low, rel=1e-12)
    assert facts.duration == pytest.approx((200 / 150, 800 / 150), rel=1e-12)
    assert facts.sliding_distance == pytest.approx((0.0, 1600 / 150), rel=1e-12)
    assert facts.peclet_number.low == 0.0
    expected = 2.0 * facts.hertz_half_width.high / (2 * STEEL.thermal_diffusivity)
    assert facts.peclet_number.high == pytest.approx(expected, rel=1e-12)


def test_the_greatest_load_is_the_last_that_the_window_carries():
    greatest = SMOOTH.scene.greatest_load
    edge = changed(SMOOTH, wear=None, loading=tribo.Ramp(150.0, greatest))
    run_point(edge, greatest * (1 - 1e-9), 0.0)
    with pytest.raises(tribo.InputError):
        run_point(edge, greatest * (1 + 1e-6), 0.0)


def test_a_tilted_surface_is_described_above_its_mean_plane():
    i, j = np.indices((64, 32))
    level = waves()
    tilted = level + 5e-6 + 2e-8 * i - 1e-7 * j
    facts = summarize_surface(rough(tilted).scene)
    assert facts.mean_height == pytest.approx(tilted.mean(), rel=1e-12)
    # The waves, 8 periods of a sine, have a small slope of their own.
    assert facts.rise == pytest.approx((64 * 2e-8, -32 * 1e-7), rel=0.06)
    assert facts.rq == pytest.approx(0.3e-6 / np.sqrt(2), rel=0.01)
    assert facts.ra == pytest.approx(0.3e-6 * 2 / np.pi, rel=0.05)


@pytest.mark.parametrize(("along", "lay"), [(0, 90.0), (1, 0.0)])
def test_grooves_lie_across_the_direction_in_which_heights_change(along, lay):
    assert summarize_surface(rough(waves(along=along)).scene).lay == pytest.approx(lay, abs=1e-6)


def test_the_lay_of_a_random_surface_is_that_of_its_correlation_lengths():
    def lay(length, count):
        surface = tribo.SelfAffineRoughness(0.27e-6, 0.8, length, seed=3)
        grid = tribo.Grid((count, count), (1e-6, 1e-6))
        return summarize_surface(changed(SMOOTH, pixels=grid, roughness=surface).scene).lay

    assert lay((4e-6, 4e-6), 128) is None
    assert lay((4e-6, 40e-6), 128) == 90.0
    assert lay((40e-6, 4e-6), 2000) == 0.0


@pytest.mark.parametrize(
    ("sweep", "said"),
    [
        (changed(SMOOTH, wear=None), "wear: none is given"),
        (rough(waves(along=1)), 'use pattern = "local"'),
    ],
)
def test_what_is_hardly_meant_is_doubted(sweep, said):
    named = replace(sweep, source=load_scene("first_try").source)
    found = warnings_of_case(named, estimate_contact(sweep))
    assert any(said in warning_text(one) for one in found)


def test_of_two_moving_bodies_the_velocity_of_the_disk_counts():
    motion = tribo.Motion(slide_roll_ratio=0.5, track_length=0.1)
    sweep = changed(SMOOTH, motion=motion, loads=(300.0, 750.0), velocities=(1.0, 4.0))
    facts, unmoved = estimate_contact(sweep), estimate_contact(changed(sweep, motion=None))
    assert facts.peclet_number.high == pytest.approx(2.5 * unmoved.peclet_number.high)
    columns = run_point(sweep, 750.0, 4.0).columns
    assert facts.contact_width.high == pytest.approx(columns["contact_width"][-1], rel=0.03)
    assert facts.wear_depth.high == pytest.approx(columns["wear_depth_max"][-1], rel=1e-9)

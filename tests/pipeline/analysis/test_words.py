"""Outcomes, errors, entries and tables, as they are said and written."""

import numpy as np
import pytest

import pipeline
from pipeline.analysis.curve import Curve
from pipeline.analysis.rise_error import RiseError, error_of_point, warned_error
from pipeline.analysis.transition import Line, in_words, outcomes, range_of
from pipeline.scene.written import scene_entries
from tests.helpers import synthetic
from tests.helpers.sweeps import with_fields
from tribo import WarningKind


@pytest.mark.parametrize(
    ("limit", "ends", "said"),
    [
        (1200.0, (1.0, 4.0), "mild at every velocity computed (to 2.2 m/s)"),
        (1200.0, (1.2, 2.2), "mild throughout"),
        (600.0, (1.0, 4.0), "severe at every velocity computed (from 1.2 m/s)"),
        (600.0, (1.2, 2.2), "severe throughout"),
    ],
)
def test_where_nothing_crosses_it_is_said_how_far_was_computed(limit, ends, said):
    velocity, rise = np.array([1.2, 2.2]), np.array([700.0, 900.0])
    found = Line(Curve(velocity, rise), limit, ends, velocity)
    assert in_words(outcomes("velocity")[int(found.outcome)], found.computed, "velocity") == said


def test_the_range_of_a_scene_begins_at_its_lowest_velocity_above_0():
    ds = with_fields(synthetic.sweep(), velocities=(0.0, 1.0, 4.0))
    assert range_of(ds, "velocity") == (1.0, 4.0)


def test_an_error_is_said_with_its_parts_and_is_known_only_where_all_are():
    assert RiseError(0.0, 4.0, 3.0).worded == "± 5 K: preset 4 K, warned points 3 K"
    unknown = RiseError(None, 3.0, 0.0)
    assert unknown.total is None
    assert unknown.worded == "not known, since that of interpolation is not known (preset 3 K)"


def test_present_heat_errs_less_in_longer_tests_and_unsized_warnings_are_not_known():
    heat = int(WarningKind.PRESENT_HEAT)
    errors = [warned_error([(heat, duration)]) for duration in (1e-3, 1e-2, 5.0)]
    assert errors == [0.25, 0.11, 0.05]
    assert warned_error([(int(WarningKind.CONTACT_AT_EDGE), 5.0)]) is None
    assert error_of_point(0, 5.0, None).total is None
    assert error_of_point(0, 5.0, 0.08).total == pytest.approx(0.65 * 0.08)


def test_entries_of_a_store_are_those_of_its_scene_in_usual_units():
    entries = scene_entries(synthetic.scene(oil=synthetic.OIL, wear=None))
    expected = {
        "pin.shape": "cylinder",
        "pin.radius": "2 mm",
        "materials.of_pin.hardness": "6.6 GPa",
        "window.pixel_size": "1.3e-05, 1.5e-05 m",
        "window.periodic_y": "yes",
        "loading.rate": "150 N/s",
        "disk.roughness.ra": "0.27 µm",
        "temperature.critical": "418.15 K",
        "oil.kinematic_viscosity": "32, 5 mm²/s",
        "measured.1.load": "750 N",
    }
    assert entries | expected == entries
    assert not [path for path in entries if path.startswith("wear")]


def test_entries_of_several_surfaces_are_without_the_seed_of_one():
    one = pipeline.load_scene("first_try")
    five = pipeline.load_scene("first_try", overrides={"sweep.realizations": 5})
    seed = "disk.roughness.seed"
    assert [seed in scene_entries(sweep) for sweep in (one, five)] == [True, False]
    assert "sweep.realizations" in scene_entries(five)

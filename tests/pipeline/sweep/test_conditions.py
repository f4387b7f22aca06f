"""Conditions of a single test or row, which replace the sweep's."""

from dataclasses import replace

import pytest

from pipeline.sweep.conditions import FIELDS, PATHS, Conditions, changes_of
from tribo import Bulk, Corrections, Friction, Ramp

CURVE = Corrections(friction=Friction(by_velocity=((1.0, 1.2), (4.0, 0.8))), disk_bulk=Bulk(650.0))
BENT = Conditions(0.1, 298.15, 418.15, corrections=CURVE)
WARM = Conditions(0.1, 298.15, 418.15, disk_temperature=313.15)


def test_a_friction_measured_at_a_point_is_that_of_every_velocity():
    here = BENT.replace_friction(0.07)
    assert [here.friction_at(velocity) for velocity in (0.5, 2.0, 8.0)] == [0.07] * 3
    assert here.corrections == replace(CURVE, friction=Friction())
    assert BENT.replace_friction(None) == BENT
    assert BENT.row_conditions({"friction": 0.05}).friction_at(4.0) == 0.05
    assert BENT.row_conditions({"critical_temperature": 400.0}).friction_at(4.0) == pytest.approx(
        0.08
    )


def test_a_row_has_one_bulk_temperature_for_both_bodies():
    row = WARM.row_conditions({"bulk_temperature": 333.15, "critical_temperature": 400.0})
    assert row.coldest_bulk_temperature == row.mean_bulk_temperature == 333.15
    assert row.critical_temperature == 400.0
    assert WARM.row_conditions({"friction": 0.05}).mean_bulk_temperature == pytest.approx(305.65)
    assert WARM.row_conditions({}) == WARM


def test_entries_of_a_scene_are_known_by_the_fields_of_conditions_and_by_names_of_changes():
    assert all(hasattr(BENT, name) for name in FIELDS)
    assert FIELDS["failing_share"] == PATHS["share"] == "temperature.failing_share"
    assert {*FIELDS.values()} == {*PATHS.values()}
    assert changes_of(**dict.fromkeys(PATHS, None)) == {}


def test_corrections_know_the_load_before_and_are_the_same_once_they_do():
    under = BENT.under(Ramp(150.0, 750.0))
    assert under.corrections == CURVE.under(Ramp(150.0, 750.0)) != CURVE
    assert under.under(Ramp(150.0, 750.0)) is under
    assert WARM.under(Ramp(150.0, 750.0)) is WARM

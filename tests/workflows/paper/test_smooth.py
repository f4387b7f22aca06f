"""The smooth contact at the paper's transitions, against numbers worked out by hand."""

import pytest

import pipeline
from workflows.paper.publication import TABLE_4
from workflows.paper.smooth import SmoothContact, load_speed_exponent


@pytest.fixture(scope="module")
def contact():
    sweep = pipeline.load_scene("first_try")
    return SmoothContact(sweep.scene.pin, sweep.scene.disk)


def test_blok_is_far_from_constant_along_the_measured_line(contact):
    unworn = [contact.flash_rise(row.normal_load, row.velocity, row.friction) for row in TABLE_4]
    assert [25 + rise for rise in unworn] == pytest.approx([211, 192, 162, 134], abs=0.8)
    worn = [
        contact.flash_rise(row.normal_load, row.velocity, row.friction, row.measured_width)
        for row in TABLE_4
    ]
    assert [25 + rise for rise in worn] == pytest.approx([143, 123, 99, 72], abs=0.8)


def test_the_smooth_rise_is_constant_where_load_times_velocity_to_the_power_two_thirds_is(contact):
    loads = [750.0, 400.0, 200.0]
    level = contact.flash_rise(600.0, 1.5, 0.1)
    velocities = [(level / contact.flash_rise(load, 1.0, 0.1)) ** 2 for load in loads]
    assert load_speed_exponent(loads, velocities) == pytest.approx(2 / 3)

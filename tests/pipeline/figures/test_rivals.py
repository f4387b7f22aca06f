"""Simple criteria at the paper's transitions, against numbers worked out by hand."""

import pytest

import pipeline
from pipeline.figures.rivals import RIVALS, SmoothContact, load_speed_exponent
from pipeline.store.identity import describe
from tribo import InputError, Motion
from workflows.paper.publication import TABLE_4


@pytest.fixture(scope="module")
def contact():
    return SmoothContact.stored({"scene": describe(pipeline.load_scene("first_try"))})


def at_transitions(of):
    return [of(row) for row in TABLE_4]


def test_blok_is_far_from_constant_along_the_measured_line(contact):
    unworn = at_transitions(
        lambda row: contact.flash_rise(row.normal_load, row.velocity, row.friction)
    )
    assert [25 + rise for rise in unworn] == pytest.approx([211, 192, 162, 134], abs=0.8)
    worn = at_transitions(
        lambda row: contact.flash_rise(
            row.normal_load, row.velocity, row.friction, row.measured_width
        )
    )
    assert [25 + rise for rise in worn] == pytest.approx([143, 123, 99, 72], abs=0.8)


def test_power_and_power_per_worn_area(contact):
    power = at_transitions(
        lambda row: RIVALS["power"].value(contact, row.normal_load, row.velocity, row.friction)
    )
    assert power == pytest.approx([97, 90, 82, 70], abs=0.6)
    areas = at_transitions(lambda row: contact.area(row.normal_load, row.measured_width))
    density = [1e-6 * value / area for value, area in zip(power, areas, strict=True)]
    assert density == pytest.approx([82, 73, 68, 54], abs=0.6)


def test_exponents_of_the_closed_forms(contact):
    """F·V^⅔ keeps Blok's temperature of the unworn line contact, F·V the power."""
    loads = [750.0, 400.0, 200.0]

    def velocity(name, load):
        rival, level = RIVALS[name].value, RIVALS[name].value(contact, 600.0, 1.5, 0.1)
        exponent = {"blok": 0.5}.get(name, 1.0)
        return (level / rival(contact, load, 1.0, 0.1)) ** (1 / exponent)

    for name, n in (("blok", 2 / 3), ("power", 1.0), ("pv", 2.0), ("power-density", 2.0)):
        slope = load_speed_exponent(loads, [velocity(name, load) for load in loads])
        assert slope == pytest.approx(n)


def test_pv_is_power_per_area_over_friction(contact):
    pv, density = (RIVALS[name].value(contact, 600.0, 1.5, 0.1) for name in ("pv", "power-density"))
    assert density / pv == pytest.approx(0.1)


def test_rolling_bodies_share_the_heat(contact):
    rolling = SmoothContact(contact.radius, contact.length, contact.pin, contact.disk,
                            Motion(slide_roll_ratio=0.1))  # fmt: skip
    assert rolling.flash_rise(600, 1.5, 0.1) < 0.3 * contact.flash_rise(600, 1.5, 0.1)


def test_a_ball_has_no_line_contact(contact):
    ball = SmoothContact(contact.radius, None, contact.pin, contact.disk)
    with pytest.raises(InputError, match="needs a cylinder"):
        ball.flash_rise(10.0, 1.0, 0.1)
    assert ball.area(10.0) == pytest.approx(3.14159 * (ball.width(10.0) / 2) ** 2, rel=1e-4)

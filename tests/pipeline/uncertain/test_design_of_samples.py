"""Samples of a design: which of them share contacts, how they are spread, and how many suffice."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from pipeline.sweep.conditions import bulk_entries, changes_of
from pipeline.sweep.leads import Lead, drop_last_digits
from pipeline.sweep.model import Plane, Point
from pipeline.uncertain.samples import Design, Draw, _sum, samples_per_contact
from pipeline.uncertain.unknown import Unknown
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.scenes import STEEL
from tribo import InputError, Wear

RATE = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
HEAT = Unknown("disk.thermal_conductivity", "uniform", (40.0, 50.0), "W m-1 K-1")
LENGTH = Unknown("disk.roughness.correlation_length", "normal", (8e-6, 1e-6), "m")
SEED = Unknown("disk.roughness.seed", "list", (3.0, 5.0, 8.0))
ENDS = 0.5, 4.0
MEDIAN, FACTOR = RATE.parameters


def design(inputs, layers, per_contact):
    return Design(inputs, layers, ENDS, 7, per_contact)


@pytest.mark.parametrize(
    ("layers", "wears", "separable", "count"),
    [
        (("contact", "wear rate"), True, True, 4),
        (("wear rate", "heat"), True, True, 2),
        (("heat",), False, True, 64),
        (("contact",), False, True, 4),
        (("wear rate",), True, False, 1),
    ],
)
def test_samples_share_a_contact_as_far_as_it_depends_on_their_inputs(
    layers, wears, separable, count
):
    assert samples_per_contact(layers, wears, separable) == count


@pytest.mark.parametrize(
    ("inputs", "layers", "per_contact", "count"),
    [
        ((RATE,), ("wear rate",), 2, 64),  # 32 contacts of 2
        ((RATE, HEAT), ("wear rate", "heat"), 2, 64),
        ((RATE, HEAT, HEAT, HEAT), ("wear rate", "heat", "heat", "heat"), 2, 128),  # 16 · 2³
        ((SEED, RATE), ("contact", "wear rate"), 4, 128),  # 32 contacts of 4
        ((replace(SEED, parameters=tuple(map(float, range(20)))),), ("contact",), 4, 160),
        ((LENGTH,), ("contact",), 4, None),  # each has another contact
        ((RATE,), ("wear rate",), 1, None),
        ((HEAT,), ("heat",), 64, 32),  # each is left out alone
    ],
)
def test_so_many_samples_suffice(inputs, layers, per_contact, count):
    assert design(inputs, layers, per_contact).sufficient == count


def test_sums_of_two_even_numbers_are_spread_as_a_trapezium():
    """From 0 to 1 and to 2: F(x) = x²/4 up to 1, x/2 − 1/4 up to 2, and the same from above."""
    shares = np.array([0.0, 0.0625, 0.25, 0.5, 0.75, 0.9375, 1.0])
    expected = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    np.testing.assert_allclose(_sum(shares, 1.0, 2.0), expected, atol=1e-12)
    np.testing.assert_allclose(_sum(shares, 2.0, 1.0), expected, atol=1e-12)


def test_planned_samples_share_a_wear_number_within_the_likely_rates():
    made = design((RATE, HEAT), ("wear rate", "heat"), 2)
    values, velocities = made.draw(64)
    rates, heat = values.T
    numbers = (rates * velocities).reshape(-1, 2)
    np.testing.assert_allclose(numbers[:, 0], numbers[:, 1], rtol=1e-12)
    assert len({*np.round(np.log(numbers[:, 0]), 9)}) == 32
    assert ENDS[0] <= velocities.min() < 0.7
    assert 3.0 < velocities.max() <= ENDS[1]
    scores = np.log(rates / MEDIAN) / np.log(FACTOR)
    assert np.abs(scores).max() <= 2.6 * (1 + 1e-9)
    assert np.abs(scores).max() > 2.0
    # The first of both is in the lower half of the velocities of its contact.
    pairs = np.sort(velocities.reshape(-1, 2), axis=1)
    np.testing.assert_allclose(pairs, velocities.reshape(-1, 2))
    assert (np.diff(pairs, axis=1) > 0).all()
    assert heat.min() > 40.0
    assert heat.max() < 50.0
    assert (heat.reshape(-1, 2)[:, 0] != heat.reshape(-1, 2)[:, 1]).all()
    # Wear numbers are spread as the product of an even velocity and an even rate, in logarithms.
    span, wide = np.log(ENDS[1] / ENDS[0]), 2 * 2.6 * np.log(FACTOR)
    low = np.log(ENDS[0] * MEDIAN) - wide / 2
    shares = (np.arange(32) + 0.5) / 32
    expected = low + _sum(shares, span, wide)
    found = np.sort(np.log(numbers[:, 0]))
    np.testing.assert_allclose(found[2:-2], expected[2:-2], atol=0.12)


def test_drawn_samples_share_contacts_and_a_wear_number_but_no_heat():
    made = design((LENGTH, RATE, HEAT), ("contact", "wear rate", "heat"), 4)
    values, velocities = made.draw(256)
    lengths, rates, heat = (column.reshape(-1, 4) for column in values.T)
    assert (lengths == lengths[:, :1]).all()
    numbers = rates * velocities.reshape(-1, 4)
    np.testing.assert_allclose(numbers, numbers[:, :1] * np.ones(4), rtol=1e-12)
    assert (np.diff(np.sort(heat, axis=1), axis=1) > 0).all()
    assert ENDS[0] <= velocities.min() < 0.6
    assert 3.5 < velocities.max() <= ENDS[1]
    # Others than the first of a contact have a likely rate, and rise by velocity.
    followers = velocities.reshape(-1, 4)[:, 1:]
    assert (np.diff(followers, axis=1) > 0).all()
    scores = np.log(rates[:, 1:] / MEDIAN) / np.log(FACTOR)
    inside = np.abs(np.log(rates[:, 0] / MEDIAN) / np.log(FACTOR)) < 2.6
    assert np.abs(scores[inside]).max() <= 2.6 * (1 + 1e-9)
    # The first is drawn of a wider distribution than the inputs have, by 1.4.
    widths = norm.ppf((np.argsort(np.argsort(lengths[:, 0])) + 0.5) / len(lengths))
    assert np.polyfit(widths, lengths[:, 0], 1)[0] == pytest.approx(1.4e-6, rel=0.05)


def test_without_wear_velocities_fill_the_range_within_each_contact():
    values, velocities = design((HEAT,), ("heat",), 64).draw(128)
    assert values.shape == (128, 1)
    spread = np.log(velocities.reshape(2, 64)[:, 1:] / ENDS[0]) / np.log(ENDS[1] / ENDS[0])
    strata = np.arange(63) / 63
    assert ((spread >= strata) & (spread <= strata + 1 / 63)).all()


@pytest.mark.parametrize("per_contact", [1, 2, 4])
def test_a_longer_draw_begins_with_the_shorter(per_contact):
    made = design((RATE, HEAT), ("wear rate", "heat"), per_contact)
    for short, long in zip(made.draw(24), made.draw(64), strict=True):
        assert (long[:24] == short).all()
    other = replace(made, seed=8)
    assert (other.draw(24)[1] != made.draw(24)[1]).any()


# Inputs at one value


def test_an_input_that_is_fixed_leaves_the_others_and_may_be_fixed_anew():
    critical = Unknown("temperature.critical", "normal", (418.15, 8.0), "K",
                       correlated=(("friction.coefficient", 0.4),))  # fmt: skip
    friction = Unknown("friction.coefficient", "uniform", (0.08, 0.12))
    draw = Draw((friction, critical), design((HEAT,), ("heat",), 64))
    open_paths = ["temperature.critical"]
    fixed = draw.fixed_at({"friction.coefficient": 0.1, "pin.radius": 1.0})
    assert [one.path for one in fixed.unknown] == open_paths
    assert fixed.unknown[0].correlated == ()
    (kept,) = fixed.fixed
    assert (kept.unknown, kept.value) == (friction, 0.1)
    assert [*fixed.open_inputs] == ["friction.coefficient", *open_paths]
    assert Draw.of(fixed.as_dict()) == fixed
    again = fixed.fixed_at({"friction.coefficient": 0.11, "temperature.critical": 400.0})
    assert [one.value for one in again.fixed] == [0.11, 400.0]


# Conditions in their place


@pytest.mark.parametrize(
    ("given", "entries"),
    [
        ({}, {}),
        ({"friction": 0.0}, {"friction": 0.0}),
        ({"share": 0.2}, {"failing_share": 0.2, "criterion": "share"}),
        ({"share": 0.2, "criterion": "mean"}, {"failing_share": 0.2, "criterion": "mean"}),
        ({"criterion": "highest"}, {"criterion": "highest"}),
        ({"critical_temperature": 400.0}, {"critical_temperature": 400.0}),
        ({"bulk_temperature": 300.0}, {"bulk_temperature": 300.0, "disk_temperature": None}),
        ({"bulk_temperature": {"pin": 300.0, "disk": 310.0}},
         {"bulk_temperature": 300.0, "disk_temperature": 310.0}),
        ({"bulk_temperature": {"pin": 300.0, "disk": 300.0}},
         {"bulk_temperature": 300.0, "disk_temperature": None}),
    ],
)  # fmt: skip
def test_what_is_given_changes_those_entries_alone(given, entries):
    assert changes_of(**given) == entries


@pytest.mark.parametrize(("bulks", "named"), [({"pin": 300.0}, "pin"), ({}, "no body")])
def test_bulk_temperatures_of_some_bodies_are_refused(bulks, named):
    with pytest.raises(InputError, match=f"bulk_temperature names {named}; give one"):
        bulk_entries(bulks)


# Contacts that variants share


def test_a_lead_has_the_velocity_of_the_same_wear_number():
    assert Lead(()).leading_velocity(1.2345) == 1.2345
    assert Lead((), 2.0).leading_velocity(1.5) == 3.0
    assert Lead((), 1.1).leading_velocity(3.0) == 3.3  # without the rounding of the last digits
    placed = Lead((), places=(1.5, 0.7))
    assert (placed.leading_velocity(1.5), placed.leading_velocity(1.0)) == (0.7, None)
    assert drop_last_digits(0.1 + 0.2) == 0.3


def test_points_of_rows_with_equal_wear_numbers_share_their_contacts():
    table = rows("case", {"slow": {}, "fast": {"wear.specific_wear_rate": 2.4e-15},
                          "thin": {"pin.radius": 6e-3}})  # fmt: skip
    sweep = tiny.sweep(variants=table)
    slow, fast, thin = table.names
    assert sweep.contact_of(Point(250.0, 1.0, slow)) == (1.0, slow)
    assert sweep.contact_of(Point(250.0, 1.0, fast)) == (2.0, slow)
    assert sweep.contact_of(Point(250.0, 1.0, thin)) == (1.0, thin)
    assert sweep.leads[fast].ratio == pytest.approx(2.0)
    assert sweep.leads[thin] == Lead(thin)
    assert sweep.ramps == 9
    own = tiny.sweep(variants=rows("test", {0: {}, 1: {}}, velocities=[0.5, 1.5]))
    assert own.ramps == 2
    harder = rows("case", {"a": {}, "b": {"disk": replace(STEEL, thermal_conductivity=30.0)}})
    heated = tiny.sweep(variants=harder)
    assert heated.contact_of(Point(250.0, 1.0, harder.names[1])) == (1.0, harder.names[0])
    unworn = tiny.sweep(variants=table, wear=Wear(0.0)).leads
    assert unworn[slow].variant == slow


def test_a_plane_has_a_load_and_a_velocity():
    for loads, velocities in (((), (1.0,)), ((1.0,), ())):
        with pytest.raises(InputError, match="no load or no velocity; give at least one of each"):
            Plane(loads, velocities)


def test_a_hold_replaces_that_of_a_ramp():
    held = tiny.sweep().held(3.0).scene.loading
    assert (held.hold, held.stops) == (3.0, ())

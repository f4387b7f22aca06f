"""Samples of a design: which of them share contacts, how they are spread, and how many suffice."""

from dataclasses import replace

import pytest

from pipeline.sweep.contact_sharing import ContactSource
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points
from pipeline.uncertain.samples import Design
from pipeline.uncertain.unknown import Unknown
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.scenes import STEEL
from tribo import Wear

RATE = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
HEAT = Unknown("disk.thermal_conductivity", "uniform", (40.0, 50.0), "W m-1 K-1")
LENGTH = Unknown("disk.roughness.correlation_length", "normal", (8e-6, 1e-6), "m")
SEED = Unknown("disk.roughness.seed", "list", (3.0, 5.0, 8.0))
ENDS = 0.5, 4.0


def design(inputs, layers, per_contact):
    return Design(inputs, layers, ENDS, 7, per_contact)


@pytest.mark.parametrize(
    ("inputs", "layers", "per_contact", "count"),
    [
        ((RATE,), ("wear rate",), 2, 64),  # 32 contacts of 2
        ((RATE, HEAT), ("wear rate", "heat"), 2, 64),
        ((RATE, HEAT, HEAT, HEAT), ("wear rate", "heat", "heat", "heat"), 2, 128),  # 16 · 2³
        ((SEED, RATE), ("contact", "wear rate"), 4, 128),  # 32 contacts of 4
        ((replace(SEED, parameters=tuple(map(float, range(20)))),), ("contact",), 4, 160),
        ((LENGTH,), ("contact",), 4, None),  # each sample has its own contact
        ((RATE,), ("wear rate",), 1, None),
        ((HEAT,), ("heat",), 64, 32),  # each sample is left out alone
    ],
)
def test_so_many_samples_suffice(inputs, layers, per_contact, count):
    assert design(inputs, layers, per_contact).sufficient == count


@pytest.mark.parametrize("per_contact", [1, 2, 4])
def test_a_longer_draw_begins_with_the_shorter(per_contact):
    made = design((RATE, HEAT), ("wear rate", "heat"), per_contact)
    for short, long in zip(made.draw(24), made.draw(64), strict=True):
        assert (long[:24] == short).all()
    other = replace(made, seed=8)
    assert (other.draw(24)[1] != made.draw(24)[1]).any()


# Contacts that variants share


def test_points_of_rows_with_equal_wear_numbers_share_their_contacts():
    table = rows("case", {"slow": {}, "fast": {"wear.specific_wear_rate": 2.4e-15},
                          "thin": {"pin.radius": 6e-3}})  # fmt: skip
    sweep = tiny.sweep(variants=table)
    slow, fast, thin = table.names
    assert sweep.contact_of(Point(250.0, 1.0, slow)) == (1.0, slow)
    assert sweep.contact_of(Point(250.0, 1.0, fast)) == (2.0, slow)
    assert sweep.contact_of(Point(250.0, 1.0, thin)) == (1.0, thin)
    assert sweep.contact_sources[fast].ratio == pytest.approx(2.0)
    assert sweep.contact_sources[thin] == ContactSource(thin)
    assert len({point[1:] for point in points(sweep)}) == 9
    own = tiny.sweep(variants=rows("test", {0: {}, 1: {}}, velocities=[0.5, 1.5]))
    assert len({point[1:] for point in points(own)}) == 2
    harder = rows("case", {"a": {}, "b": {"disk": replace(STEEL, thermal_conductivity=30.0)}})
    heated = tiny.sweep(variants=harder)
    assert heated.contact_of(Point(250.0, 1.0, harder.names[1])) == (1.0, harder.names[0])
    unworn = tiny.sweep(variants=table, wear=Wear(0.0)).contact_sources
    assert unworn[slow].variant == slow

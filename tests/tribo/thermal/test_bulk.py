"""The bulk behind the contact, held against solutions by hand."""

import math

import numpy as np
import pytest

import tribo
from tribo.thermal import bulk_warming

RAMP = np.array([5.0]), np.array([94.0])
HELD = np.array([5.0, 65.0]), np.array([94.0, 94.0])
ALL_INTO_DISK = (0.0, 1.0)


@pytest.mark.parametrize(("history", "energy"), [(RAMP, 235.0), (HELD, 5875.0)])
def test_capacity_alone_keeps_all_the_energy(history, energy):
    pin, disk = bulk_warming(*history, ALL_INTO_DISK, (None, tribo.Bulk(650.0)))
    assert (pin, disk) == (0.0, pytest.approx(energy / 650.0))


def test_both_bodies_share_the_energy_and_keep_it():
    """The contact conducts half a watt per kelvin from the warmer to the colder one."""
    bulks = tribo.Bulk(40.0), tribo.Bulk(300.0)
    pin, disk = bulk_warming(*HELD, (1.0, 1.0), bulks)
    assert 40.0 * pin + 300.0 * disk == pytest.approx(5875.0)
    late = np.array([5.0, 5.0 + 1e-9, 4000.0]), np.array([94.0, 0.0, 0.0])
    pin, disk = bulk_warming(*late, (1.0, 1.0), bulks)
    assert pin == pytest.approx(disk)
    assert pin == pytest.approx(235.0 / 340.0)


def test_a_constant_heat_warms_as_an_exponential():
    steady = np.array([1e-9, 120.0]), np.array([94.0, 94.0])
    _, disk = bulk_warming(*steady, ALL_INTO_DISK, (None, tribo.Bulk(650.0, 2.0)))
    assert disk == pytest.approx(47.0 * (1 - math.exp(-120.0 * 2.0 / 650.0)), rel=1e-6)


@pytest.mark.parametrize("decay", [9e-5, 2e-4])
def test_a_growing_heat_warms_by_a_ramp_less_what_is_lost(decay):
    """The decay over the ramp is so small that its square counts for nothing here."""
    _, disk = bulk_warming(*RAMP, ALL_INTO_DISK, (None, tribo.Bulk(650.0, decay * 650.0 / 5.0)))
    assert disk == pytest.approx(235.0 / 650.0 * (1 - decay / 3), rel=1e-8)


def test_a_steady_state_is_the_balance_of_heat_in_both_bodies():
    """Two resistances to ground at each side, contact and loss, share the heat."""
    h1, h2, g1, g2 = 0.1, 1.0, 0.3, 2.0
    last = np.array([1.0, 1e6]), np.array([94.0, 94.0])
    bulks = tribo.Bulk(5.0, g1), tribo.Bulk(650.0, g2)
    pin, disk = bulk_warming(*last, (h1, h2), bulks)
    to_ground = [1 / (1 / h + 1 / g) for h, g in ((h1, g1), (h2, g2))]
    contact = 94.0 / sum(to_ground)
    assert pin == pytest.approx(contact * to_ground[0] / g1)
    assert disk == pytest.approx(contact * to_ground[1] / g2)


@pytest.mark.parametrize("sizes", [(0.0, 0.0), (-1.0, 1.0), (1.0, math.nan), (math.inf, 0.0)])
def test_a_bulk_has_a_capacity_or_a_loss(sizes):
    with pytest.raises(tribo.InputError, match="0"):
        tribo.Bulk(*sizes)

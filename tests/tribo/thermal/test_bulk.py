"""The bulk behind the contact, held against solutions by hand."""

from decimal import Decimal, localcontext

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
    """The contact conducts 0.5 W/K from the warmer to the colder body."""
    bulks = tribo.Bulk(40.0), tribo.Bulk(300.0)
    pin, disk = bulk_warming(*HELD, (1.0, 1.0), bulks)
    assert 40.0 * pin + 300.0 * disk == pytest.approx(5875.0)
    late = np.array([5.0, 5.0 + 1e-9, 4000.0]), np.array([94.0, 0.0, 0.0])
    pin, disk = bulk_warming(*late, (1.0, 1.0), bulks)
    assert pin == pytest.approx(disk)
    assert pin == pytest.approx(235.0 / 340.0)


@pytest.mark.parametrize("decay", ["1e-12", "1e-6", "1.9e-5", "2.1e-5", "0.003", "2"])
def test_a_heat_that_grows_and_stays_warms_as_the_equation_of_a_loss_has_it(decay):
    """Compare with C dT/dt = q − GT in fifty digits; q grows for 5 s and is then constant for 60 s.

    Below an exponent of 1e-4 the weights are series without the cubic term; above, a difference
    with as large a rounding error.
    """
    with localcontext(prec=50):
        a, power, capacity = Decimal(decay), Decimal(94), Decimal(650)
        grown = power / 5 / capacity * ((-5 * a).exp() - 1 + 5 * a) / a**2
        held = grown * (-60 * a).exp() + power / capacity * (1 - (-60 * a).exp()) / a
    bulks = None, tribo.Bulk(650.0, 650.0 * float(decay))
    for history, exact in ((RAMP, grown), (HELD, held)):
        _, disk = bulk_warming(*history, ALL_INTO_DISK, bulks)
        assert disk == pytest.approx(float(exact), rel=5e-12)


def test_a_steady_state_is_the_balance_of_heat_in_both_bodies():
    """Each side has two resistances in series to the ground: contact and loss."""
    h1, h2, g1, g2 = 0.1, 1.0, 0.3, 2.0
    last = np.array([1.0, 1e6]), np.array([94.0, 94.0])
    bulks = tribo.Bulk(5.0, g1), tribo.Bulk(650.0, g2)
    pin, disk = bulk_warming(*last, (h1, h2), bulks)
    to_ground = [1 / (1 / h + 1 / g) for h, g in ((h1, g1), (h2, g2))]
    contact = 94.0 / sum(to_ground)
    assert pin == pytest.approx(contact * to_ground[0] / g1)
    assert disk == pytest.approx(contact * to_ground[1] / g2)


def test_a_bulk_resists_by_its_loss_alone_once_it_is_steady():
    assert tribo.Bulk(loss=2.0).resistance == 0.5
    assert tribo.Bulk(capacity=650.0, loss=2.0).resistance == 0.0  # it is not yet steady
    assert tribo.Bulk(loss=2.0).capacity == tribo.Bulk(650.0).loss == 0.0
    assert str(tribo.Bulk(loss=2.0)) == "2 W/K"
    assert str(tribo.Bulk(650.0)) == "650 J/K"
    assert str(tribo.Bulk(650.0, 2.0)) == "650 J/K and 2 W/K"


def test_a_bulk_that_has_no_capacity_stays_as_warm_as_it_starts():
    pin, disk = bulk_warming(*HELD, (1.0, 1.0), (tribo.Bulk(loss=2.0), tribo.Bulk(300.0)))
    alone = bulk_warming(*HELD, (1.0, 1.0), (None, tribo.Bulk(300.0)))
    assert (pin, disk) == (0.0, alone[1])

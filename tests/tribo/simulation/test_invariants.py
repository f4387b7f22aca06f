"""Laws that every result obeys (tribo/simulation/invariants.py), each seen to fail."""

import pickle
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import last, small_scene
from tribo import (
    InvariantError,
    RangeError,
    TriboError,
    Wear,
    simulate,
)
from tribo.simulation import loading_step, temperature
from tribo.simulation.invariants import check_contact, check_heat, check_wear, within_range
from tribo.thermal import partition

PRESSURE = np.array([[1e9, 0.0, 2e9], [0.0, 3e9, 0.5e9]])
CONTACT = {
    "pressure": PRESSURE,
    "normal_load": 6.5e-3,
    "element_area": 1e-12,
    "hardness": 3e9,
    "residual": 1e-7,
    "tolerance": 1e-6,
}
DEPTH = np.array([[1e-9, 0.0], [3e-9, 2e-9]])
WEAR = {"before": DEPTH, "after": 3 * DEPTH, "area": 1e-12, "volume": 18e-21}


def spoiled(field, place, value):
    field = field.copy()
    field[place] = value
    return field


def a_split():
    flux = 1e9 * PRESSURE
    share = 0.3
    pin_flux = flux * np.array([[0.4, 0, 0.2], [0, 0.3, 0.5]])
    pin_flux *= share * flux.sum() / pin_flux.sum()
    split = partition.HeatPartition(1e-9 * flux, pin_flux, share, 7, 1e-8)
    return {"heat_flux": flux, "contact": flux > 0, "split": split, "tolerance": 1e-6}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, None),
        ({"pressure": 1.001 * PRESSURE, "hardness": 4e9}, r"load balance: .* 0\.0065065 N"),
        ({"pressure": spoiled(PRESSURE, (0, 1), 1e3)}, "load balance"),
        ({"hardness": 2.99e9}, r"pressure bounds: .* to 3000000000 Pa"),
        ({"pressure": PRESSURE + np.array([[-1e6, 1e6, 0], [0, 0, 0]])}, None),
        ({"pressure": PRESSURE + np.array([[1e6, -1e6, 0], [0, 0, 0]])}, "pressure bounds: .*-1"),
        ({"pressure": spoiled(PRESSURE, (1, 2), np.nan)}, r"finite: the pressure .* at \(1, 2\)"),
        ({"pressure": spoiled(PRESSURE, (0, 0), np.inf)}, r"finite: the pressure .* at \(0, 0\)"),
        ({"residual": 2e-6}, r"complementarity: .* 2\.00e-06, allowed are 1\.00e-06"),
        ({"residual": np.nan}, "complementarity"),
    ],
)
def test_a_contact_carries_its_load_within_the_bounds(change, said):
    with nullcontext() if said is None else pytest.raises(InvariantError, match=said):
        check_contact(**CONTACT | change)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, None),
        ({"after": 3.001 * DEPTH}, r"wear balance: .* 1\.8006e-20 m³, its law says 1\.8e-20 m³"),
        ({"after": 3 * DEPTH + 2e-9 * np.array([[1, -1], [0, 0]])}, "grown back by 2e-09 m"),
        ({"after": spoiled(3 * DEPTH, (0, 0), np.nan)}, r"finite: the wear depth .* at \(0, 0\)"),
        ({"after": DEPTH}, "wear balance"),
    ],
)
def test_the_pin_loses_what_the_load_wears_off(change, said):
    with nullcontext() if said is None else pytest.raises(InvariantError, match=said):
        check_wear(**WEAR | change)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, None),
        ({"residual": 2e-6}, "common temperature: .* 2.00e-06"),
        ({"residual": np.nan}, "common temperature"),
        ({"pin_share": 0.31}, "heat balance: .* flows into the pin and"),
        ({"pin_share": np.nan}, "heat balance"),
        ({"pin_flux": a_split()["split"].pin_flux + 1.0}, "heat flows at 2 nodes outside"),
        ({"pin_flux": np.full((2, 3), np.nan)}, r"finite: the pin flux .* at \(0, 0\)"),
        ({"rise": spoiled(PRESSURE, (1, 0), np.inf)}, r"finite: the rise .* at \(1, 0\)"),
    ],
)
def test_heat_goes_into_both_bodies_and_nowhere_else(change, said):
    arguments = a_split()
    arguments["split"] = replace(arguments["split"], **change)
    with nullcontext() if said is None else pytest.raises(InvariantError, match=said):
        check_heat(**arguments)


def test_a_solver_that_is_wrong_is_found_out_in_a_simulation(monkeypatch):
    def corrupted(**change):
        def solve(*arguments, **options):
            contact = genuine(*arguments, **options)
            return replace(contact, **{name: f(contact) for name, f in change.items()})

        return solve

    genuine = loading_step.solve_contact
    for change, law in [
        ({"pressure": lambda c: 0.999 * c.pressure}, "load balance"),
        ({"pressure": lambda c: c.pressure[::-1] * 2 - c.pressure}, "pressure bounds"),
        ({"residual": lambda c: 1e-5}, "complementarity"),
        ({"pressure": lambda c: np.where(c.pressure > 0, c.pressure, np.nan)}, "finite"),
    ]:
        monkeypatch.setattr(loading_step, "solve_contact", corrupted(**change))
        with pytest.raises(InvariantError, match=law):
            next(iter(simulate(small_scene(), 300.0, 1.25)))


def test_wear_and_heat_that_are_wrong_are_found_out_in_a_simulation(monkeypatch):
    states = list(simulate(small_scene(), 300.0, 1.25))
    depth = Wear.depth
    with monkeypatch.context() as patch:
        patch.setattr(Wear, "depth", lambda *args: 1.0001 * depth(*args))
        with pytest.raises(InvariantError, match="wear balance"):
            last(small_scene(), 300.0, 1.25)
    divide = temperature.partition_heat

    def leaking(*arguments, **options):
        split = divide(*arguments, **options)
        return replace(split, pin_flux=0.99 * split.pin_flux)

    monkeypatch.setattr(temperature, "partition_heat", leaking)
    with pytest.raises(InvariantError, match="heat balance"):
        temperature.heat(small_scene(), states[-1], 1.25)


def test_numbers_beyond_double_precision_are_named():
    for overflow in (lambda: np.float64(1e200) ** 2, lambda: 10.0**400, lambda: 1.0 / 0.0):
        with pytest.raises(RangeError, match=r"the step: .*too large or too small"):  # noqa: SIM117
            with within_range("the step"):
                overflow()


def test_what_is_raised_crosses_processes():
    for kind in (InvariantError, RangeError):
        error = pickle.loads(pickle.dumps(kind("load balance: 1 N")))
        assert isinstance(error, TriboError)
        assert str(error) == "load balance: 1 N"

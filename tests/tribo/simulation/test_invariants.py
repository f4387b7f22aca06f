"""Laws that every result obeys (tribo/simulation/invariants.py), each seen to fail."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.kept import assert_as_kept
from tests.helpers.scenes import last, small_scene
from tribo import InvariantError, TriboError, Wear, simulate
from tribo.errors import RangeError
from tribo.simulation import loading_step, temperature
from tribo.simulation.invariants import check_wear, guard_range


def test_a_solver_that_is_wrong_is_found_out_by_laws_whose_words_are_kept(monkeypatch):
    def corrupted(**change):
        def solve(*arguments, **options):
            contact = genuine(*arguments, **options)
            return replace(contact, **{name: f(contact) for name, f in change.items()})

        return solve

    genuine, texts = loading_step.solve_contact, {}
    for change, law in [
        ({"pressure": lambda c: 0.999 * c.pressure}, "load balance"),
        ({"pressure": lambda c: c.pressure[::-1] * 2 - c.pressure}, "pressure bounds"),
        ({"residual": lambda c: 1e-5}, "complementarity"),
        ({"pressure": lambda c: np.where(c.pressure > 0, c.pressure, np.nan)}, "finite"),
    ]:
        monkeypatch.setattr(loading_step, "solve_contact", corrupted(**change))
        with pytest.raises(InvariantError, match=law) as caught:
            next(iter(simulate(small_scene(), 300.0, 1.25)))
        texts[law] = str(caught.value)
    assert_as_kept("laws_of_contact", texts)


def test_wear_and_heat_that_are_wrong_are_found_out_by_laws_whose_words_are_kept(monkeypatch):
    texts, states = {}, list(simulate(small_scene(), 300.0, 1.25))
    depth = Wear.depth
    with monkeypatch.context() as patch:
        patch.setattr(Wear, "depth", lambda *args: 1.0001 * depth(*args))
        with pytest.raises(InvariantError, match="wear balance") as caught:
            last(small_scene(), 300.0, 1.25)
        texts["wear balance"] = str(caught.value)
    divide = temperature.partition_heat
    for change, law in [
        ({"pin_flux": lambda split: 0.99 * split.pin_flux}, "heat balance"),
        ({"pin_flux": lambda split: split.pin_flux + 1.0}, "nodes outside"),
        ({"residual": lambda split: 1.0}, "common temperature"),
        ({"rise": lambda split: np.inf * split.rise.clip(1)}, "finite: the rise"),
        ({"pin_flux": lambda split: np.nan * split.pin_flux}, "finite: the pin flux"),
        ({"rise": lambda split: split.rise.clip(1e307)}, "in its sum"),
    ]:

        def wrong(*arguments, change=change, **options):
            split = divide(*arguments, **options)
            return replace(split, **{name: f(split) for name, f in change.items()})

        monkeypatch.setattr(temperature, "partition_heat", wrong)
        with pytest.raises(InvariantError, match=law) as caught:
            temperature.heat(small_scene(), states[-1], 1.25)
        texts[law] = str(caught.value)
    assert_as_kept("laws_of_wear_and_heat", texts)


def test_a_pin_that_grows_back_anywhere_is_found_out_though_its_volume_is_right():
    before = np.array([[1e-9, 3e-9]])
    check_wear(before, np.array([[1e-9, 5e-9]]), area=1e-12, volume=6e-21)
    words = "^wear balance: the pin has grown back by 1e-10 m somewhere$"
    with pytest.raises(InvariantError, match=words):
        check_wear(before, np.array([[0.9e-9, 5.1e-9]]), area=1e-12, volume=6e-21)


def test_numbers_beyond_double_precision_are_named():
    for overflow in (lambda: np.float64(1e200) ** 2, lambda: 10.0**400, lambda: 1.0 / 0.0):
        words = "a value of the scene is too large or too small for double precision"
        with pytest.raises(RangeError, match=f"the step: .+; {words}$"), guard_range("the step"):
            overflow()


def test_what_is_raised_crosses_processes():
    for kind in (InvariantError, RangeError):
        error = pickle.loads(pickle.dumps(kind("load balance: 1 N")))
        assert isinstance(error, TriboError)
        assert str(error) == "load balance: 1 N"

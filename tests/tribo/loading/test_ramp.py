import math

import numpy as np
import pytest

from tribo import Fidelity, Ramp
from tribo.constants import HOLD_GROWTH

RAMP = Ramp(rate=150.0, reference_load=750.0)


def test_trunk_is_the_same_for_every_load():
    trunk = [s for s in RAMP.load_steps(750.0, 100) if s.on_trunk]
    for load in (200.0, 433.3, 600.0):
        load_steps = list(RAMP.load_steps(load, 100))
        assert load_steps[:-1] == trunk[: len(load_steps) - 1]
        assert (load_steps[-1].normal_load, load_steps[-1].index) == (load, len(load_steps))
        assert load_steps[-1].time == load / 150.0


def test_a_load_takes_a_quarter_of_the_increments_at_least_whatever_the_reference_load():
    for load in (300.0, 187.5, 187.0, 10.0, 1e-3, 1e-300):
        load_steps = list(RAMP.load_steps(load, 100))
        assert 25 <= len(load_steps) <= max(50, math.ceil(load / 7.5))
        *trunk, last = load_steps
        steps = np.diff([0.0, *(step.normal_load for step in trunk), last.normal_load])
        increment = RAMP.increment(load, 100)
        assert steps[:-1] == pytest.approx(increment)
        assert 0 < steps[-1] <= increment * (1 + 1e-9)
    # Loads with the same increment share a ramp, whatever other loads the diagram has.
    assert RAMP.increment(187.5, 100) == RAMP.increment(750.0, 100) == 7.5
    assert RAMP.increment(100.0, 100) == RAMP.increment(187.0, 100) == 3.75


def test_a_hold_follows_the_point_and_is_no_part_of_the_trunk():
    with_hold = Ramp(150.0, 750.0, hold=4.0)
    for load in (200.0, 600.0):
        plain, load_steps = list(RAMP.load_steps(load, 5)), list(with_hold.load_steps(load, 5))
        assert load_steps[: len(plain)] == plain
        hold = load_steps[len(plain) :]
        assert {s.normal_load for s in hold} == {load}
        held_for = np.array([s.time - load / 150 for s in hold])
        assert held_for[-1] == pytest.approx(4.0)
        assert [s.impulse for s in hold] == pytest.approx(plain[-1].impulse + held_for * load)
        assert [s.index - plain[-1].index for s in hold] == [*range(1, len(hold) + 1)]
        assert all(s.holding and not s.on_trunk for s in hold)
        assert not any(s.holding for s in plain)
    assert Fidelity(increments=99, fewest_elements=1).hold_increments == 99
    *_, end = Ramp(150.0, 750.0, hold=1e-9).load_steps(600.0, 100)
    assert (end.holding, end.index, end.time) == (True, 81, pytest.approx(4.0))


@pytest.mark.parametrize("increments", [25, 33, 100])
def test_a_hold_in_which_the_impulse_grows_by_a_full_step_has_no_further_step(increments):
    hold = 2.0 * math.expm1(HOLD_GROWTH)  # the ramp has the impulse of 2 s at 600 N
    hold_steps = [s for s in Ramp(150.0, 750.0, hold).load_steps(600.0, increments) if s.holding]
    assert len(hold_steps) == increments


@pytest.mark.parametrize("hold", [4.0, 60.0, 1e6])
@pytest.mark.parametrize("increments", [5, 25, 100])
def test_each_step_of_a_hold_has_the_same_share_of_the_impulse_so_far(hold, increments):
    *_, reached = Ramp(150.0, 750.0).load_steps(600.0, increments)
    hold_steps = [s for s in Ramp(150.0, 750.0, hold).load_steps(600.0, increments) if s.holding]
    impulses = np.array([reached.impulse, *(load_step.impulse for load_step in hold_steps)])
    assert impulses[1:] / impulses[:-1] == pytest.approx((1 + hold / 2) ** (1 / len(hold_steps)))
    assert len(hold_steps) <= 1 + increments * math.log1p(hold / 2) / 4
    assert hold_steps[-1].time == pytest.approx(4.0 + hold)

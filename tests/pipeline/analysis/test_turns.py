"""Where a share of the members of a field turns (pipeline/analysis/transition.py)."""

import math

import numpy as np
import pytest

from pipeline.analysis.transition import CROSSES, MILD, UNKNOWN, Turns


def turns(*members, outcome=CROSSES):
    """Of members, each the places at which it turns, from mild wear on unless it begins with 0."""
    weight = 1 / len(members)
    begins = [member[:1] == (0.0,) for member in members]
    steps = [
        weight if number % 2 == 0 else -weight
        for member in members
        for number, place in enumerate(member)
        if place
    ]
    places = [place for member in members for place in member if place]
    codes = np.full(len(members), outcome)
    return Turns(codes, (0.1, 9.0), 0, np.array(places), np.array(steps), weight * sum(begins))


@pytest.mark.parametrize("count", [1, 2, 3, 8, 21])
@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_of_members_that_turn_once_these_are_their_quantiles(count, share):
    places = np.random.default_rng(count).uniform(1.0, 3.0, count)
    found, begins = turns(*[(place,) for place in places]).shared(share)
    assert not begins
    assert found == pytest.approx([np.quantile(places, share, method="hazen")], rel=1e-9)


def test_half_of_members_unlike_each_other_is_severe_where_counting_finds_it():
    chance = np.random.default_rng(5)
    members = [
        (0.0,) * (number % 3 == 0) + tuple(np.sort(chance.uniform(1.0, 9.0, 3 + number % 2)))
        for number in range(41)
    ]
    found, begins = turns(*members).shared()
    between = np.linspace(0.5, 9.5, 4001)
    severe = sum(
        np.searchsorted([place for place in member if place], between) % 2 != (member[0] == 0.0)
        for member in members
    )
    counted = severe > len(members) / 2
    told = np.searchsorted(found, between) % 2 != begins
    # A share changes steadily from one member to the next, so that counts beside half may differ.
    near = np.abs(severe - len(members) / 2) <= 1
    assert (told == counted)[~near].all()
    assert near.mean() < 0.5


def test_a_place_at_which_exactly_half_is_severe_beyond_or_before_is_no_turn():
    assert turns((2.0,), ()).shared() == ((), False)
    assert turns((2.0,), (0.0,)).shared() == ((), True)
    assert turns((2.0, 4.0), (3.0, 5.0), (9.0,)).shared()[0] == pytest.approx((3.0, 4.0))


def test_other_shares_are_those_of_the_turn_that_half_of_the_members_make_nearest():
    one = turns((1.0, 4.0), (1.2, 4.4), (1.1, 4.2))
    for here, middle, ends in ((1.5, 1.1, (1.0, 1.2)), (3.0, 4.2, (4.4, 4.0))):
        assert one.nearest(here) == pytest.approx(middle)
        assert [one.nearest(here, share) for share in (0.05, 0.95)] == pytest.approx(ends)


def test_a_share_that_never_turns_is_severe_from_0_on_or_nowhere():
    one = turns((2.0,), (2.2,), (), (0.0,), (2.1,))
    assert one.nearest(1.0, 0.05) == 0.0
    assert one.nearest(1.0, 0.95) == math.inf
    assert turns((), outcome=MILD).nearest(1.0) == math.inf
    assert math.isnan(turns((), outcome=UNKNOWN).nearest(1.0))


def test_other_shares_end_at_the_turns_of_the_half_beside_the_nearest():
    # A quarter stays severe from 1 on; all the others are mild between 2 and 4.
    one = turns((1.0,), (1.1, 2.0, 4.0), (1.2, 2.1, 4.1), (1.3, 2.2, 4.2))
    assert len(one.shared()[0]) == 3
    for here, ends in ((1.0, (1.0, 1.3)), (2.1, (math.inf, 2.0)), (4.1, (0.0, 4.2))):
        found = [one.nearest(here, share) for share in (0.05, 0.95)]
        assert found == pytest.approx(ends, rel=0.03)
        assert min(found) <= one.nearest(here) <= max(found)

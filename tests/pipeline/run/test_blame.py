"""Which points are called failed when workers die (pipeline/run/blame.py)."""

import pytest

from pipeline.run.blame import TRIALS, Suspects
from pipeline.sweep.model import Point

ONE, OTHER, THIRD = (Point(load, 1.0) for load in (200.0, 400.0, 600.0))


def lost(point, times, alone=True, suspects=None):
    suspects = suspects or Suspects()
    for _ in range(times):
        suspects = suspects.after_loss(point, alone)
    return suspects


def test_a_point_fails_when_it_was_lost_alone_so_often_and_not_before():
    assert lost(ONE, TRIALS - 1).failed == []
    assert lost(ONE, TRIALS).failed == [ONE]


@pytest.mark.parametrize("times", [1, 10 * TRIALS])
def test_a_point_that_was_lost_with_others_is_tried_alone_and_never_failed(times):
    suspects = lost(ONE, times, alone=False)
    assert suspects.to_try == [ONE]
    assert suspects.failed == []
    assert lost(ONE, TRIALS - 1, suspects=suspects).failed == []


def test_points_that_were_lost_least_often_are_tried_first():
    suspects = lost(ONE, 2)
    suspects = lost(OTHER, 3, suspects=suspects)
    suspects = lost(THIRD, 1, alone=False, suspects=suspects)
    assert suspects.to_try == [THIRD, ONE, OTHER]


def test_a_point_that_is_cleared_begins_anew_and_the_others_stay():
    suspects = lost(OTHER, TRIALS, suspects=lost(ONE, TRIALS - 1)).without([ONE])
    assert suspects.to_try == suspects.failed == [OTHER]
    assert lost(ONE, 1, suspects=suspects).failed == [OTHER]


def test_what_is_known_stays_as_it_was():
    before = lost(ONE, 1)
    before.after_loss(ONE, alone=True)
    before.without([ONE])
    assert dict(before.losses) == {ONE: 1}

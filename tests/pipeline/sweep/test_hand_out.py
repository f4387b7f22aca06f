"""Who computes which task next (pipeline/sweep/hand_out.py)."""

from collections import Counter

import pytest

from pipeline.sweep.hand_out import HandOut, makespan
from pipeline.sweep.model import Point
from pipeline.sweep.plan import Task


def grid(velocities, loads):
    return [
        Task((Point(float(load), float(velocity)),), ((), float(velocity), 1.0))
        for velocity in range(1, velocities + 1)
        for load in range(1, loads + 1)
    ]


def taken(waiting, workers):
    """Loads and velocities that workers take one after the other."""
    return [waiting.take(worker).points[0][:2] for worker in workers]


def test_a_worker_goes_on_with_its_ramp_then_begins_one_then_joins_the_longest():
    waiting = HandOut(grid(3, 3))
    assert taken(waiting, "aab") == [(1, 1), (2, 1), (1, 2)]
    assert taken(waiting, "aaa") == [(3, 1), (1, 3), (2, 3)]
    assert taken(waiting, "c") == [(2, 2)]  # none is new: b has two loads left, a one
    assert taken(waiting, "bb") == [(3, 2), (3, 3)]
    assert not waiting


def test_a_task_that_was_not_computed_comes_next_for_whoever_has_its_ramp():
    waiting = HandOut(grid(2, 2))
    first = waiting.take("a")
    waiting.take("b")
    waiting.put_back(first)
    assert waiting.take("a") is first


@pytest.mark.parametrize(("velocities", "workers"), [(1, 3), (4, 3), (4, 8), (7, 2)])
def test_each_task_is_handed_out_once_and_nobody_idles_while_any_waits(velocities, workers):
    seen, has = Counter(), []

    def cost(task, known):
        seen[task.points] += 1
        has.append(id(known))
        return 1.0

    tasks = grid(velocities, 12)
    wall, total = makespan(tasks, workers, cost)
    assert seen == {task.points: 1 for task in tasks}
    assert (wall, total) == (-(-len(tasks) // workers), len(tasks))
    assert len({*has}) == workers


def test_eight_workers_share_four_velocities():
    """A trunk of 25 increments at 0.0092 s and ends of 0.05 s: 6.3 times as fast as one worker."""

    def cost(task, known):
        reach = round(25 * task.points[0].load / 12)
        new = max(0, reach - known.get(task.ramp, 0))
        known[task.ramp] = max(reach, known.get(task.ramp, 0))
        return 0.05 + 0.0092 * new

    alone, shared = (makespan(grid(4, 12), workers, cost)[0] for workers in (1, 8))
    assert alone / shared == pytest.approx(6.3, abs=0.1)

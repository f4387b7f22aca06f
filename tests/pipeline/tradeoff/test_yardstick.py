"""The rules by which a fidelity is judged and picked, on a rise that is known in closed form."""

from dataclasses import replace

import pytest

from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Point
from pipeline.tradeoff import choose
from pipeline.tradeoff import probe as of_probe
from pipeline.tradeoff.choose import _first_within
from pipeline.tradeoff.probe import (
    YARDSTICK,
    OwnError,
    Probe,
    Reading,
    Yardstick,
    measured,
    own_error,
)
from tests.helpers.accuracy_scenes import SCENES
from tests.helpers.scenes import STEEL
from tribo import Ball, ConvergenceError, Grid, Wear

VELOCITIES = (1.0, 2.0, 4.0, 8.0)
SWEEP = SCENES["no wear"].changed(velocities=VELOCITIES, wear=Wear(1e-15))
LIMIT = rise_limit(SWEEP.conditions)


class Law:
    """A probe by a power law of the velocity, with errors of the steps and of the present heat."""

    def __init__(self, reference_velocity=3.0, exponent=0.5, of_steps=0.0, of_heat=0.0, nodes=2000):
        self.velocity, self.exponent, self.nodes = reference_velocity, exponent, nodes
        self.of_steps, self.of_heat = of_steps, of_heat
        self.asked = []

    def rise(self, fidelity, velocity):
        error = self.of_steps * (YARDSTICK.increments / fidelity.increments) ** 2
        error += self.of_heat * (fidelity.heat_model == "elapsed")
        return LIMIT * (velocity / self.velocity) ** self.exponent * (1 + error)

    def __call__(self, sweep, fidelity, points):
        self.asked.append((fidelity, tuple(points)))
        readings = tuple(
            Reading(self.rise(fidelity, point.velocity), 0.1, 1e-4, self.nodes, 0.1, 1e9, 0.0)
            for point in points
        )
        return Probe(fidelity, readings, 0.0, 10, 100.0 * len(points))


def test_the_yardstick_reads_each_point_and_once_more_on_larger_elements(monkeypatch):
    law = Law(nodes=700)
    monkeypatch.setattr(of_probe, "probe", law)
    points, messages = tuple(Point(load, 3.0) for load in (100.0, 200.0)), []
    result = measured(SWEEP, points, (0.5, 1.0), messages.append)
    assert result.points == points
    assert result.fewest_nodes == 700
    assert (result.work, result.own_work) == (400.0, 200.0)
    assert result.coarser == 0.0
    assert [fidelity.pixels_per_element for fidelity, _ in law.asked] == [1, 1, 2]
    assert len(messages) == 2
    assert "nearly exact steps at 100 N, 3 m/s" in messages[0]
    warm = Law(of_heat=0.01)
    errors = result.errors(warm(SWEEP, YARDSTICK, result.points))
    assert errors == pytest.approx([1.01**-2 - 1, 1.01**-1 - 1])


def test_its_own_error_is_half_of_what_half_the_steps_move_and_a_fifth_more(monkeypatch):
    law = Law(of_steps=0.01)
    monkeypatch.setattr(of_probe, "probe", law)
    points, exponents = [Point(load, 3.0) for load in (100.0, 200.0, 300.0)], [0.5, 1.0, 1.0]
    readings = law(SWEEP, YARDSTICK, points).readings
    error = own_error(SWEEP, points, exponents, readings)
    rises = (law.rise(YARDSTICK, 3.0), law.rise(replace(YARDSTICK, increments=12), 3.0))
    moved = abs(boundary_velocity_error(*rises, 0.5))
    assert error.steps == pytest.approx(1.2 * 0.5 * moved)
    assert error.heat_model == 0.0
    assert error.work == 300.0 + 200.0 + 200.0
    assert own_error(SWEEP.changed(wear=None), points, exponents, readings).steps == 0.0


def test_under_a_ball_all_of_what_half_the_steps_move_is_left_to_any_number(monkeypatch):
    law = Law(of_steps=0.01)
    monkeypatch.setattr(of_probe, "probe", law)
    ball = SWEEP.changed(pin=Ball(5e-3, STEEL), pixels=Grid((96, 96), (1e-6, 1e-6), (False, False)))
    points = [Point(300.0, 3.0)]
    readings = law(ball, YARDSTICK, points).readings
    line, point = (own_error(sweep, points, [1.0], readings) for sweep in (SWEEP, ball))
    assert point.steps == pytest.approx(2 * line.steps)
    finer = replace(YARDSTICK, increments=100)
    assert point.of(finer) == point.of(YARDSTICK)
    assert line.of(finer) < line.of(YARDSTICK)


def test_the_error_of_the_present_heat_is_measured_at_the_lowest_and_the_highest_load(monkeypatch):
    law = Law(of_heat=0.02)
    monkeypatch.setattr(of_probe, "probe", law)
    points = [Point(load, 3.0) for load in (200.0, 100.0, 300.0)]
    readings = (None,) * 3
    error = own_error(SWEEP.changed(wear=None), points, [0.1, 0.5, 1.0], readings)
    assert error.heat_model == pytest.approx(1.2 * abs(boundary_velocity_error(1.02, 1.0, 0.5)))
    assert [fidelity.heat_model for fidelity, _ in law.asked] == ["elapsed", "history"]
    for fidelity, asked in law.asked:
        assert (fidelity.increments, fidelity.pixels_per_element) == (50, 1)
        assert asked == (points[1], points[2])
    law.asked.clear()
    large = SWEEP.changed(wear=None, pixels=Grid((200, 102), (1e-6, 1e-6)))
    own_error(large, points[:1], [0.5], readings[:1])
    assert [fidelity.pixels_per_element for fidelity, _ in law.asked] == [2, 2]
    fidelity = replace(SWEEP.scene.fidelity, heat_model="history", history_coarsening=1)
    remembering = SWEEP.changed(wear=None, fidelity=fidelity)
    assert own_error(remembering, points, [0.5] * 3, readings).work == 0.0


def test_of_another_fidelity_steps_count_in_proportion_and_heat_where_it_is_the_present():
    error = OwnError(steps=0.01, heat_model=0.03, work=0.0)
    history = replace(YARDSTICK, heat_model="history")
    assert error.of(YARDSTICK) == pytest.approx(0.01 + 2e-3 + 0.03)
    assert error.of(history) == pytest.approx(0.01 + 2e-3)
    assert error.of(replace(history, increments=100)) == pytest.approx(0.0025 + 2e-3)


def judged(
    monkeypatch, accuracy, errors, heat_model=0.0, nodes=2000, loads=SWEEP.plane.loads, steps=0.001
):
    """Choice among fidelities of some errors, one after the other, and a work of 50."""
    points = tuple(Point(load, 3.0) for load in loads for _ in range(2))
    rises = iter(errors)

    def probe(sweep, fidelity, points):
        error = next(rises)
        if error is None:
            raise ConvergenceError("no", solution=None)
        reading = Reading(LIMIT * (1 + error), 0.1, 1e-4, nodes, 0.1, 1e9, 0.0)
        return Probe(fidelity, (reading,) * len(points), 0.0, 10, 50.0)

    readings = (Reading(LIMIT, 0.1, 1e-4, nodes, 0.1, 1e9, 0.0),) * len(points)
    exact = Yardstick(points, (1.0,) * len(points), readings, 1000.0, 400.0)
    error = OwnError(steps, heat_model, 30.0)
    monkeypatch.setattr(choose, "probe", probe)
    return _first_within(SWEEP, accuracy, exact, error, True, lambda _: None)


def test_the_first_choice_within_the_accuracy_is_taken_with_all_margins(monkeypatch):
    choice = judged(monkeypatch, 0.05, [0.09, None, 0.03])
    of_yardstick = 0.001 + 2e-3 + 0.1 / 2000
    expected = [1.1 * (1 - 1 / 1.09) + of_yardstick, 1.1 * (1 - 1 / 1.03) + of_yardstick]
    assert [trial.error for trial in choice.trials] == pytest.approx(expected)
    assert choice.trials[0].name == "draft, solved tightly"
    assert choice.name == choice.trials[-1].name == "standard, solved tightly"
    assert (choice.work, choice.saving) == (1000.0 + 30.0 + 100.0, 8.0)
    assert len(choice.points) == 2 * len(SWEEP.plane.loads)


def test_where_none_is_within_it_the_reference_is_taken(monkeypatch):
    choice = judged(monkeypatch, 0.01, [0.09] * 20)
    assert choice.name == "reference"
    assert choice.error == pytest.approx(0.001 / 4 + 2e-3)
    assert choice.saving == pytest.approx(0.25)


def test_where_not_even_the_finest_is_within_it_the_cheapest_as_good_is_taken(monkeypatch):
    choice = judged(monkeypatch, 1e-4, [0.09, 1e-5, *[0.09] * 20], steps=0.0)
    assert choice.name == "draft, finer elements, solved tightly"
    assert "more than asked for" in str(choice)
    assert "(draft, solved tightly" in str(choice)


@pytest.mark.parametrize(("heat_model", "taken"), [(0.034, "elapsed"), (0.036, "history")])
def test_all_heat_is_taken_where_the_present_errs_by_more_than_seven_tenths(
    heat_model, taken, monkeypatch
):
    choice = judged(monkeypatch, 0.05, [0.001] * 20, heat_model)
    assert choice.fidelity.heat_model == taken
    assert choice.error == pytest.approx(
        1.1 * (1 - 1 / 1.001) + 0.001 + 2e-3 + 0.1 / 2000 + heat_model * (taken == "elapsed")
    )
    assert choice.fidelity.increments == (50 if taken == "history" else 5)
    assert choice.fidelity.history_coarsening == (1 if taken == "history" else 4)

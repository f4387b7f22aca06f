"""Speed against accuracy where the readings of every probe are given: numbers computed by hand."""

import math
from dataclasses import replace

import pytest

from pipeline.sweep.model import Point
from pipeline.tradeoff import probe as probe_module
from pipeline.tradeoff import trade as tradeoff
from pipeline.tradeoff.probe import (
    Probe,
    Reading,
    Target,
    near_the_boundary,
    probe,
    velocity_errors,
)
from pipeline.tradeoff.trade import Choice, Trade, trade
from tests.helpers import tiny
from tests.helpers.accuracy_scenes import SCENES
from tests.helpers.entries import changed
from tribo import PRESETS, ConvergenceError, Fidelity, Grid

SCENE = changed(SCENES["low loads"], pixels=Grid((96, 48), (4e-6, 4e-6)))
TRUE = Reading(rise=1000.0, contact_nodes=5000)


def choice(name, seconds, *errors):
    largest = max(map(abs, errors))
    return Choice(name, PRESETS["fine"], errors, largest, largest, seconds)


def traded(*choices, **values):
    points = Point(60.0, 1.23456), Point(180.0, 2.0)
    return Trade("A scene", points, choices, **values)


def test_the_front_has_each_choice_that_no_cheaper_one_equals():
    exact = choice("reference", 100.0, 0.0)
    dear, same, best = choice("b", 20.0, 0.05), choice("c", 30.0, -0.05), choice("d", 30.0, 0.01)
    table = traded(choice("a", 10.0, 0.05), dear, same, best, exact)
    assert [one.name for one in table.front] == ["a", "d", "reference"]
    assert table.reference is exact
    found = [table.cheapest(error).name for error in (0.05, 0.049, 0.01, 0.0099)]
    assert found == ["a", "d", "d", "reference"]


def test_it_says_the_points_and_the_cheapest_within_each_error():
    table = traded(
        choice("draft", 10.0, -0.03),
        choice("fine", 55.0, 0.004),
        choice("reference", 100.0, 0.0),
        not_converged=("standard: why",),
    )
    said = str(table).splitlines()
    assert said[:3] == [
        "A scene: speed against accuracy at",
        "  60 N 1.23 m/s, 180 N 2 m/s",
        "",
    ]
    assert said[-7:] == [
        "",
        "--accuracy 5%: draft",
        "--accuracy 3%: draft",
        "--accuracy 2%: fine",
        "--accuracy 1%: fine",
        "--accuracy 0.5%: fine",
        "no result: standard: why",
    ]
    assert [one.name for one in table.front] == ["draft", "fine", "reference"]


class Rig:
    """Probes of which one reads the given value, and all others the truth."""

    def __init__(self):
        self.tried, self.places, self.off = [], [], {}

    def near_the_boundary(self, sweep, places):
        self.places = [*places]
        return tuple(Point(place.load, 1.0) for place in places), (0.5,) * len(places)

    def probe(self, sweep, fidelity, points):
        self.tried.append(fidelity)
        if fidelity.increments == PRESETS["standard"].increments:
            raise ConvergenceError("the contact did not converge", None)
        is_draft = fidelity.increments == PRESETS["draft"].increments
        read = [replace(TRUE, **self.off) if is_draft else TRUE] + [TRUE] * (len(points) - 1)
        return Probe(fidelity, tuple(read), 2.0 if is_draft else 10.0)


@pytest.fixture
def rig(monkeypatch):
    rig = Rig()
    for name in ("near_the_boundary", "probe"):
        monkeypatch.setattr(tradeoff, name, getattr(rig, name))
    return rig


def test_errors_are_against_the_reference_and_the_largest_of_the_points(rig):
    rig.off = {"rise": 990.0}
    scene = changed(SCENE, fidelity=Fidelity(increments=77))
    table = trade(scene, ("draft", "standard"), loads=["60 N", 180.0])
    assert rig.places == [Target(60.0), Target(180.0)]
    names = [one.name for one in table.choices]
    assert names == ["draft", "the scene's own fidelity", "reference"]
    draft, own, exact = table.choices
    assert draft.velocity_errors == pytest.approx(((1000 / 990) ** 2 - 1, 0.0), rel=1e-9)
    assert draft.velocity_error == pytest.approx(0.020304, rel=1e-4)
    assert (draft.seconds, draft.share_of_fine) == (2.0, None)
    assert (exact.seconds, exact.velocity_error) == (10.0, 0.0)
    assert own.fidelity == scene.scene.fidelity
    assert table.not_converged == ("standard: the contact did not converge",)
    assert rig.tried[0] == PRESETS["reference"]


def test_times_are_those_over_the_time_of_fine(rig):
    table = trade(changed(SCENE, preset="fine"), ("draft", "fine"), loads=["60 N"])
    shares = {one.name: one.share_of_fine for one in table.choices}
    assert shares == {"draft": pytest.approx(0.2), "fine": 1.0, "reference": 1.0}
    assert list(table.table.columns) == [
        "name", "velocity error [%]", "error at any load [%]", "seconds [s]", "share of fine",
    ]  # fmt: skip


def test_four_loads_and_all_usual_presets_are_taken_where_nothing_is_told(rig):
    said = []
    loads = tuple(float(load) for load in range(60, 190, 20))  # seven
    trade(changed(SCENE, loads=loads, preset="fine"), progress=said.append)
    assert [place.load for place in rig.places] == [60.0, 100.0, 140.0, 180.0]
    assert said[0].words.startswith("4 choices at 4 places")
    assert [(one.words, one.done, one.total) for one in said[1:]] == [
        ("1 of 4: reference", 0, 4),
        ("2 of 4: draft", 1, 4),
        ("3 of 4: standard", 2, 4),
        ("4 of 4: fine", 3, 4),
    ]


def test_a_fidelity_that_has_two_names_is_measured_once_by_the_first(rig):
    scene = changed(SCENE, fidelity=PRESETS["fine"], preset=None)
    table = trade(scene, ("fine", "draft", "reference"))
    assert [one.name for one in table.choices] == ["draft", "fine", "reference"]


class Runs:
    """Simulations in closed form, of which each call is noted."""

    def __init__(self, rise):
        self.rise, self.calls = rise, []

    def run(self, sweep, load, velocity, trunks=None):
        self.calls.append((sweep.scene.fidelity, load, velocity))
        return load, velocity, sweep.scene.fidelity

    def reading(self, sweep, scene, state):
        return replace(TRUE, rise=self.rise(*state), contact_nodes=int(10 * state[0]))


@pytest.fixture
def runs(monkeypatch):
    def set_up(rise):
        runs = Runs(rise)
        monkeypatch.setattr(probe_module, "_run", runs.run)
        monkeypatch.setattr(probe_module, "_reading", runs.reading)
        return runs

    return set_up


@pytest.mark.parametrize(
    ("exponent", "found", "at"),
    [
        (0.7, 0.7, 1.2),
        (0.1, 0.3, 1.2),  # where few nodes touch it jumps, and is no flatter than 0.3
    ],
)
def test_the_boundary_is_where_the_rise_reaches_its_limit_and_grows_so_fast(
    runs, exponent, found, at
):
    limit = 1200.0  # 120 K over friction 0.1
    runs(lambda load, velocity, _: limit * (load / 150.0) * (velocity / at) ** exponent)
    (point,), (power,) = near_the_boundary(tiny.sweep(velocities=(-0.5, 0.0, 1.5)), [Target(150.0)])
    assert power == pytest.approx(found, rel=1e-6)
    assert exponent * abs(math.log(point.velocity / at)) <= 0.01
    assert (point.load, point.variant) == (150.0, ())


@pytest.mark.parametrize(("factor", "end"), [(9.0, 0.25), (0.1, 3.0)])
def test_beyond_half_the_lowest_and_twice_the_highest_velocity_the_end_is_taken(runs, factor, end):
    runs(lambda load, velocity, _: 1200.0 * factor * velocity**0.5)
    sweep = tiny.sweep(velocities=(-0.5, 0.0, 1.5))
    (point,), _ = near_the_boundary(sweep, [Target(150.0)])
    assert point.velocity == pytest.approx(end)


def test_a_probe_takes_the_time_of_its_points_once_surfaces_are_made(runs, monkeypatch):
    made = runs(lambda load, velocity, _: 1000.0)
    monkeypatch.setattr(probe_module.time, "process_time", iter([7.0, 9.5]).__next__)
    points = [Point(250.0, 1.5), Point(150.0, 0.5), Point(600.0, 1.0)]
    implicit = Fidelity(pixels_per_element=1, increments=20)
    probed = probe(tiny.sweep(), implicit, points)
    assert probed.seconds == 2.5
    assert [reading.contact_nodes for reading in probed.readings] == [2500, 1500, 6000]
    first, *calls = made.calls
    assert first == (implicit, 75.0, 0.45)  # half the lightest, before the time is taken
    assert sorted(call[1:] for call in calls) == sorted(point[:2] for point in points)


def test_errors_have_the_sign_of_the_boundary():
    """A rise too high by 1 % lets the boundary be too low, by 2 % at an exponent of 1/2."""
    (error,) = velocity_errors([replace(TRUE, rise=1010.0)], [TRUE], [0.5])
    assert error == pytest.approx(1.01**-2 - 1)

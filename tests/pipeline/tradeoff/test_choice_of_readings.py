"""Choice of a fidelity where the readings of every probe are given: errors computed by hand."""

from dataclasses import replace

import pytest

from pipeline.store.create import writing
from pipeline.sweep.model import Point
from pipeline.sweep.variants import surfaces
from pipeline.tradeoff import trade
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity, measure_error
from pipeline.tradeoff.probe import Probe, Reading
from tests.helpers import synthetic, tiny
from tests.helpers.accuracy_scenes import SCENES
from tests.helpers.entries import changed
from tribo import PRESETS, ConvergenceError, Fidelity, Grid, InputError

WORN = changed(
    SCENES["low loads"],
    loads=(60.0, 100.0, 180.0),
    velocities=(0.5, 1.0),
    pixels=Grid((96, 48), (4e-6, 4e-6)),
)
SECONDS = {PRESETS[name]: time for name, time in zip(PRESETS, (1.0, 2.0, 5.0, 50.0), strict=True)}
OWN = "the scene's own fidelity"


class Rig:
    """Probes whose error is a function of the fidelity and the number of the point.

    Rises grow with the velocity itself, so that the boundary errs as they do.
    """

    def __init__(self):
        self.err, self.nodes = lambda fidelity, number: 0.02, 5000
        self.exponents, self.said, self.tried = {}, [], []

    def near_the_boundary(self, sweep, places):
        points = tuple(Point(place.load, 1.0, place.variant) for place in places)
        return points, tuple(self.exponents.get(place.load, 1.0) for place in places)

    def probe(self, sweep, fidelity, points):
        self.tried.append(fidelity)
        is_exact = fidelity.increments == PRESETS["reference"].increments
        errors = [0.0 if is_exact else self.err(fidelity, k) for k in range(len(points))]
        nodes = [self.nodes + 1] * (len(points) - 1) + [self.nodes]
        rises = (1000.0 / (1 + error) for error in errors)
        return Probe(fidelity, tuple(map(Reading, rises, nodes)), SECONDS.get(fidelity, 3.0))

    def choose(self, sweep, accuracy, points=None):
        self.said.clear()
        return choose_fidelity(sweep, accuracy, points, self.said.append)


@pytest.fixture
def rig(monkeypatch):
    rig = Rig()
    for name in ("near_the_boundary", "probe"):
        monkeypatch.setattr(trade, name, getattr(rig, name))
    return rig


@pytest.mark.parametrize(
    ("err", "nodes", "expected"),
    [
        # 1.3 times the largest, or the mean and 2.5 standard deviations.
        (lambda *_: 0.02, 400, 0.026 + 0.1 / 400),
        (lambda *_: 0.02, 5000, 0.026 + 2e-5),
        (lambda _, k: 0.02 - 0.01 * k, 5000, 0.01 + 0.025 + 2e-5),
        (lambda _, k: 0.01 * k - 0.02, 5000, 0.01 + 0.025 + 2e-5),
    ],
)
def test_the_error_of_a_fidelity_is_that_at_any_load(rig, err, nodes, expected):
    rig.err, rig.nodes = err, nodes
    own = changed(WORN, fidelity=Fidelity(increments=30), preset=None)
    kept = rig.choose(own, None)
    assert kept.error == pytest.approx(expected + 0.002, rel=1e-9)
    assert (kept.name, kept.accuracy) == (OWN, None)
    assert [one.name for one in kept.choices] == [OWN, "reference"]
    assert kept.fidelity == own.scene.fidelity
    assert kept.choices[1].error_at_any_load == pytest.approx(0.002 + 0.1 / nodes)


def test_of_two_loads_no_deviation_is_known(rig):
    rig.err = lambda _, k: 0.02 if k else -0.02
    own = changed(WORN, loads=(60.0, 180.0), fidelity=Fidelity(increments=30), preset=None)
    kept = rig.choose(own, None)
    assert kept.error == pytest.approx(0.026 + 2e-5 + 0.002, rel=1e-9)


def test_six_places_have_the_surfaces_in_turn(rig):
    points = rig.choose(changed(WORN, variants=surfaces((3, 4, 5))), None).points
    assert len(points) == 6
    assert {load for load, _ in points} == {60.0, 100.0, 180.0}


@pytest.mark.parametrize(
    ("accuracy", "name"), [(0.2, "draft"), (0.05, "standard"), (0.01, "fine"), (1e-4, "reference")]
)
def test_the_cheapest_within_the_bound_is_taken_or_else_the_reference(rig, accuracy, name):
    errors = {"draft": 0.1, "standard": 0.02, "fine": 0.002}
    by_fidelity = {PRESETS[name]: error for name, error in errors.items()}
    rig.err = lambda fidelity, _: by_fidelity.get(fidelity, 0.5)
    picked = rig.choose(changed(WORN, fidelity=Fidelity(increments=30), preset=None), accuracy)
    assert (picked.name, picked.fidelity) == (name, PRESETS[name])
    by_work = ["draft", "standard", OWN, "fine", "reference"]
    assert [one.name for one in picked.choices] == by_work
    assert ("more than asked for" in str(picked)) == (name == "reference")
    words = [one.words for one in rig.said]
    assert words[0].startswith("5 choices at 3 places")
    assert words[1] == "1 of 5: reference"


def test_the_scene_s_own_fidelity_is_picked_where_it_is_the_cheapest(rig):
    own = Fidelity(increments=30)
    rig.err = lambda fidelity, _: 0.001 if fidelity in (own, PRESETS["fine"]) else 0.5
    picked = choose_accuracy(changed(WORN, fidelity=own, preset=None), 0.02)
    assert picked.about.selection.name == OWN
    assert (picked.scene.fidelity, picked.about.preset) == (own, None)


def test_the_present_heat_is_as_the_scene_has_it(rig):
    past = replace(PRESETS["draft"], heat_model="history", history_coarsening=1)
    rig.choose(changed(WORN, fidelity=past, preset=None), 0.02)
    assert {(one.heat_model, one.history_coarsening) for one in rig.tried} == {("history", 1)}
    assert len(rig.tried) == 4  # draft is the scene's own


def test_a_choice_that_does_not_converge_is_passed_over_unless_it_is_the_scene_s_own(rig):
    def err(fidelity, number):
        if fidelity.increments == PRESETS["draft"].increments:
            raise ConvergenceError("the contact did not converge", None)
        return 0.001

    rig.err = err
    picked = rig.choose(WORN, 0.02)
    assert "draft" not in {one.name for one in picked.choices}
    assert picked.error < 0.02
    with pytest.raises(ConvergenceError, match="did not converge"):
        rig.choose(changed(WORN, fidelity=PRESETS["draft"], preset="draft"), None)


def test_points_that_are_asked_for_are_judged_by_the_exponents_of_their_loads(rig):
    """Rises that err by 2 % at an exponent of 1/2 let the velocity err by 1.02² − 1."""
    rig.exponents = {60.0: 1.0, 180.0: 0.5}
    points = Point(60.0, 2.0), Point(180.0, 0.7)
    rig.err = lambda _, number: 0.02 * number
    own = changed(WORN, fidelity=Fidelity(increments=30), preset=None)
    kept = rig.choose(own, None, points)
    assert kept.points == ((60.0, 2.0), (180.0, 0.7))
    assert kept.error == pytest.approx(1.3 * 0.0404 + 0.002 + 2e-5, rel=1e-9)


def test_a_still_point_among_others_has_no_error(rig):
    with pytest.raises(InputError, match="velocity is 0, so there is no heat"):
        rig.choose(WORN, None, [Point(60.0, 1.0), Point(60.0, 0.0)])


@pytest.mark.parametrize(("accuracy", "name"), [(0.08, "draft"), (0.02, "standard")])
def test_a_choice_that_is_a_preset_gives_the_scene_its_name(rig, accuracy, name):
    steps = PRESETS["draft"].increments
    rig.err = lambda fidelity, _: 0.05 if fidelity.increments == steps else 0.001
    changed = choose_accuracy(WORN, accuracy)
    assert (changed.about.selection.name, changed.about.preset) == (name, name)
    assert changed.scene.fidelity == changed.about.selection.fidelity


def test_a_store_whose_choice_errs_by_the_accuracy_goes_on(tmp_path):
    sweep = tiny.sweep(selection=synthetic.selection(error=0.05))
    with writing(tmp_path / "a.zarr", sweep):
        pass
    assert choose_accuracy(tiny.sweep(), 0.05, store=tmp_path / "a.zarr").about.preset == "fine"


def test_the_error_of_an_own_fidelity_is_measured(rig, tmp_path):
    own = changed(WORN, fidelity=Fidelity(increments=30), preset=None)
    measured = measure_error(own, tmp_path / "new.zarr", rig.said.append)
    assert changed(measured, selection=None) == own
    assert measured.about.selection.name == OWN
    assert rig.said[0].words.startswith("2 choices at 3 places")


def test_the_error_of_an_own_fidelity_is_that_of_its_store(rig, tmp_path):
    selection = synthetic.selection(accuracy=None, name=OWN)
    with writing(tmp_path / "a.zarr", tiny.sweep(selection=selection)):
        pass
    again = measure_error(tiny.sweep(), tmp_path / "a.zarr", rig.said.append)
    assert again.about.selection == selection
    assert rig.said == []

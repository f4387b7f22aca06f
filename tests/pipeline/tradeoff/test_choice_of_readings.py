"""Choice of a fidelity where the readings of every probe are given: errors computed by hand."""

import pytest

from pipeline.store.create import writing
from pipeline.sweep.model import Point
from pipeline.tradeoff import trade
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity, measure_error
from pipeline.tradeoff.probe import Probe
from tests.helpers import synthetic, tiny
from tests.helpers.accuracy_scenes import SCENES
from tests.helpers.entries import changed
from tribo import PRESETS, ConvergenceError, Fidelity, Grid

WORN = changed(
    SCENES["low loads"],
    loads=(60.0, 100.0, 180.0),
    velocities=(0.5, 1.0),
    pixels=Grid((96, 48), (4e-6, 4e-6)),
)
SECONDS = {PRESETS[name]: time for name, time in zip(PRESETS, (1.0, 2.0, 5.0, 50.0), strict=True)}
OWN = "the scene's own fidelity"


class Rig:
    """Fake probes, whose error is a function of fidelity and point number.

    Rises are proportional to velocity, so the boundary has the same relative error.
    """

    def __init__(self):
        self.err, self.nodes = lambda fidelity, number: 0.02, 5000
        self.exponents, self.said, self.tried = {}, [], []

    def points_near_boundary(self, sweep, places):
        points = tuple(Point(place.load, 1.0, place.variant) for place in places)
        return points, tuple(self.exponents.get(place.load, 1.0) for place in places)

    def probe(self, sweep, fidelity, points):
        self.tried.append(fidelity)
        is_exact = fidelity.increments == PRESETS["reference"].increments
        errors = [0.0 if is_exact else self.err(fidelity, k) for k in range(len(points))]
        rises = tuple(1000.0 / (1 + error) for error in errors)
        return Probe(fidelity, rises, self.nodes, SECONDS.get(fidelity, 3.0))

    def choose(self, sweep, accuracy):
        self.said.clear()
        return choose_fidelity(sweep, accuracy, self.said.append)


@pytest.fixture
def rig(monkeypatch):
    rig = Rig()
    for name in ("points_near_boundary", "probe"):
        monkeypatch.setattr(trade, name, getattr(rig, name))
    return rig


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


def test_a_store_whose_choice_errs_by_the_accuracy_goes_on(tmp_path):
    sweep = tiny.sweep(selection=synthetic.selection(error=0.05))
    with writing(tmp_path / "a.zarr", sweep):
        pass
    assert choose_accuracy(tiny.sweep(), 0.05, store=tmp_path / "a.zarr").preset == "fine"


def test_the_error_of_an_own_fidelity_is_measured(rig, tmp_path):
    own = changed(WORN, fidelity=Fidelity(increments=30), preset=None)
    measured = measure_error(own, tmp_path / "new.zarr", rig.said.append)
    assert changed(measured, selection=None) == own
    assert measured.selection.name == OWN
    assert rig.said[0].words.startswith("2 choices at 3 places")

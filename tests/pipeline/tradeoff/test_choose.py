"""Choice of a fidelity for an accuracy; that it keeps it is judged in `test_promise`."""

import json
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.analysis.dataset import stored_sweep
from pipeline.store.root import read_sweep
from pipeline.sweep.model import Point
from pipeline.sweep.variants import surfaces
from pipeline.tradeoff import choose as accuracy_module
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity
from pipeline.tradeoff.probe import some_places
from tests.helpers import tiny
from tests.helpers.accuracy_scenes import SCENES
from tribo import PRESETS, Fidelity, Grid, SelfAffineRoughness

# So many velocities that it pays to look for something cheaper than the reference.
MANY = tuple(float(velocity) for velocity in np.geomspace(0.5, 8.0, 40))
WORN, UNWORN = (
    SCENES[name].changed(
        loads=SCENES[name].plane.loads[::2],
        velocities=MANY,
        pixels=Grid((64, 32), (6e-6, 6e-6)),
        roughness=SelfAffineRoughness(0.27e-6, 0.8, (12e-6, 12e-6), seed=0),
    )
    for name in ("low loads", "no wear")
)


def test_it_picks_the_first_that_is_good_enough_and_says_why():
    changed = choose_accuracy(WORN, 0.05)
    selection = changed.about.selection
    assert changed.scene.fidelity == selection.fidelity == selection.trials[-1].fidelity
    assert all(trial.error > 0.05 for trial in selection.trials[:-1])
    assert selection.error <= 0.05
    assert selection.seconds > 0
    said = str(selection)
    for word in ("accuracy 5 %", f"picked {selection.name}", "errs by", "the probe took"):
        assert word in said
    document = json.loads(json.dumps(selection.as_dict()))
    assert document["points"][0] == {"load": 60.0, "velocity": selection.points[0][1]}
    assert changed.about.preset == (selection.name if selection.name in PRESETS else None)


@pytest.mark.parametrize(
    ("sweep", "points"),
    [(UNWORN, (Point(300.0, 1.5),)), (UNWORN.changed(velocities=(1.0, 2.0)), None)],
    ids=["one point", "few points"],
)
def test_a_few_points_are_judged_before_the_reference_is_taken(sweep, points):
    selection = choose_fidelity(sweep, 0.03, points=points)
    assert selection.name not in ("reference", "")
    assert 0 < selection.error <= 0.03
    assert len(selection.points) == (1 if points else 3)  # one at each load
    if points:
        assert selection.points == ((300.0, 1.5),)
    strict = choose_fidelity(sweep, 1e-6, points=points)
    assert strict.name.startswith("reference")
    assert strict.error >= 2e-3  # nearly exact steps are no exacter
    assert "more than asked for" in str(strict)


def test_one_error_is_said_the_largest_known():
    selection = choose_fidelity(UNWORN, 0.05, points=(Point(300.0, 1.5),))
    said = str(selection)
    assert "s for the points of the probe, nearly exact steps in" in said
    assert "errs by" in said
    moved = str(replace(selection, error=0.002, coarser=3.4))
    assert "errs by up to 340 %" in moved
    assert "0.2 %" not in moved
    odd = UNWORN.changed(
        pixels=Grid((121, 61), (3.2e-6, 3.2e-6)), fidelity=Fidelity(pixels_per_element=1)
    )
    assert "cannot be joined" in str(choose_fidelity(odd, 0.05, points=(Point(300.0, 1.5),)))


def test_every_surface_has_its_turn():
    several = UNWORN.changed(variants=surfaces((3, 4, 5)))
    assert {place.variant[0][1] for place in some_places(several, 6)} == {3, 4, 5}


def test_the_heat_of_all_the_past_is_taken_where_the_present_one_errs_too_far():
    slow = UNWORN.changed(velocities=tuple(velocity / 100 for velocity in MANY))
    warm = replace(slow.conditions, critical_temperature=slow.conditions.bulk_temperature + 12)
    slow = slow.changed(conditions=warm)
    loose, strict = (choose_fidelity(slow, accuracy) for accuracy in (0.3, 0.02))
    assert (loose.fidelity.heat_model, strict.fidelity.heat_model) == ("elapsed", "history")
    assert "with all heat so far" in strict.name


def test_a_store_says_why_it_has_its_fidelity_and_goes_on_without_another_probe(
    tmp_path, monkeypatch
):
    out = tmp_path / "out.zarr"
    small = tiny.sweep().changed(loads=(250.0, 600.0), velocities=(1.0, 1.5))
    begun = choose_accuracy(small, 0.1, store=out)  # not there yet
    pipeline.run_sweep(begun, out, workers=1)
    assert read_sweep(out).about.selection == begun.about.selection
    assert stored_sweep(pipeline.open_sweep(out)).about.selection == begun.about.selection

    def refused(*_):
        raise AssertionError("another probe")

    monkeypatch.setattr(accuracy_module, "choose_fidelity", refused)
    grown = small.changed(velocities=(1.0, 1.5, 2.0))
    for accuracy in (0.1, 0.3):
        again = choose_accuracy(grown, accuracy, store=out)
        assert (again.scene.fidelity, again.about.selection) == (
            begun.scene.fidelity,
            begun.about.selection,
        )
    outcome = pipeline.run_sweep(again, out, workers=1)
    assert (outcome.computed, outcome.done) == (2, 6)
    # Without --accuracy, but with the same fidelity, the reasons stay.
    pipeline.run_sweep(again.changed(selection=None), out, workers=1)
    assert read_sweep(out).about.selection == begun.about.selection
    stricter = begun.about.selection.error / 2
    with pytest.raises(pipeline.StoreMismatchError, match=r"errs by .* another store"):
        choose_accuracy(grown, stricter, store=out)

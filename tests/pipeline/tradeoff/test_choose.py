"""Choice of a fidelity for an accuracy; that it keeps it is judged in `test_promise`."""

import pytest

import pipeline
from pipeline.store.write import opened
from pipeline.tradeoff import choose as accuracy_module
from pipeline.tradeoff.choose import choose_accuracy, choose_fidelity
from tests.helpers import tiny
from tests.helpers.accuracy_scenes import SCENES
from tests.helpers.entries import changed
from tribo import PRESETS, Fidelity, Grid, SelfAffineRoughness

WORN, UNWORN = (
    changed(
        SCENES[name],
        loads=SCENES[name].plane.loads[::2],
        pixels=Grid((64, 32), (6e-6, 6e-6)),
        roughness=SelfAffineRoughness(0.27e-6, 0.8, (12e-6, 12e-6), seed=0),
    )
    for name in ("low loads", "no wear")
)


def test_it_picks_the_cheapest_that_is_good_enough_and_says_why():
    changed = choose_accuracy(WORN, 0.05)
    selection = changed.selection
    cheapest = next(one for one in selection.choices if one.error_at_any_load <= 0.05)
    assert (selection.name, selection.error) == (cheapest.name, cheapest.error_at_any_load)
    assert changed.scene.fidelity == selection.fidelity == cheapest.fidelity
    said = str(selection)
    for word in ("accuracy 5 %", f"picked {selection.name}", "err by at most"):
        assert word in said
    assert changed.preset == (selection.name if selection.name in PRESETS else None)


def test_it_takes_the_reference_and_says_so_where_nothing_is_enough():
    strict = choose_fidelity(changed(UNWORN, loads=(300.0,)), 1e-6)
    assert strict.name == "reference"
    assert strict.error >= 2e-3
    assert "more than asked for" in str(strict)


def test_all_the_past_is_kept_where_the_scene_s_own_heat_has_it():
    past = Fidelity(heat_model="history", history_coarsening=1, increments=6)
    past = changed(UNWORN, loads=(300.0,), fidelity=past)
    measured = choose_fidelity(past, 0.05)
    assert {one.fidelity.heat_model for one in measured.choices} == {"history"}
    assert [one.name for one in measured.choices][-1] == "reference"


def test_a_store_says_why_it_has_its_fidelity_and_goes_on_without_another_measurement(
    tmp_path, monkeypatch
):
    out = tmp_path / "out.zarr"
    small = changed(tiny.sweep(), loads=(250.0, 600.0), velocities=(1.0, 1.5))
    begun = choose_accuracy(small, 0.1, store=out)  # the store does not exist yet
    pipeline.run_sweep(begun, out, workers=1)
    assert opened(out).sweep.selection == begun.selection
    assert pipeline.results(pipeline.open_sweep(out)).sweep.selection == begun.selection

    def refused(*_):
        raise AssertionError("another measurement")

    monkeypatch.setattr(accuracy_module, "choose_fidelity", refused)
    grown = changed(small, velocities=(1.0, 1.5, 2.0))
    for accuracy in (0.1, 0.3):
        again = choose_accuracy(grown, accuracy, store=out)
        assert (again.scene.fidelity, again.selection) == (
            begun.scene.fidelity,
            begun.selection,
        )
    outcome = pipeline.run_sweep(again, out, workers=1)
    assert (outcome.computed, outcome.done) == (2, 6)
    # Without --accuracy, but with the same fidelity, the store keeps the reasons of the choice.
    pipeline.run_sweep(changed(again, selection=None), out, workers=1)
    assert opened(out).sweep.selection == begun.selection
    stricter = begun.selection.error / 2
    with pytest.raises(pipeline.StoreMismatchError, match=r"may be off by .* another store"):
        choose_accuracy(grown, stricter, store=out)

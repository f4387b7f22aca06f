"""Options together: conditions of a scene, its accuracy, and values that stores are judged at."""

import argparse
from types import SimpleNamespace

import pytest

import pipeline
from pipeline.cli import given
from tests.helpers import synthetic, tiny
from tests.helpers.scenes import SCENE
from tribo import InputError


def options(**named):
    usual = {"scene": "s.toml", "preset": None, "set": [], "accuracy": None}
    return argparse.Namespace(**usual | named)


@pytest.mark.parametrize(
    ("own", "conditions", "has_heat", "has_unequal_bulks"),
    [
        (0.0, {}, False, False),
        (0.0, {"friction": [0.2]}, True, False),
        (0.0, {"friction": 0.0}, False, False),
        (0.1, {"friction": 0.0}, True, False),  # it may be given afterwards
        (0.0, {"bulk_temperature": {"pin": 333.15, "disk": 298.15}}, False, True),
        (0.1, {"bulk_temperature": 333.15}, True, False),
    ],
)
def test_what_is_simulated_follows_the_conditions_that_were_given(
    tmp_path, own, conditions, has_heat, has_unequal_bulks
):
    (tmp_path / "s.toml").write_text(SCENE.replace("coefficient = 0.1", f"coefficient = {own}"))
    sweep = given.scene_in(options(scene=tmp_path / "s.toml", **conditions))
    found = sweep.scene.friction_heat, sweep.scene.unequal_bulks
    assert found == (has_heat, has_unequal_bulks)


@pytest.mark.parametrize(
    ("asked", "points", "store", "measured"),
    [
        ({}, None, None, []),
        ({}, [(400.0, 2.0)], None, []),
        ({"measure": False}, None, "a.zarr", []),
        ({"measure": True}, None, "a.zarr", ["own error", "a.zarr"]),
        ({"accuracy": 0.05, "measure": False}, None, "a.zarr", ["accuracy", 0.05, None, "a.zarr"]),
        ({"accuracy": 0.05}, None, None, ["accuracy", 0.05, None, None]),
    ],
)
def test_an_error_is_measured_where_it_is_asked_for(
    monkeypatch, capsys, asked, points, store, measured
):
    called = []
    picked = tiny.sweep(selection=synthetic.selection())

    def measure(name):
        def call(sweep, *arguments):
            *told, tell = arguments
            called.extend([name, *told])
            tell("step 1")
            return picked

        return call

    monkeypatch.setattr(pipeline, "load_scene", lambda *_, **__: tiny.sweep())
    monkeypatch.setattr(given, "choose_accuracy", measure("accuracy"))
    monkeypatch.setattr(given, "measure_error", measure("own error"))
    given.scene_in(options(**asked), points, store)
    assert called == measured
    said = f"irg: step 1\nirg: {picked.about.selection}\n" if measured else ""
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(
    ("conditions", "read"),
    [
        ({"share": 0.2}, {"share": 0.2}),
        ({"share": 0.2, "criterion": "share"}, {"share": 0.2, "criterion": "share"}),
        ({"criterion": "mean"}, {"criterion": "mean"}),
        ({"share": 0.2, "criterion": "mean"}, None),
    ],
)  # fmt: skip
def test_a_share_goes_with_a_criterion_that_may_have_one(conditions, read):
    if read is not None:
        assert given.conditions_in(options(**conditions)) == read
        return
    with pytest.raises(InputError, match="criterion mean has no share; leave out --share"):
        given.conditions_in(options(**conditions))


def test_values_that_stores_are_judged_at_have_units_unless_they_have_none():
    pairs = [("pin.radius", "3 mm"), ("friction.coefficient", 0.2), ("oil", "FVA 3")]
    assert given.judged_entries(options(at=pairs)) == dict(pairs)
    assert given.judged_entries(options()) == {}
    with pytest.raises(InputError, match=r"^--at: pin.radius is 3, without a unit; give one such"):
        given.judged_entries(options(at=[("pin.radius", 3)]))


def test_another_store_may_be_judged_without_an_entry(monkeypatch):
    stores = {"a": SimpleNamespace(), "b": SimpleNamespace()}
    asked = options(store="a", at=[("pin.radius", "3 mm")], friction=[0.2], scatter=0.1)
    monkeypatch.setattr(pipeline, "open_sweep", stores.__getitem__)
    monkeypatch.setattr(pipeline, "at", lambda ds, **values: (ds, values))
    conditions = {"friction": 0.2, "scatter": 0.1}
    assert given.dataset_in(asked) == (stores["a"], conditions | {"pin.radius": "3 mm"})
    assert given.dataset_in(asked, "b", {"pin.radius"}) == (stores["b"], conditions)
    assert given.dataset_in(asked, "a") == (stores["a"], conditions | {"pin.radius": "3 mm"})

"""One question asked of every command: their answers agree, and none says more than is known."""

import functools
import itertools
import json
import shlex
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.decisive import conditions_of, decisive_rise
from pipeline.analysis.frames import frames_of
from pipeline.analysis.transition import ABOVE, BELOW, BEYOND, CROSSES, MILD, SEVERE, outcomes
from pipeline.cli import main
from pipeline.cli.margins import document_of
from pipeline.figures.diagram import diagram
from pipeline.sweep.severity import rise_limit
from tests.helpers.scenes import SCENE
from tests.helpers.sweeps import with_fields
from tests.pipeline.figures.page import sweeps
from tribo import Corrections


def done_only(ds, is_done):
    """The sweep with the other points pending."""
    mask = is_done & (ds["status"] == 1)
    steps = ["normal_load", "time", "rise_quantile", "mean_rise", "max_rise", "bulk_rise_quantile"]
    columns = {name: ds[name].where(mask) for name in steps if name in ds}
    return ds.assign(columns | {"status": ds["status"].where(mask, 0).astype(np.int8)})


def full(seed=0):
    return sweeps.one(status={}, rise=sweeps.uneven(seed))


def interrupted(ds):
    """Half of the velocities are done, and one more point."""
    velocity, load = ds["velocity"], ds["load"]
    return done_only(ds, (velocity < 1.6) | ((load == load[-1]) & (velocity == 3.0)))


def several(axis, parts):
    return xr.concat(
        parts, xr.Variable(axis, np.arange(len(parts))), combine_attrs="override", join="override"
    )


CASES = {
    "a grid": lambda: (full(), full()),
    "a hold": lambda: (sweeps.held(), sweeps.held()),
    "interrupted": lambda: (interrupted(full()), full()),
    "interrupted from above": lambda: (done_only(full(), full()["velocity"] > 1.6), full()),
    "boundary only": lambda: (sweeps.along_boundary(0), full()),
    "realizations": lambda: (
        several("realization", [interrupted(full(k)) for k in range(3)]),
        several("realization", [full(k) for k in range(3)]),
    ),
    "one load": lambda: (one_load(interrupted(full())), one_load(full())),
    "one velocity": lambda: (
        one_velocity(done_only(full(), full()["load"] < 500.0)),
        one_velocity(full()),
    ),
    "a warm pin": lambda: (interrupted(warm_pin()), warm_pin()),
    "friction by velocity": lambda: (interrupted(slippery()), slippery()),
    "a warm disk": lambda: (interrupted(sweeps.of_two_bulks()), sweeps.of_two_bulks()),
}


def one_load(ds):
    """The sweep of a scene with that load alone."""
    one = ds.isel(load=[3])
    return with_fields(one, loads=tuple(one["load"].values.tolist()))


def one_velocity(ds):
    """The sweep of a scene with that velocity alone."""
    one = ds.isel(velocity=[3])
    return with_fields(one, velocities=tuple(one["velocity"].values.tolist()))


def slippery():
    """Friction that falls with velocity, and a film on the disk."""
    ds = full()
    falling = Corrections(friction=((1.0, 1.1), (3.0, 0.9)), film_resistance=1e-7)
    return with_fields(ds, conditions=replace(conditions_of(ds), corrections=falling))


def warm_pin():
    ds = sweeps.of_a_warm_pin()
    return with_fields(ds, conditions=replace(conditions_of(ds), criterion="share"))


MILD_OR_SEVERE = ({}, {"friction": 0.05}, {"friction": 0.3})
OTHERS = (
    {"friction": 0.07, "bulk_temperature": 330.0, "critical_temperature": 400.0},
    {"share": 0.4, "friction": 0.12},
    {"criterion": "mean", "friction": 0.13},
)
ASKED = [
    pytest.param(name, changes, id=f"{name}, {changes}")
    for name in CASES
    for changes in MILD_OR_SEVERE + (OTHERS if name == "a grid" else ())
]


@functools.cache
def sweeps_of(name):
    return CASES[name]()


@functools.cache
def _crossings(name, changes):
    return pipeline.boundary(sweeps_of(name)[0], **dict(changes))


def crossings_of(name, changes):
    """The boundary of a case, found once for all questions."""
    return _crossings(name, tuple(changes.items()))


def test_the_command_that_is_named_computes_what_was_beyond(tmp_path, monkeypatch, capsys):
    rate = "2e-6 mm^3/(N m)"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").mkdir()
    scene = tmp_path / "scenes" / "small.toml"
    scene.write_text(SCENE.replace('"400 N", ', ""))
    run = ["run", "scenes/small.toml", "--preset", "draft", "-o", "small.zarr", "--boundary-only"]
    run += ["--set", f"wear.specific_wear_rate={rate}"]
    assert main([*run, "-q", "--workers", "1"]) == 0
    capsys.readouterr()
    ask = ["boundary", "small.zarr", "--json", "--friction", "0.085", "--critical-temperature"]
    ask += ["150 degC"]
    assert main(ask) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document["outcome_at_load"]) & {outcomes("velocity")[code] for code in BEYOND}
    assert main([*shlex.split(document["command"])[1:], "-q", "--workers", "1"]) == 0
    capsys.readouterr()
    assert main(ask) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["command"] is None
    sweep = pipeline.load_scene(scene, "draft", {"wear.specific_wear_rate": rate})
    conditions = sweep.conditions.changed(friction=0.085, critical_temperature=423.15)
    for load, velocity in zip(again["load"], again["critical_velocity"], strict=True):
        if velocity is not None:
            point = pipeline.run_point(sweep, load, velocity).verdict(conditions)
            assert point.decisive_temperature == pytest.approx(423.15, abs=2.0)


def planes(rises):
    return rises.values.reshape(-1, *rises.shape[-2:])


@pytest.mark.parametrize(("name", "changes"), ASKED)
def test_no_outcome_is_contradicted_by_points_that_were_not_computed(name, changes):
    ds, truth = sweeps_of(name)
    conditions = conditions_of(ds, **changes)
    limit = rise_limit(conditions)
    crossings = crossings_of(name, changes)
    for axis, along in (("load", "velocity"), ("velocity", "load")):
        x = ds[along].values
        partial, true = (
            decisive_rise(sweep, conditions).transpose(..., axis, along).values.reshape(-1, len(x))
            for sweep in (ds, truth)
        )
        places = crossings[f"critical_{along}"].values.ravel()
        outcomes = crossings[f"outcome_at_{axis}"].values.ravel()
        for rises, all_rises, place, outcome in zip(partial, true, places, outcomes, strict=True):
            done, severe = np.isfinite(rises), all_rises > limit
            if outcome == CROSSES:  # between neighbours of which one is mild and the next severe
                lower, upper = severe[done & (x <= place)], severe[done & (x >= place)]
                assert place in x or (not lower[-1] and upper[0])
            elif outcome == MILD:
                assert done[-1]
                assert not severe[np.isfinite(all_rises)].any()
            elif outcome == SEVERE:
                assert done[0]
                assert severe[0]
            elif outcome == ABOVE:
                assert not done[-1]
                assert not severe[done].any()
            elif outcome == BELOW:
                assert not done[0]
                assert severe[done][0]
            else:
                assert not done.any()


@pytest.mark.parametrize(("name", "changes"), ASKED)
def test_margins_documents_and_tables_say_what_the_boundary_says(name, changes):
    ds, truth = sweeps_of(name)
    conditions = conditions_of(ds, **changes)
    crossings = crossings_of(name, changes)
    assert_documents_say(crossings)
    true = planes(decisive_rise(truth, conditions)) > rise_limit(conditions)
    done = np.isfinite(planes(decisive_rise(ds, conditions)))
    places = list(itertools.product(range(ds.sizes["load"]), range(ds.sizes["velocity"])))
    for i, j in places[::21]:
        if not done[:, i, j].all():
            continue
        load, velocity = float(ds["load"][i]), float(ds["velocity"][j])
        for k, margin in enumerate(pipeline.margins(ds, load, velocity, **changes)):
            surface = crossings.isel(dict.fromkeys({"realization"} & {*crossings.dims}, k))
            assert margin.is_severe == true[k, i, j]
            code = int(surface["outcome_at_load"][i])
            assert margin.velocity_outcome == outcomes("velocity")[code]
            code = int(surface["outcome_at_velocity"][j])
            assert margin.load_outcome == outcomes("load")[code]
            assert margin.velocity_bridged == surface["bridged_at_load"][i]
            assert margin.load_bridged == surface["bridged_at_velocity"][j]
            np.testing.assert_equal(
                margin.critical_velocity, float(surface["critical_velocity"][i])
            )
            np.testing.assert_equal(margin.critical_load, float(surface["critical_load"][j]))


def assert_documents_say(crossings):
    """Let the document and the tables of a boundary have its outcomes in words."""
    document = document_of(crossings)
    for axis, table in zip(("load", "velocity"), frames_of(crossings), strict=True):
        outcome = crossings[f"outcome_at_{axis}"].values
        along = {"load": "velocity", "velocity": "load"}[axis]
        worded = np.vectorize(outcomes(along).get)(outcome).tolist()
        assert document[f"outcome_at_{axis}"] == worded
        if "quantile" not in crossings:
            assert [text.split(" (")[0] for text in table["outcome"]] == worded


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("a grid", {"friction": 0.05}),
        ("interrupted", {"criterion": "mean", "friction": 0.13}),
        ("interrupted from above", {}),
        ("one load", {"friction": 0.05}),
    ],
)
def test_a_diagram_draws_no_boundary_that_was_not_found(name, changes):
    ds, _ = sweeps_of(name)
    crossings = crossings_of(name, changes)
    figure = diagram(ds, **changes)
    axes, texts = figure.axes[0], [text.get_text() for text in figure.legends[0].texts]
    texts = [text for text in texts if not text.startswith("transition at friction")]  # the band
    is_drawn = any(artist.get_gid() == "boundary" for artist in [*axes.collections, *axes.lines])
    crosses = [(crossings[f"outcome_at_{axis}"] == CROSSES).any() for axis in ("load", "velocity")]
    assert is_drawn <= bool(any(crosses))
    single = [axis for axis in ("load", "velocity") if ds.sizes[axis] == 1]
    if not single:
        expected = bool(crossings["outcome_at_load"].isin(BEYOND).any())
        assert any("beyond what was computed" in text for text in texts) == expected
        expected = bool(crossings["bridged_at_load"].any())
        assert any("across points not done" in text for text in texts) == expected
    elif not is_drawn:
        along = {"load": "velocity", "velocity": "load"}[single[0]]
        words = outcomes(along)[crossings[f"outcome_at_{single[0]}"].item()]
        assert any(f"no transition: {words}" in text for text in texts)

"""Sweeps over samples of inputs that are not known exactly."""

import dataclasses
import json
import pickle
import shutil
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.interpolation import crossing
from pipeline.cli import main
from pipeline.run.follow import follow_boundary
from pipeline.run.work import compute_points
from pipeline.store.create import writing
from pipeline.store.place import StoreMismatchError
from pipeline.store.verify import verify_store
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.plan import points, run_point
from tests.helpers.stores import asked_points, at, done_points, make, opened
from tests.pipeline.cli.test_commands import MEASURED, SCENE
from tests.promises import risk

UNKNOWN = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }
"friction.coefficient" = { mean = 0.13, sd = 0.01 }
"""
SMALL = SCENE.replace("fields = true", "samples = 20").replace('"400 N", "600 N"', '"600 N"')


def load(folder, text=SMALL, unknown=UNKNOWN):
    (folder / "scene.toml").write_text(text + unknown)
    return pipeline.load_scene(folder / "scene.toml")


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sampled")
    sweep = load(folder, SMALL.replace("samples = 20", "samples = 6"))
    first = follow_boundary(sweep, folder / "out.zarr", workers=1)
    shutil.copytree(folder / "out.zarr", folder / "first.zarr")
    grown = follow_boundary(load(folder), folder / "out.zarr", workers=1)
    return folder, first, grown


def test_more_samples_go_on_from_fewer(sampled):
    _, first, grown = sampled
    assert first.computed == first.done == first.total > 0
    assert grown.computed == grown.done - first.done > 0


def test_nothing_is_left_to_do_afterwards(sampled):
    folder, _, grown = sampled
    again = follow_boundary(load(folder), folder / "out.zarr", workers=1)
    assert (again.computed, again.done) == (0, grown.done)
    found = verify_store(folder / "out.zarr")
    assert found.is_clean
    assert found.done == grown.done


def test_a_search_that_was_interrupted_asks_for_the_points_of_one_that_was_not(sampled, tmp_path):
    folder, _, _ = sampled
    out = tmp_path / "out.zarr"
    shutil.copytree(folder / "out.zarr", out)
    done = sorted(done_points(out))
    with writing(out, load(folder)) as store:
        store.forget(done[1::3])
    outcome = follow_boundary(load(folder), out, workers=1)
    assert outcome.computed == len(done[1::3])
    assert sorted(done_points(out)) == done


def test_the_store_has_an_axis_of_samples_with_what_was_drawn(sampled):
    folder, _, _ = sampled
    sweep = load(folder)
    for ds in (xr.open_zarr(folder / "out.zarr"), pipeline.open_sweep(folder / "out.zarr")):
        assert ds["status"].dims == ("sample", "load", "velocity")
        assert ds["sample"].values.tolist() == list(range(20))
        drawn = np.array(sweep.samples.values)
        for path, column in zip(
            ("wear.specific_wear_rate", "friction.coefficient"), drawn.T, strict=True
        ):
            assert ds.coords[path].dims == ("sample",)
            assert ds[path].values.tolist() == column.tolist()
        assert ds["wear.specific_wear_rate"].attrs["units"] == "m s2 kg-1"


def test_a_point_of_a_sample_is_that_of_the_scene_with_its_inputs(sampled):
    folder, _, _ = sampled
    sweep, done = load(folder), done_points(folder / "out.zarr")
    for point in (done[3], done[-2]):
        rate = sweep.samples.values[point.sample][0]
        alone = dataclasses.replace(
            sweep, samples=None, wear=dataclasses.replace(sweep.wear, specific_wear_rate=rate)
        )
        expected = run_point(alone, *point[:2]).columns
        for name in ("max_rise", "wear_volume"):
            values = at(folder / "out.zarr", point, name)
            assert np.array_equal(values[: len(expected[name])], expected[name], equal_nan=True)


def test_each_sample_has_its_boundary_within_the_tolerance(sampled):
    folder, _, _ = sampled
    sweep, ds = load(folder), pipeline.open_sweep(folder / "out.zarr")
    velocities = np.array([1.0, 1.3, 1.7, 2.2, 2.9, 4.0])
    for number in (2, 17):
        variant = sweep.variant(sample=number)
        each = [run_point(variant, 600.0, v).verdict(variant.conditions) for v in velocities]
        limit = rise_limit(variant.conditions) * variant.conditions.friction
        rises = np.array([at.decisive_temperature for at in each]) - 298.15
        expected = crossing(velocities, rises, limit)
        part = ds.sel(sample=number)
        found = pipeline.boundary(part, friction=variant.conditions.friction)
        assert float(found["critical_velocity"].sel(load=600.0)) == pytest.approx(
            expected, rel=0.02
        )


def test_later_samples_are_begun_where_the_first_found_their_boundary(sampled):
    folder, _, _ = sampled
    counts = np.bincount([point.sample for point in done_points(folder / "out.zarr")])
    assert counts[16:].mean() < counts[:16].mean()
    assert counts[16:].mean() <= 6  # about three velocities at either load


def test_another_friction_needs_no_other_store(sampled):
    folder, _, _ = sampled
    other = load(folder, unknown=UNKNOWN.replace("mean = 0.13", "mean = 0.1303"))
    found = follow_boundary(other, folder / "out.zarr", workers=1)
    assert found.computed <= 4  # where the boundary has left what was looked at
    ds = pipeline.open_sweep(folder / "out.zarr")
    assert ds["friction.coefficient"].values.tolist() == [row[1] for row in other.samples.values]
    assert verify_store(folder / "out.zarr").is_clean
    load(folder)


def test_another_distribution_of_what_is_simulated_is_another_scene(sampled):
    folder, _, _ = sampled
    other = load(folder, unknown=UNKNOWN.replace("factor = 1.5", "factor = 1.4"))
    with pytest.raises(StoreMismatchError, match=r"unknown.wear.specific_wear_rate.parameters"):
        follow_boundary(other, folder / "out.zarr", workers=1)
    with pytest.raises(StoreMismatchError, match=r"has an axis for sweep\.samples"):
        follow_boundary(load(folder, unknown="", text=SCENE), folder / "out.zarr", workers=1)
    load(folder)


def test_samples_keep_the_values_that_they_were_simulated_with(sampled, tmp_path):
    folder, _, _ = sampled
    path = tmp_path / "out.zarr"
    shutil.copytree(folder / "out.zarr", path)
    first, second = UNKNOWN.strip().splitlines()[1:]
    third = '"temperature.critical" = { mean = "145 degC", sd = "8 K" }'
    for entries in ((second, first), (third, first, second)):
        moved = load(tmp_path, unknown="\n".join(["\n[unknown]", *entries, ""]))
        with pytest.raises(StoreMismatchError, match=r"other values of wear\.specific_wear_rate"):
            follow_boundary(moved, path)
    last = load(tmp_path, unknown="\n".join(["\n[unknown]", first, second, third, ""]))
    kept = make(path, last).axes["wear.specific_wear_rate"]
    assert kept == opened(folder / "out.zarr").axes["wear.specific_wear_rate"]


def test_a_store_is_shown_in_the_units_of_the_scene_whatever_its_spelling(sampled, capsys):
    folder, _, grown = sampled

    def told(unknown):
        """Run again with another spelling, and show what is known of the wear rate."""
        again = follow_boundary(load(folder, unknown=unknown), folder / "out.zarr", workers=1)
        assert (again.computed, again.done) == (0, grown.done)
        assert main(["infer", str(folder / "out.zarr"), "--json"]) == 0
        (rate, _) = json.loads(capsys.readouterr().out)["inputs"]
        assert rate["unit"] == "m s2 kg-1"
        assert rate["prior"]["mean"] == pytest.approx(1.3e-15, rel=0.05)
        assert main(["infer", str(folder / "out.zarr")]) == 0
        assert main(["infer", str(folder / "out.zarr"), "--contact-width", "348 um"]) == 2
        lines = capsys.readouterr().out.splitlines()
        return next(line for line in lines if line.startswith("wear."))

    plain, pascal = told(UNKNOWN), told(UNKNOWN.replace("1.2e-6 mm^3/(N m)", "1.2e-3 1/TPa"))
    assert float(plain.split()[1]) == pytest.approx(1.3e-6, rel=0.05)
    assert plain.endswith(" mm^3/(N m)")
    assert float(pascal.split()[1]) == pytest.approx(1.3e-3, rel=0.05)
    assert pascal.endswith(" 1/TPa")
    load(folder)


def test_a_store_that_does_not_know_the_unit_of_its_scene_is_shown_in_si(sampled):
    folder, _, _ = sampled
    follow_boundary(load(folder), folder / "out.zarr", workers=1)
    ds = pipeline.open_sweep(folder / "out.zarr")
    known = pipeline.Ensemble.of(ds)
    plain = [dataclasses.replace(each, written=None).as_dict() for each in known.unknown]
    older = pipeline.Ensemble.of(ds.assign_attrs(unknown=plain))
    assert known.unknown[0].shown.name == "mm^3/(N m)"
    assert older.unknown[0].shown.name == "m s2 kg-1"
    assert (older.inputs == known.inputs).all()


def test_friction_and_temperatures_alone_share_one_simulation(tmp_path):
    only = '[unknown]\n"friction.coefficient" = { mean = 0.13, sd = 0.01 }\n'
    sweep = load(tmp_path, unknown=only)
    outcome = follow_boundary(sweep, tmp_path / "out.zarr", workers=1)
    plain = load(tmp_path, SMALL.replace("samples = 20", ""), "")
    assert outcome.total < 20  # not even one for each sample
    ds = pipeline.open_sweep(tmp_path / "out.zarr")
    assert "sample" not in ds.dims
    assert ds.attrs["samples"] == 20
    follow_boundary(plain, tmp_path / "out.zarr", workers=1)
    assert "unknown" not in pipeline.open_sweep(tmp_path / "out.zarr").attrs


def test_samples_that_are_simulated_alike_share_one_simulation(tmp_path):
    surfaces = UNKNOWN.replace("wear.specific_wear_rate", "disk.roughness.seed").replace(
        '{ median = "1.2e-6 mm^3/(N m)", factor = 1.5 }', "[3, 5]"
    )
    sweep = load(tmp_path, unknown=surfaces)
    outcome = follow_boundary(sweep, tmp_path / "out.zarr", workers=1)
    seeds = [row[0] for row in sweep.samples.values]
    firsts = [seeds.index(seed) for seed in seeds]
    done = done_points(tmp_path / "out.zarr")
    assert {point.sample for point in done} == set(firsts) == {0, seeds.index(8 - seeds[0])}
    assert outcome.done == outcome.total == len(done) < 3 * 20
    ds = pipeline.open_sweep(tmp_path / "out.zarr")
    assert ds["simulation"].values.tolist() == firsts
    assert ds["disk.roughness.seed"].values.tolist() == seeds
    assert pipeline.boundary(ds)["critical_velocity"].sel(load=200.0).notnull().all()
    assert pipeline.Ensemble.of(ds).missing == 0
    alone = sweep.variant(sample=19)
    point = next(point for point in done if point.sample == firsts[19])
    rise = ds["max_rise"].sel(sample=19, load=point.load, velocity=point.velocity)
    expected = run_point(alone, *point[:2]).columns["max_rise"]
    assert np.array_equal(rise.values[: len(expected)], expected, equal_nan=True)


def test_the_plane_of_samples_that_are_simulated_alike_is_asked_for_once(tmp_path):
    surfaces = UNKNOWN.replace("wear.specific_wear_rate", "disk.roughness.seed").replace(
        '{ median = "1.2e-6 mm^3/(N m)", factor = 1.5 }', "[3, 5]"
    )
    sweep = load(tmp_path, unknown=surfaces)
    make(tmp_path / "out.zarr", sweep)
    assert len(points(sweep)) == 2 * len(sweep.loads) * len(sweep.velocities)
    assert set(asked_points(tmp_path / "out.zarr")) == set(points(sweep))


def test_points_of_a_sample_share_a_task_in_which_each_ramp_starts_anew(tmp_path):
    sweep = dataclasses.replace(load(tmp_path), velocities=(1.0, 2.0))
    own = tuple(point for point in points(sweep) if point.sample == 3)
    ends = own[:1] + own[-1:]  # the lowest load of one ramp, the highest of another
    stretch = compute_points(pickle.dumps((sweep, False)), ends, None, 1e9)
    assert stretch.ramp == own[-1][1:]
    for point, record in zip(ends, stretch.records, strict=True):
        expected = run_point(sweep, *point).columns["max_rise"]
        assert np.array_equal(record.data["max_rise"], expected, equal_nan=True)


def test_the_commands_tell_risk_causes_and_what_to_measure_next(sampled, tmp_path, capsys):
    folder, _, _ = sampled
    load(folder, unknown=UNKNOWN + MEASURED.replace("400 N", "500 N").replace("2 m/s", "1.3 m/s"))
    assert main(["run", str(folder / "scene.toml"), "-o", str(folder / "out.zarr"), "-q"]) == 0
    capsys.readouterr()

    def told(*arguments):
        assert main([*map(str, arguments), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    store = folder / "out.zarr"
    at = told("risk", store, "--load", "500 N", "--velocity", "1.3 m/s")
    assert 0.0 < at["probability"] < 1.0
    assert 0.0 < at["error"] < 0.2
    assert told("risk", store, "-o", tmp_path / "r.png")["samples"] == 20
    given = told("sensitivity", store, "--given-measured", "-o", tmp_path / "s.png")
    assert given["given_measured"]
    causes = told("sensitivity", store)
    assert causes["inputs"] == ["wear.specific_wear_rate", "friction.coefficient"]
    assert np.allclose(np.sum(causes["first"], axis=1), 1.0, atol=0.05)
    found = told("infer", store, "--next", "-o", tmp_path / "p.png")
    assert len(found["next"]) == 6
    shown = pipeline.warned(pipeline.open_sweep(store))
    assert found["warnings"] == causes["warnings"] == shown.as_dict()
    assert all(path.stat().st_size > 10_000 for path in tmp_path.glob("*.png"))
    assert len(list(tmp_path.glob("*.png"))) == 3
    load(folder)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("risk", "--load", "300 N", "--velocity", "2 m/s"), ["finding the probability"]),
        (("sensitivity",), ["finding Sobol' indices"]),
        (("infer", "--next"), ["weighing the inputs", "ranking what to measure"]),
    ],
)
def test_what_takes_long_with_many_samples_says_that_it_works(
    sampled, monkeypatch, capsys, command, said
):
    stages = []

    @contextmanager
    def noted(what):
        stages.append(what)
        yield

    folder, _, _ = sampled
    monkeypatch.setattr("pipeline.cli.unknowns.working", noted)
    assert main([command[0], str(folder / "out.zarr"), *command[1:]]) == 0
    assert stages[0] == "reading samples"
    assert all(any(stage.startswith(each) for stage in stages) for each in said)


def test_the_risk_is_that_of_direct_simulations(sampled):
    folder, _, _ = sampled
    follow_boundary(load(folder), folder / "out.zarr", workers=1)
    ds = pipeline.open_sweep(folder / "out.zarr")
    middle = float(pipeline.boundary(ds)["critical_velocity"].sel(load=200.0).median())
    place = (200.0, middle)
    found = risk.judged(pipeline.Ensemble.of(ds), folder / "scene.toml", 32, {}, place)
    assert 0.2 < found["direct"] < 0.8  # where chance tells most
    assert abs(found["standard_errors_apart"]) < risk.LIMIT
    assert abs(found["surrogate_bias"]) < found["surrogate_error"] < 0.02
    assert found["surrogate_spread"] < 2 * found["surrogate_error"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("risk", "--load", "500 N"), "give --load and --velocity, or neither"),
        (("risk", "--load", "900 N", "--velocity", "2 m/s"), "load is 900 N; the samples have"),
        (("risk", "--given-measured"), "no measured transition; give it a [[measured]]"),
    ],
)
def test_wrong_use_is_told_in_a_line(sampled, capsys, arguments, told):
    folder, _, _ = sampled
    follow_boundary(load(folder), folder / "out.zarr", workers=1)
    command, *options = arguments
    assert main([command, str(folder / "out.zarr"), *options]) == 2
    assert told in capsys.readouterr().err


def test_a_store_without_samples_says_how_to_get_them(alone, capsys):
    assert main(["risk", str(alone)]) == 2
    assert "give [unknown] and sweep.samples" in capsys.readouterr().err


def test_the_boundary_and_the_margin_of_samples_are_a_band_under_their_own_inputs(sampled, capsys):
    folder, _, _ = sampled
    follow_boundary(load(folder), folder / "out.zarr", workers=1)
    ds = pipeline.open_sweep(folder / "out.zarr")
    found = pipeline.boundary(ds)
    assert found["critical_velocity"].dims == ("sample", "load")
    frictions = ds["friction.coefficient"].values
    alone = pipeline.boundary(ds.sel(sample=7), friction=float(frictions[7]))
    own = found["critical_velocity"].sel(sample=7)
    assert own.values == pytest.approx(alone["critical_velocity"].values, nan_ok=True)
    low, middle, high = found["critical_velocity_quantile"].sel(load=200.0).values
    assert low < middle < high
    margins = pipeline.margins(ds, 200.0, 2.5)
    assert [each.sample for each in margins] == list(range(20))
    warm = [each.decisive_temperature for each in margins]
    same = [each.decisive_temperature for each in pipeline.margins(ds, 200.0, 2.5, friction=0.13)]
    assert np.std(same) < np.std(warm)
    place = ("--load", "200 N", "--velocity", "2.5 m/s")
    for command in (("boundary",), ("margin", *place), ("plot", "-o", folder / "plane.png")):
        assert main([command[0], str(folder / "out.zarr"), *map(str, command[1:])]) == 0
    out = capsys.readouterr().out
    assert "severe wear with a probability of" in out
    assert "in 90 % of cases" in out
    assert main(["margin", str(folder / "out.zarr"), *place, "--friction", "0.13"]) == 0
    assert "of 20 samples" in capsys.readouterr().out
    assert main(["plot", str(folder / "out.zarr"), "--kind", "ramp"]) == 2
    assert "samples of unknown inputs" in capsys.readouterr().err

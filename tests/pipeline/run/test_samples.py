"""Sweeps over samples of inputs that are not known exactly."""

import dataclasses
import shutil

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.store.verify import verify_store
from pipeline.sweep.plan import points, run_points
from pipeline.sweep.variants import Variants
from pipeline.uncertain import inputs, sensitivity
from pipeline.uncertain.emulator import load_numbers
from pipeline.uncertain.ensemble import Ensemble
from tests.helpers.entries import changed
from tests.helpers.samples import fewer_draws
from tests.helpers.scenes import MEASURED, SCENE
from tests.helpers.stores import contents, stored_values
from tests.helpers.sweeps import inputs_of
from tests.promises import risk
from tribo import InputError

UNKNOWN = """
[unknown]
"wear.specific_wear_rate" = { median = "1.2e-6 mm^3/(N m)", factor = 1.5 }
"friction.coefficient" = { mean = 0.13, sd = 0.01 }
"""
SMALL = SCENE.replace("fields = true", "samples = 16").replace('"400 N", "600 N"', '"600 N"')


def load(folder, text=SMALL, unknown=UNKNOWN):
    (folder / "scene.toml").write_text(text + unknown)
    return pipeline.load_scene(folder / "scene.toml")


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    """Folder with a store to which samples were added in a second run."""
    folder = tmp_path_factory.mktemp("sampled")
    sweep = load(folder, SMALL.replace("samples = 16", "samples = 8"))
    first = pipeline.run_sweep(sweep, folder / "out.zarr", workers=1)
    assert (first.done, first.computed) == (16, 16)
    grown = pipeline.run_sweep(load(folder), folder / "out.zarr", workers=1)
    assert (grown.done, grown.computed, grown.failed) == (32, 16, ())
    assert verify_store(folder / "out.zarr").is_clean
    return folder


def test_the_fit_of_samples_is_kept_by_a_run_and_by_nobody_who_reads(sampled, tmp_path, irg):
    path = shutil.copytree(sampled / "out.zarr", tmp_path / "out.zarr")
    before = contents(path)
    Ensemble.of(path).keeper.keep("fit-0", b"1")
    assert contents(path) == before
    irg("run", sampled / "scene.toml", "-o", path, "--workers", 1)
    kept = contents(path).keys() - before.keys()
    assert len(kept) == 1
    assert all(name.startswith("status/kept-fit-") for name in kept)
    keeper = pipeline.open_sweep(path)["status"].encoding["keeper"]
    names = [name.removeprefix("status/kept-") for name in kept]
    assert None not in [load_numbers(keeper, name) for name in names]
    (path / "status" / f"kept-{names[0]}").write_text("[" * 10**5)
    assert load_numbers(keeper, names[0]) is None


def test_a_dataset_has_the_inputs_and_the_velocity_of_each_sample(sampled):
    samples, ds = load(sampled).variants, pipeline.open_sweep(sampled / "out.zarr")
    assert ds["max_rise"].dims == ("variant", "load", "step")
    assert ds["velocity"].dims == ("variant",)
    assert ds["velocity"].values.tolist() == list(samples.labels("velocity"))
    (rate,) = inputs_of(samples).T
    assert ds["wear.specific_wear_rate"].values.tolist() == rate.tolist()
    assert ds["wear.specific_wear_rate"].attrs["units"] == "m2 N-1"
    with xr.open_zarr(sampled / "out.zarr") as plain:
        assert {"sample", "wear.specific_wear_rate", "velocity"} <= plain.coords.keys()


def test_a_sample_on_a_shared_contact_is_the_scene_with_its_inputs_and_velocity(sampled):
    sweep, number = load(sampled), 5
    (rate,), velocity = inputs_of(sweep.variants)[number], sweep.variants.labels("velocity")[number]
    alone = changed(
        sweep,
        variants=Variants(),
        wear=dataclasses.replace(sweep.scene.wear, specific_wear_rate=rate),
    )
    expected = pipeline.run_point(changed(alone, steps="end"), 600.0, velocity).columns
    point = next(p for p in points(sweep) if p[::2] == (600.0, (("variant", number),)))
    for name in ("max_rise", "wear_volume", "sliding_distance", "contact_width"):
        stored = stored_values(sampled / "out.zarr", point, name)[-len(expected[name]) :]
        # The contact is computed with k and V of another sample; k V is equal up to rounding.
        np.testing.assert_allclose(stored, expected[name], rtol=1e-9)
    again = run_points(sweep, [point])[0].columns["max_rise"]
    assert np.array_equal(
        stored_values(sampled / "out.zarr", point, "max_rise"), again, equal_nan=True
    )


def test_the_rise_of_a_sample_left_out_is_within_the_stated_error(sampled):
    ds = pipeline.open_sweep(sampled / "out.zarr")
    whole = pipeline.Ensemble.of(ds)
    others = pipeline.Ensemble.of(ds.isel(variant=whole.contacts != 1))
    for row in np.flatnonzero(whole.contacts == 1):
        draws = np.array([[whole.inputs[row, 0], 0.13]])
        emulated = others.excess(draws, 600.0, whole.sample_velocities[row])
        expected = np.log(whole.rises[row, 1]) - others.log_limit(draws)
        assert abs(emulated.values[0] - expected[0]) < 4 * emulated.error[0]


def test_the_commands_say_risk_causes_and_inputs(sampled, tmp_path, irg, irg_both, monkeypatch):
    fewer_draws(monkeypatch)
    monkeypatch.setattr(inputs.prior, "__defaults__", (2**9,))
    monkeypatch.setattr(sensitivity, "_POINTS", 2**8)
    load(sampled, unknown=UNKNOWN + MEASURED.replace("400 N", "500 N").replace("2 m/s", "1.3 m/s"))
    store = sampled / "out.zarr"
    irg("run", sampled / "scene.toml", "-o", store, "-q", "--workers", 1)

    def said(*arguments):
        return irg(*arguments, "--json")

    place = ("--load", "500 N", "--velocity", "1.3 m/s")
    words, (there,) = irg_both("margin", store, *place)
    margin = pipeline.margin(store, "500 N", "1.3 m/s")
    for by in ("velocity", "test"):
        assert "so there is no plane" in irg("boundary", store, "--by", by, code=2)
    between = pipeline.diff(store, store)
    assert between.alike == (pipeline.open_sweep(store)["status"] == 1).sum() > 16
    assert between.points.empty
    assert margin.lowest < margin.probability == there["probability"] < margin.highest
    assert margin.sentence in words.replace("\n    ", " ")
    assert "16 samples may not suffice" in words
    irg("plot", store, "-o", tmp_path / "r.png")
    assert said("sensitivity", store, "-o", tmp_path / "s.png")["inputs"][0].startswith("wear.")
    assert len(said("infer", store, "-o", tmp_path / "p.png")["tests"]) == 1
    assert all(path.stat().st_size > 10_000 for path in tmp_path.glob("*.png"))
    printed = irg("sensitivity", store) + irg("infer", store)
    assert max(map(len, printed.splitlines())) <= 100
    duty = tmp_path / "duty.csv"
    duty.write_text("load [N],velocity [m/s],gear\n500,1.3,1\n900,2,2\n")
    first, beyond = said("margin", store, "--points", duty)
    assert (first["probability"], beyond["probability"]) == (there["probability"], None)
    ends = [first[f"distance{name} [K]"] for name in (" low", "", " high")]
    low, high = margin.intervals["distance"]
    assert ends == [low, margin.distance, high]
    assert beyond["verdict"] == "not known"
    assert "the samples have" in beyond["notes"]
    (hot,) = said("margin", store, *place, "--friction", "0.2")
    assert hot["probability"] > there["probability"]
    unweighed, crossings = irg_both("boundary", store)
    lines = [crossings[0][f"velocity, {share} % quantile [m/s]"] for share in (5, 50, 95)]
    assert lines == sorted(lines)
    rate = "wear.specific_wear_rate"
    assert rate not in [
        one["path"] for one in said("infer", store, "--at", f"{rate}=1.3e-15 m^2/N")["inputs"]
    ]
    assert "--given-measured" in unweighed
    (after, *_) = said("boundary", store, "--given-measured")
    assert after["velocity, 50 % quantile [m/s]"] != lines[1]
    load(sampled)


def test_a_store_without_samples_says_how_to_get_them(alone, irg):
    assert "give [unknown] and sweep.samples" in irg("sensitivity", alone, code=2)


def test_the_search_for_a_boundary_takes_no_samples(tmp_path):
    with pytest.raises(InputError, match="leave out --boundary-only"):
        pipeline.run_sweep(load(tmp_path), tmp_path / "out.zarr", boundary_only=0.01)


def test_the_risk_is_that_of_direct_simulations(sampled):
    ds = pipeline.open_sweep(sampled / "out.zarr")
    lines = pipeline.boundary(ds)["critical_velocity_quantile"]
    place = 200.0, lines.sel(load=200.0, quantile=0.5).item()
    verdict = risk.judged(pipeline.Ensemble.of(ds), sampled / "scene.toml", 16, {}, place)
    assert 0.2 < verdict["direct"] < 0.8  # uncertain, so that the test is sensitive
    assert abs(verdict["standard_errors_apart"]) < risk.LIMIT
    assert verdict["within_90_percent"] > 0.7  # by 8 contacts; about 0.5 if bands were wrong
    assert max(abs(verdict["bias"]), verdict["spread"]) < 2 * verdict["rise_error"] < 0.05


def test_samples_whose_inputs_are_all_fixed_answer_by_the_emulator_at_them(sampled, irg):
    values = {"friction.coefficient": 0.13, "wear.specific_wear_rate": 1.2e-15}
    at = ("--at=friction.coefficient=0.13", "--at=wear.specific_wear_rate=1.2e-6 mm^3/(N m)")
    store = sampled / "out.zarr"
    assert "friction of each sample, bulk 25 °C" in irg("boundary", store)
    assert "friction 0.13, bulk 25 °C" in irg("boundary", store, *at)
    ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    inputs = np.array([[values[one.path] for one in ensemble.unknown]])
    place = ("--load", "600 N", "--velocity", "1.5 m/s")
    (found,) = irg("margin", store, *at, *place, "--json")
    excess = ensemble.excess(inputs, 600.0, 1.5).values.item()
    limit = 145.0 - 25.0
    assert found["decisive temperature [°C]"] - 25.0 == pytest.approx(
        limit * np.exp(excess), rel=0.01
    )
    for command in ("sensitivity", "infer"):
        assert "no input of the samples is unknown" in irg(command, store, *at, code=2)

"""The posterior is that of a plain sampler: rejection, on full simulations."""

from dataclasses import replace

import pytest

import pipeline
from pipeline.uncertain.inputs import CRITICAL
from tests.helpers import rejection
from tests.helpers.scenes import SCENE

RATE = "wear.specific_wear_rate"
ENTRIES = {
    "fidelity.increments": 2,
    "fidelity.contact_tolerance": 0.1,
    "fidelity.heat_tolerance": 0.01,
    "window.pixels": [32, 8],
    "window.pixel_size": ["12 um", "16 um"],
}
UNKNOWN = f"""
[unknown]
"{CRITICAL}" = {{ mean = "145 degC", sd = "25 K" }}
"{RATE}" = {{ median = "4e-6 mm^3/(N m)", factor = 3 }}
"""
TESTS = [
    {
        "normal_load": load,
        "velocity": velocity,
        "bulk_temperature": bulk,
        "outcome": outcome,
        "friction": 0.1,
        "friction_scatter": 0.003,
    }
    for load, velocity, bulk, outcome in (
        (200.0, 3.5, 298.15, "mild"),
        (600.0, 2.4, 298.15, "severe"),
        (400.0, 2.5, 298.15, "mild"),
        (600.0, 1.7, 333.15, "severe"),
    )
]


@pytest.mark.slow
def test_the_posterior_is_that_of_rejection(tmp_path):
    count, of_mean, of_spread = 1024, 0.15, 0.08  # three standard errors, and the emulator's
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace("fields = true", "samples = 128") + UNKNOWN)
    smooth = ENTRIES | {"without": ["disk.roughness"]}
    sweep = pipeline.load_scene(path, overrides=smooth)
    pipeline.run_sweep(sweep, tmp_path / "out.zarr", workers=1)
    ensemble = pipeline.Ensemble.of(tmp_path / "out.zarr")
    posterior = pipeline.posterior(replace(ensemble, tests=tuple(TESTS)), 0.05)

    def scene_with(entries):
        alone = {"without": ["disk.roughness", "unknown", "sweep.samples"]}
        return pipeline.load_scene(path, overrides=ENTRIES | alone | entries)

    expected, effective = rejection.kept(ensemble, scene_with, TESTS, 0.05, count)
    assert effective > count / 2
    for name, mean, spread in rejection.of_draws(posterior.unknown, posterior.draws):
        assert mean == pytest.approx(expected[name][0], abs=of_mean * spread)
        assert spread == pytest.approx(expected[name][1], rel=of_spread)

"""The posterior is that of rejection on full simulations: no emulator, no likelihood, no slope.

A draw has inputs, a factor of the scatter, and errors of each test's velocity and friction. Each
test is simulated at the velocity that it then had. Tests of the outcome severe bound the critical
temperature from above, mild ones from below; so of the critical temperature, which is normal, the
part between the bounds is kept, and a draw counts by that part's probability.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtri

import pipeline
from pipeline.sweep.plan import run_point
from pipeline.sweep.severity import worst_rises
from pipeline.uncertain.evidence import FACTOR
from pipeline.uncertain.inputs import CRITICAL
from tests.helpers.scenes import SCENE
from tests.promises.risk import entries_of

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

    expected, effective = rejected(ensemble, scene_with, TESTS, 0.05, count)
    assert effective > count / 2
    for name, mean, spread in of_draws(posterior.unknown, posterior.draws):
        assert mean == pytest.approx(expected[name][0], abs=of_mean * spread)
        assert spread == pytest.approx(expected[name][1], rel=of_spread)


def rejected(ensemble, load_scene, tests, scatter, count, seed=0):
    """Mean and standard deviation of each input by its path, and the effective number of draws.

    The logarithm counts of inputs that are log-normal. `load_scene` gives the scene with the
    entries of a draw. Draws are even ones (Sobol').
    """
    others = [quantity for quantity in ensemble.unknown if quantity.path != CRITICAL]
    (critical,) = (quantity for quantity in ensemble.unknown if quantity.path == CRITICAL)
    middle, spread = critical.parameters
    points = stats.qmc.Sobol(len(others) + 1 + 2 * len(tests), rng=np.random.default_rng(seed))
    shares = np.clip(points.random(count), 1e-9, 1 - 1e-9)
    inputs = np.stack(
        [one.quantile(column) for one, column in zip(others, shares.T, strict=False)], axis=1
    )
    factor = FACTOR ** ndtri(shares[:, len(others)])
    errors = ndtri(shares[:, len(others) + 1 :]).reshape(count, len(tests), 2)
    ends = np.array(
        [
            _bounds(load_scene(entries_of(others, row)), tests, scatter * by, off)
            for row, by, off in zip(inputs, factor, errors, strict=True)
        ]
    )
    low, high = (ends.T - middle) / spread
    weights = np.maximum(stats.norm.cdf(high) - stats.norm.cdf(low), 0.0)
    weights /= weights.sum()
    part = weights > 0
    between = stats.truncnorm(low[part], high[part], middle, spread)
    moments = {CRITICAL: _moments(weights[part], between.mean(), between.var())}
    for quantity, column in zip(others, inputs.T, strict=True):
        values = np.log(column) if quantity.is_relative else column
        moments[quantity.path] = _moments(weights, values, 0.0)
    return moments, 1 / np.sum(weights**2)


def of_draws(unknown, draws):
    """Path, mean and standard deviation of each input, as `rejected` has them."""
    for quantity, column in zip(unknown, draws.inputs.T, strict=True):
        values = np.log(column) if quantity.is_relative else column
        yield quantity.path, *_moments(draws.weights, values, 0.0)


def _bounds(scene, tests, scatter, errors):
    """Critical temperatures between which all tests come out as they did [K]."""
    low, high = 0.0, math.inf
    for test, (of_velocity, of_friction) in zip(tests, errors, strict=True):
        velocity = test["velocity"] * math.exp(scatter * of_velocity)
        friction = test["friction"] + test.get("friction_scatter", 0.0) * of_friction
        columns = run_point(scene, test["normal_load"], velocity).columns
        rise = float(worst_rises(columns, test["normal_load"], scene.conditions))
        bulk = test.get("bulk_temperature", scene.conditions.bulk_temperature)
        if test["outcome"] == "severe":
            high = min(high, bulk + friction * rise)
        else:
            low = max(low, bulk + friction * rise)
        if low >= high:
            return high, high
    return low, high


def _moments(weights, means, variances):
    mean = np.sum(weights * means)
    return float(mean), math.sqrt(np.sum(weights * ((means - mean) ** 2 + variances)))

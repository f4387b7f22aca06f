"""The band of a boundary over several surfaces (pipeline/analysis/boundary.py)."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.boundary import _patches, add_band
from pipeline.analysis.transition import ABOVE, BELOW, CROSSES, MILD, SEVERAL, SEVERE, UNKNOWN


def one_turn(places, dims, axis):
    turns = (*dims, "turn"), np.array(places)[:, None, None]
    begins = dims, np.full((len(places), 1), False)
    return {f"turns_at_{axis}": turns, f"begins_severe_at_{axis}": begins}


def band(outcomes, places, computed=(1.5, 2.5)):
    """Quantiles, and the counts of surfaces that cross and that are known, at one load."""
    columns = {}
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        dims = ("realization", axis)
        columns[name] = dims, np.array(places)[:, None], {"units": "1"}
        columns[f"outcome_at_{axis}"] = dims, np.array(outcomes)[:, None]
        for end, value in zip(("from", "to"), computed, strict=True):
            columns[f"computed_{end}_at_{axis}"] = dims, np.full((len(places), 1), value)
        columns |= one_turn(places, dims, axis)
    ds = add_band(xr.Dataset(columns))
    counts = ds["crossing_at_load"].item(), ds["known_at_load"].item()
    return ds["critical_velocity_quantile"].values[:, 0], counts


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        (BELOW, [np.nan, np.nan, 2.7]),  # at most 1.5
        (ABOVE, [1.3, np.nan, np.nan]),  # at least 2.5
        (SEVERE, [np.nan, 1.5, 2.7]),
        (MILD, [1.3, 2.5, np.nan]),
        (UNKNOWN, [1.2, 2.0, 2.8]),
        (SEVERAL, [np.nan, np.nan, np.nan]),  # that never turns severe, and may do so anywhere
    ],
)
def test_quantiles_are_those_of_wherever_a_transition_may_lie(outcome, expected):
    places = [1.0, 2.0, 3.0, np.nan]
    quantiles, counts = band([CROSSES] * 3 + [outcome], places)
    np.testing.assert_allclose(quantiles, expected)
    assert counts == (3, 3 + (outcome in (MILD, SEVERE, SEVERAL)))


@pytest.mark.parametrize("patches", [1.0, 7.0, 240.0])
def test_wear_begins_at_the_first_of_many_patches_as_often_as_not(patches):
    chance = np.random.default_rng(3)
    velocities = 2.0 * np.exp(0.04 * chance.standard_normal(4000))
    columns = {}
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        dims = ("realization", axis)
        columns[name] = dims, velocities[:, None], {"units": "1"}
        columns[f"outcome_at_{axis}"] = dims, np.full((len(velocities), 1), CROSSES)
        for end, value in (("from", 1.0), ("to", 4.0)):
            columns[f"computed_{end}_at_{axis}"] = dims, np.full((len(velocities), 1), value)
        columns |= one_turn(velocities, dims, axis)
    ds = add_band(xr.Dataset(columns), patches)
    first = 2.0 * np.exp(0.04 * chance.standard_normal((4000, int(patches))).min(axis=1))
    assert ds["critical_velocity_first"].item() == pytest.approx(np.median(first), rel=4e-3)
    assert ds.attrs["patches"] == patches


def test_patches_lie_along_the_pin_and_around_the_track():
    sweep = pipeline.load_scene("irg_transition", overrides={"sweep.realizations": 3})
    assert _patches(sweep) == pytest.approx(3.4 / 0.456)
    sweep = pipeline.load_scene("irg_transition", overrides={"disk.track_length": "471 mm"})
    assert _patches(sweep) == pytest.approx(3.4 / 0.456 * 471 / 0.470016)
    assert _patches(pipeline.load_scene("ball_on_disk")) == 1.0

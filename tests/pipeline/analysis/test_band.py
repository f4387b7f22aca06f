"""The band of a boundary over several surfaces (pipeline/analysis/boundary.py)."""

import numpy as np
import pytest
import xarray as xr

from pipeline.analysis.boundary import add_band
from pipeline.analysis.transition import ABOVE, BELOW, CROSSES, MILD, SEVERAL, SEVERE, UNKNOWN


def band(outcomes, places, computed=(1.5, 2.5)):
    """Quantiles, and the counts of surfaces that cross and that are known, at one load."""
    columns = {}
    for name, axis in (("critical_velocity", "load"), ("critical_load", "velocity")):
        dims = ("realization", axis)
        columns[name] = dims, np.array(places)[:, None], {"units": "1"}
        columns[f"outcome_at_{axis}"] = dims, np.array(outcomes)[:, None]
        for end, value in zip(("from", "to"), computed, strict=True):
            columns[f"computed_{end}_at_{axis}"] = dims, np.full((len(places), 1), value)
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
        (SEVERAL, [np.nan, np.nan, 2.7]),  # severe at the lowest place, as below
    ],
)
def test_quantiles_are_those_of_wherever_a_transition_may_lie(outcome, expected):
    places = [1.0, 2.0, 3.0, np.nan]
    quantiles, counts = band([CROSSES] * 3 + [outcome], places)
    np.testing.assert_allclose(quantiles, expected)
    assert counts == (3, 3 + (outcome in (MILD, SEVERE, SEVERAL)))

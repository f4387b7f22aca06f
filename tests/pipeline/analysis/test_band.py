"""The band of a boundary over several surfaces (pipeline/analysis/boundary.py)."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.transition import CROSSES
from pipeline.store.schema import PENDING
from tests.helpers import synthetic

LOAD = 400.0


def surfaces(lifts, pending=()):
    """Sweep on surfaces whose rises differ by factors; some lack the points at one load."""
    several = [
        synthetic.sweep(rise=lambda F, V, q=1.0, lift=lift: lift * synthetic.rise(F, V, q))
        for lift in lifts
    ]
    ds = xr.concat(several, xr.Variable("realization", range(len(lifts))), combine_attrs="override")
    left_out = ds["realization"].isin(pending) & (ds["load"] == LOAD)
    return ds.assign(status=ds["status"].where(~left_out, PENDING))


@pytest.mark.parametrize(
    ("lift", "pending", "ranks"),
    [
        (1e-3, (), [0.3, 1.5, np.nan]),  # mild throughout: transition above all others
        (1e3, (), [np.nan, 0.5, 1.7]),  # severe throughout: transition below all others
        (1.0, (3,), [0.2, 1.0, 1.8]),  # unknown
    ],
)
def test_quantiles_are_those_of_wherever_a_transition_may_lie(lift, pending, ranks):
    lifts = (1.1, 1.0, 0.9)
    alone = [pipeline.boundary(surfaces([one])).sel(load=LOAD) for one in lifts]
    velocities = [one["critical_velocity"].item() for one in alone]
    found = pipeline.boundary(surfaces([*lifts, lift], pending)).sel(load=LOAD)
    expected = np.interp(ranks, range(3), velocities)
    np.testing.assert_allclose(found["critical_velocity_quantile"], expected, rtol=1e-12)
    assert (found["outcome_at_load"] == CROSSES).sum() == 3

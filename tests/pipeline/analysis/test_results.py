"""Results are read anew for each question, and know their dataset no more."""

import numpy as np
import pytest

import pipeline
from tests.helpers import synthetic


def _velocities(source):
    return pipeline.boundary(source)["critical_velocity"].values


def double(ds, name):
    ds[name] = 2 * ds[name]


def rub(ds, _):
    ds.attrs["at"] = '{"friction.coefficient": 0.2}'


@pytest.mark.parametrize(
    ("change", "name"),
    [(double, "rise_quantile"), (double, "status"), (double, "velocity"), (rub, "")],
)
def test_what_is_changed_in_place_changes_the_next_answer(change, name):
    ds = synthetic.sweep().load()
    before = _velocities(ds)
    change(ds, name)
    assert not np.array_equal(_velocities(ds), before, equal_nan=True)


def test_results_that_are_kept_answer_as_they_were_read():
    ds = synthetic.sweep().load()
    held = pipeline.results(ds)
    before = _velocities(held)
    for name in ("rise_quantile", "max_rise", "mean_rise", "normal_load", "status"):
        ds[name][:] = 0
    ds["velocity"] = 2 * ds["velocity"]
    ds.attrs["at"] = '{"friction.coefficient": 0.2}'
    assert np.array_equal(_velocities(held), before, equal_nan=True)
    assert np.array_equal(_velocities(pipeline.results(held)), before, equal_nan=True)

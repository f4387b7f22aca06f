"""A place at the edge of a sweep is met to the six digits in which edges are printed."""

import pytest

import pipeline
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import asked, named


@pytest.mark.parametrize("place", [("168.6068 lbf", "4 m/s"), ("750.001 N", "4.00001 m/s")])
def test_a_place_beyond_the_edge_by_rounding_is_the_edge(place):
    ds = synthetic.sweep()
    edge, here = asked(ds, 750.0, 4.0), asked(ds, *place)
    assert here.probability == pytest.approx(edge.probability, rel=1e-6)
    assert (here.load, here.velocity) == pytest.approx((750.0, 4.0), rel=1e-5)


@pytest.mark.parametrize("place", [("751 N", "4 m/s"), ("750 N", "4.001 m/s")])
def test_a_place_beyond_by_more_than_rounding_is_refused(place):
    here = asked(synthetic.sweep(), *place)
    assert here.verdict == "unknown"
    assert "is outside the sweep" in here.reason


def test_loads_without_a_point_that_is_done_are_unknown_beside_others_that_are_known():
    later = [load for load in synthetic.LOADS.tolist() if load > 450]
    waits = {(load, speed): PENDING for load in later for speed in synthetic.VELOCITIES.tolist()}
    found = pipeline.boundary(synthetic.sweep(status=waits)).sel(load=later)
    assert {*named(found["outcome_along_velocity"])} == {"unknown"}
    assert found["critical_velocity"].isnull().all()

"""The verdict outside a sweep is unknown until the point is simulated."""

import pytest

import pipeline
from pipeline.store.create import writing
from pipeline.store.dataset import store_dataset
from pipeline.store.schema import PENDING
from tests.helpers import synthetic, tiny
from tests.helpers.answer_at import asked, named
from tests.helpers.entries import placed_rows


def test_what_to_do_outside_depends_on_the_kind_of_sweep():
    def reason(ds, *point):
        return asked(ds, *point).reason

    assert reason(synthetic.sweep(), 900.0, 5.0).endswith(
        "velocity 5 m/s is outside the sweep (0.5 to 4 m/s); add it to sweep.loads and "
        "sweep.velocities, and run the scene again"
    )
    case = tiny.sweep(case_table=placed_rows((250.0, 1.0)))
    with writing(None, case) as store:
        rows = pipeline.margin(store_dataset(store).load(), 300.0, 1.0)
    assert rows["reason"].item() == (
        "load 300 N, velocity 1 m/s is not a case of the sweep, in which each case has its own "
        "load and velocity; add it to sweep.along, and run the scene again"
    )


@pytest.mark.parametrize("point", [("168.6068 lbf", "4 m/s"), ("750.001 N", "4.00001 m/s")])
def test_a_place_beyond_the_edge_by_rounding_is_the_edge(point):
    ds = synthetic.sweep()
    edge, beyond = asked(ds, 750.0, 4.0), asked(ds, *point)
    assert beyond.probability == pytest.approx(edge.probability, rel=1e-6)
    assert (beyond.load, beyond.velocity) == pytest.approx((750.0, 4.0), rel=1e-5)


def test_loads_without_a_point_that_is_done_are_unknown_beside_others_that_are_known():
    later = [load for load in synthetic.LOADS.tolist() if load > 450]
    waits = {(load, speed): PENDING for load in later for speed in synthetic.VELOCITIES.tolist()}
    boundary = pipeline.boundary(synthetic.sweep(status=waits)).sel(load=later)
    assert {*named(boundary["outcome_along_velocity"])} == {"unknown"}
    assert boundary["critical_velocity"].isnull().all()

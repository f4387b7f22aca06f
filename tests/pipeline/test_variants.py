"""A table of variants made by hand, from the run to its answers."""

import numpy as np
import pytest

import pipeline
from pipeline.store.place import StoreMismatchError
from pipeline.sweep.plan import run_point
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.pipeline.conftest import commit_all
from tribo import InputError, Wear

OILS = {"thin": {}, "thick": {"temperature.critical": "165 degC"}}
CASES = {
    "slim": {"pin.radius": 6e-3, "pin.length": 3e-3},
    "wears": {"wear.specific_wear_rate": 2.4e-15},
    "as it is": {},
}
TABLE = surfaces((1, 2)) * rows("fluid", OILS) * rows("case", CASES)
PLACE = ("--load", "300 N", "--velocity", "1.2 m/s")


def sweep(**changes):
    return tiny.sweep(loads=(250.0, 600.0), **changes)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("variants") / "out.zarr"
    table = surfaces((1,)) * rows("fluid", OILS) * rows("case", CASES)
    first = pipeline.run_sweep(sweep(variants=table), path, workers=1)
    resumed = pipeline.run_sweep(sweep(variants=TABLE), path, workers=2)
    assert (first.computed, resumed.computed, resumed.failed) == (36, 36, ())
    return path


def test_a_row_is_the_scene_with_what_it_changes(store):
    ds = pipeline.open_sweep(store)
    assert ds["max_rise"].dims[:3] == ("realization", "fluid", "case")
    scene = sweep(wear=Wear(2.4e-15)).take_surface(2)
    rise = pipeline.end_of_point(ds)["max_rise"].sel(realization=2, case="wears", load=600.0)
    expected = run_point(scene, 600.0, 1.0).columns["max_rise"][-1]
    assert rise.sel(velocity=1.0).values == pytest.approx([expected, expected], rel=1e-9)


def test_rows_that_differ_in_the_oil_alone_share_contacts_and_heat():
    asked = sweep(variants=TABLE)
    leads = {lead.variant for lead in asked.leads.values()}
    # Twice the wear rate has the contacts of twice the velocity.
    assert len(leads) == 2 * (len(CASES) - 1)
    assert all(dict(name)["fluid"] == "thin" for name in leads)


def test_each_row_has_a_boundary_with_its_own_limit(store):
    boundary = pipeline.boundary(store)
    critical = boundary["critical_velocity"].sel(load=600.0, case="as it is")
    thin, thick = (critical.sel(fluid=oil) for oil in OILS)
    both = np.isfinite(thin) & np.isfinite(thick)
    assert (thick > thin).where(both, True).all()
    for oil in OILS:
        alone = pipeline.boundary(pipeline.at(store, fluid=oil, case="slim"))
        there = boundary["critical_velocity"].sel(fluid=oil, case="slim")
        assert np.array_equal(alone["critical_velocity"], there, equal_nan=True)


def test_commands_answer_for_each_row(store, irg):
    said = irg("margin", store, *PLACE)
    assert all(case in said for case in CASES)


def test_rows_have_places_of_their_own(tmp_path):
    own = rows("test", {0: {}, 1: {"pin.radius": 6e-3}}, velocities=[0.5, 1.5], loads=[250, 600.0])
    path = tmp_path / "places.zarr"
    commit_all(path, sweep(variants=own))
    progress = pipeline.summary(path)
    assert (progress.total, progress.done) == (2, 2)
    ds = pipeline.open_sweep(path)
    assert ds["velocity"].dims == ds["load"].dims == ds["status"].dims == ("test",)
    assert ds["load"].values.tolist() == [250.0, 600.0]
    assert (ds["normal_load"].sel(step=0) == ds["load"]).all()
    with pytest.raises(InputError, match="so there is no plane"):
        pipeline.boundary(path)


def test_a_row_that_moved_is_another_store(tmp_path):
    def run(velocity):
        moved = rows("variant", {0: {}, 1: {"pin.radius": 6e-3}}, velocities=[0.5, velocity])
        commit_all(tmp_path / "out.zarr", sweep(variants=moved))

    run(1.5)
    with pytest.raises(StoreMismatchError, match=r"velocity\.1: 1\.5 in the store, 1\.0 in"):
        run(1.0)

"""A place outside a sweep is unknown, and gets the command that simulates it, which works."""

import shlex

import pytest

import pipeline
from pipeline.cli.values import setting
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import asked, named
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Working directory with a space in its path, a scene, and its store in results."""
    folder = tmp_path / "my rig"
    (folder / "results").mkdir(parents=True)
    (folder / "rig.toml").write_text(
        SCENE.replace(', "600 N"]', "]").replace(', "4 m/s"]', "]"), encoding="utf-8"
    )
    monkeypatch.chdir(folder)
    return folder


def extend(said):
    """Simulate what the command at the end of a message asks for, without its worker processes."""
    irg, run, scene, *rest = shlex.split(said.partition("to extend the sweep: ")[2])
    assert (irg, run) == ("irg", "run")
    store = rest.pop(1) if rest[0] == "-o" else "results/rig.zarr"
    changes = dict(map(setting, (one for one in rest if one not in ("-o", "--set"))))
    commit_all(store, pipeline.load_scene(scene, overrides=changes))


@pytest.mark.parametrize("store", ["results/rig.zarr", "the plane.zarr"])
def test_the_command_beside_a_place_outside_adds_it_to_the_store(folder, store):
    commit_all(store, pipeline.load_scene("rig.toml"))
    for load, velocity in ((150.0, 1.5), (100.0, 5.0)):
        before = asked(pipeline.open_sweep(store), load, velocity)
        assert before.verdict == "unknown"
        assert ("-o" in before.reason) == (store != "results/rig.zarr")
        extend(before.reason)
        after = asked(pipeline.open_sweep(store), load, velocity)
        assert after.verdict != "unknown"


def test_the_command_beside_an_entrys_value_adds_its_case(folder, irg):
    over = {"sweep.over.pin.radius": ["2 mm", "3 mm"]}
    commit_all("over.zarr", pipeline.load_scene("rig.toml", overrides=over))
    place = ("margin", "over.zarr", "--at", "pin.radius=4 mm", "--load=300 N", "--velocity=1 m/s")
    extend(irg(*place, code=2))
    assert "undecided" in irg(*place).lower()


@pytest.mark.parametrize("place", [(-1.0, 2.0), (400.0, 0.0), (float("inf"), 2.0), (400.0, 9e9)])
def test_no_command_is_given_for_a_place_that_cannot_be_simulated(place):
    here = asked(synthetic.sweep(), *place)
    is_possible = min(place) > 0 and max(place) < 1e10
    assert ("to extend the sweep: irg run" in here.reason) == is_possible
    assert is_possible or "give a value inside it" in here.reason


@pytest.mark.parametrize("place", [("168.6068 lbf", "4 m/s"), ("750.001 N", "4.00001 m/s")])
def test_a_place_beyond_the_edge_by_rounding_is_the_edge(place):
    ds = synthetic.sweep()
    edge, here = asked(ds, 750.0, 4.0), asked(ds, *place)
    assert here.probability == pytest.approx(edge.probability, rel=1e-6)
    assert (here.load, here.velocity) == pytest.approx((750.0, 4.0), rel=1e-5)


def test_loads_without_a_point_that_is_done_are_unknown_beside_others_that_are_known():
    later = [load for load in synthetic.LOADS.tolist() if load > 450]
    waits = {(load, speed): PENDING for load in later for speed in synthetic.VELOCITIES.tolist()}
    found = pipeline.boundary(synthetic.sweep(status=waits)).sel(load=later)
    assert {*named(found["outcome_along_velocity"])} == {"unknown"}
    assert found["critical_velocity"].isnull().all()

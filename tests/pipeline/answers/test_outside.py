"""A place outside a sweep gets the command that simulates it, and this command works."""

import shlex

import pytest

import pipeline
from pipeline.cli.values import setting
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
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

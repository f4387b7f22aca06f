"""Physics beside the half-spaces: entries that cost no simulation, one for all answers."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline import Conditions
from tests.helpers import tiny
from tests.helpers.scenes import SCENE
from tests.helpers.sweeps import with_fields
from tests.pipeline.conftest import commit_all

STEEL = tiny.sweep().scene.disk
ALL = tribo.Corrections(
    friction=tribo.Friction(by_velocity=((0.5, 1.1), (1.5, 0.9))),
    track=tribo.Track.under(tiny.sweep().scene.pin, STEEL, 0.34),
)
CONDITIONS = Conditions(0.1, 298.15, 345.0)
BESIDE = """extends = "plain.toml"
disk.track_length = "34 cm"
friction.by_velocity = [
  { velocity = "1.5 m/s", coefficient = 0.09 }, { velocity = "50 cm/s", coefficient = 0.11 },
]
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    store = tmp_path_factory.mktemp("corrected") / "tiny.zarr"
    commit_all(store, tiny.full(conditions=CONDITIONS))
    return store


def test_the_map_of_a_point_is_as_hot_as_its_corrected_temperature(store):
    ds = with_fields(pipeline.open_sweep(store), conditions=replace(CONDITIONS, corrections=ALL))
    hottest = pipeline.temperatures(ds)["max_temperature"].sel(load=600, velocity=1.0)[-1].item()
    figure = pipeline.plot(ds, "fields", load=600.0, velocity=1.0)
    _, temperature, _ = (axes.collections[0].get_array() for axes in figure.axes[:3])
    assert temperature.max() == pytest.approx(hottest - 273.15)


def test_corrections_cost_no_point_and_change_no_stored_number(store):
    plain = pipeline.open_sweep(store).load()
    sweep = tiny.full(conditions=replace(CONDITIONS, corrections=ALL))
    assert not pipeline.run_sweep(sweep, store, workers=1).computed
    ds = pipeline.open_sweep(store)
    stored = [one.drop_attrs() for one in (ds, plain)]
    assert stored[0].equals(stored[1])
    assert "; " in pipeline.boundary(ds).attrs["conditions"]
    commit_all(store, tiny.full(conditions=CONDITIONS))


def test_bodies_that_roll_have_a_track_each(tmp_path, irg):
    """A diameter stands for its circumference, over which the pin's wear also spreads."""
    (tmp_path / "plain.toml").write_text(SCENE)
    entries = {"motion": {"slide_roll_ratio": 0.5}, "pin.diameter": "10 cm", "pin.width": "1 cm"}
    entries |= {"disk.track_length": "40 cm"}
    scene = pipeline.load_scene(tmp_path / "plain.toml", overrides=entries)
    corrections = scene.conditions.corrections
    assert corrections.pin_track.length == pytest.approx(np.pi * 0.1) == scene.scene.track_length
    assert corrections.track.length == 0.4
    assert corrections.motion == scene.scene.motion
    for wrong, problem in (
        ({"pin.track_length": "314 mm"}, "would count one heat twice; give one of them"),
        ({"motion.track_length": "200 mm"}, "motion.track_length: 200 mm is not the 314.159 mm"),
        ({"pin.diameter": "0.2 mm"}, "pin.diameter: the track is 0.6283 mm long"),
    ):
        with pytest.raises(pipeline.SceneFileError) as error:
            pipeline.load_scene(tmp_path / "plain.toml", overrides=entries | wrong)
        assert problem in str(error.value)

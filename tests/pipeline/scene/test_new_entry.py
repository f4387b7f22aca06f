"""A new entry is a line of the format and a field in `tribo`: all else follows from the two."""

from dataclasses import dataclass, make_dataclass

import pytest

import pipeline
import tribo
from pipeline.scene.declare import Entry, table_of
from pipeline.scene.format import RandomSurface
from pipeline.scene.kept import sweep_text, text_sweep
from pipeline.scene.kinds import Quantity
from pipeline.scene.reference import all_keys
from pipeline.scene.resume import misfits
from pipeline.scene.written import differing
from pipeline.sweep.identity import scene_ids

PATH = "disk.roughness.waviness"
VALUES = {"2 um": 2e-6, "0.003 mm": 3e-6}


@dataclass(frozen=True)
class Wavy(tribo.SelfAffineRoughness):
    """The line in `tribo`."""

    waviness: float = 0.0


Wavy.__module__ = "tribo"  # as a class that ships


@pytest.fixture
def scenes(monkeypatch):
    """Scenes with each value of an entry of which only its two lines are there."""
    table = table_of(RandomSurface)
    line = Entry(Quantity("1 um"), "Height of the waves.", default=0.0)
    monkeypatch.setitem(table.keys, "waviness", line)
    asked = make_dataclass(
        "RandomSurface", [("waviness", float)], bases=(RandomSurface,), frozen=True, kw_only=True
    )
    monkeypatch.setitem(table.__dict__, "make", asked)
    monkeypatch.setattr(tribo, "SelfAffineRoughness", Wavy)
    return [pipeline.load_scene("first_try", overrides={PATH: text}) for text in VALUES]


def test_it_is_read_simulated_and_told(scenes):
    assert [scene.scene.roughness.waviness for scene in scenes] == [*VALUES.values()]
    assert PATH in dict(all_keys())
    with pytest.raises(pipeline.SceneFileError, match="2 has no unit; give a length above 0"):
        pipeline.load_scene("first_try", overrides={PATH: 2})


def test_a_store_keeps_it_and_tells_its_values_apart(scenes):
    one, other = scenes
    assert text_sweep(sweep_text(one), {}) == one != other
    assert scene_ids(one, {}) != scene_ids(other, {})
    assert [*differing(one, other)] == [(PATH, "2 µm", "0.003 mm")]
    assert [*misfits(one, other)] == [f"{PATH}: 2 µm in the store, 0.003 mm in the scene"]


def test_it_takes_several_values_and_a_row_reads_its_table_alone(scenes):
    over = {"sweep.over": {PATH: [*VALUES]}}
    sweep = pipeline.load_scene("first_try", overrides=over)
    rows = [sweep.variant(name) for name in sweep.variants.names]
    assert [row.scene.roughness.waviness for row in rows] == [*VALUES.values()]
    assert rows[1].parts().declared.pin is sweep.parts().declared.pin

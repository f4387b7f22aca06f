"""A store keeps a sweep as plain data in SI."""

from dataclasses import replace

import pytest

import pipeline
import tribo
from pipeline.answers.results import sweep_of
from pipeline.scene import library
from pipeline.scene.format import RandomSurface
from pipeline.scene.table_kinds import TableKind
from tests.helpers.scenes import SCENE
from tests.helpers.stored import file_contents, parse_sweep, sweep_text
from tests.helpers.stores import commit


def back(sweep):
    """Sweep read again from its stored data."""
    return parse_sweep(sweep_text(sweep), file_contents(sweep))


def test_a_store_keeps_its_meaning_when_the_program_changes(tmp_path, monkeypatch):
    """Change a default of the format, a preset, and a value of the library."""
    scene, path = tmp_path / "own.toml", tmp_path / "own.zarr"
    without = 'without = ["materials", "disk.roughness.seed", "fidelity"]\n'
    steel = 'pin.material = "AISI 52100"\ndisk.material = "AISI 52100"\nsweep.fields = false\n'
    (tmp_path / "base.toml").write_text(SCENE)
    scene.write_text(f'extends = "base.toml"\n{without}{steel}')
    sweep = pipeline.load_scene(scene)
    commit(path, sweep, ())
    keys, finer = TableKind(RandomSurface).keys, {"contact_tolerance": 1e-3}
    monkeypatch.setitem(keys, "seed", keys["seed"]._replace(default=1))
    standard = replace(tribo.PRESETS["standard"], **finer)
    monkeypatch.setitem(tribo.PRESETS, "standard", standard)
    values = library.library()["materials"]["AISI 52100"]
    monkeypatch.setitem(values, "density", ["7000 kg/m^3", values["density"][1]])
    reread = sweep_of(pipeline.open_sweep(path))
    assert reread == sweep != pipeline.load_scene(scene)
    assert reread.preset == sweep.preset == "standard"
    with pytest.raises(pipeline.StoreMismatchError) as caught:
        commit(path, pipeline.load_scene(scene), ())
    for entry in (
        "disk.roughness.seed: 0 in the store, 1 in the scene",
        "fidelity.contact_tolerance: 0.12 in the store, 0.001 in the scene",
        "material of the pin.density: ",
    ):
        assert entry in str(caught.value)


def test_a_stored_sweep_made_coarser_keeps_no_promise_of_its_preset():
    scene = pipeline.load_scene("first_try")
    assert back(scene).preset == "standard"
    for path, value in (("pixels_per_element", 16), ("increments", 2), ("fewest_elements", 1)):
        assert back(scene.changed(f"fidelity.{path}", value)).preset is None
    assert back(scene.changed("fidelity.preset", "fine")).preset == "fine"

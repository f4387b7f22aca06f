"""The complete text of a scene reads as that scene."""

import json
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.quantities import DIMENSIONS
from pipeline.scene.declare import table_of
from pipeline.scene.document import read_document
from pipeline.scene.faults import Faults
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import Quantity
from pipeline.scene.library import resolve_library
from pipeline.scene.shipped import shipped_scenes
from pipeline.scene.units import si_unit, to_si
from pipeline.scene.written import complete_fidelity, entries_of


def read(entries):
    faults = Faults(has_kept=True)
    scene = table_of(SceneFile).read(entries, "", faults)
    assert not faults
    return scene


@pytest.mark.parametrize("name", shipped_scenes())
def test_the_complete_text_of_a_scene_reads_as_the_scene(name):
    document = read_document(shipped_scenes()[name], Faults())
    entries, _ = resolve_library(document.entries(), Faults())
    scene = read({key: value for key, value in entries.items() if key != "unknown"})
    made = pipeline.load_scene(name).scene.fidelity
    preset = scene.fidelity.preset if scene.fidelity else "standard"
    scene = replace(scene, fidelity=complete_fidelity(preset, made))
    text = json.dumps(entries_of(table_of(SceneFile), scene), ensure_ascii=False)
    assert read(json.loads(text)) == scene
    assert "degC" in text


@pytest.mark.parametrize("example", ["2 mm", "25 degC", "1.2e-6 mm^3/(N m)", "20 1/GPa", "4 s"])
def test_a_quantity_is_written_so_that_the_same_number_is_read(example):
    kind = Quantity(example)
    low, high = (to_si(end, example) for end in DIMENSIONS[si_unit(example)].limits)
    for value in np.geomspace(1.01 * max(low, 1e-25), 0.99 * high, 997).tolist():
        assert to_si(entries_of(kind, value), example) == value

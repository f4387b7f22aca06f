"""The shipped scan: made by its script, and simulated on areas whose difference answers state."""

import numpy as np
import pytest

import pipeline
from pipeline.shipped import WORKFLOWS
from tests.helpers.stores import commit_all
from workflows.make_scan import make_scan


def test_the_shipped_scan_is_what_its_script_writes():
    np.testing.assert_array_equal(np.load(WORKFLOWS / "scan.npy"), make_scan())


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    overrides = {"sweep.loads": ["600 N", "750 N"], "sweep.velocities": ["0.8 m/s", "1.2 m/s"],
                 "fidelity.increments": 4}  # fmt: skip
    sweep = pipeline.load_scene("scan", overrides=overrides)
    assert [dict(case.name)["realization"] for case in sweep.cases] == [0, 1, 2]
    store = tmp_path_factory.mktemp("scan") / "scan.zarr"
    commit_all(store, sweep)
    return pipeline.open_sweep(store)


def test_answers_state_surface_sampling_by_the_areas_of_a_scan(swept):
    """The mean of three areas is known better than one, and is their mean."""
    point = {"load": "600 N", "velocity": "0.8 m/s"}
    scan_answer = pipeline.margin(swept, **point)
    area_answers = [pipeline.margin(swept.sel(realization=[area]), **point) for area in range(3)]
    errors = [float(answer["temperature_error_surface"]) for answer in area_answers]
    assert 0 < float(scan_answer["temperature_error_surface"]) < max(errors)
    rises = [float(answer["governing_temperature"]) for answer in area_answers]
    assert len({*rises}) == 3
    assert float(scan_answer["governing_temperature"]) == pytest.approx(np.mean(rises), abs=0.5)


def test_a_sweep_of_a_scan_is_drawn_by_default_as_its_diagram(swept):
    """Its store also has the measured heights, as inputs of the scene."""
    axes = pipeline.plot(swept).axes[0]
    assert axes.get_xlabel().startswith("sliding velocity")
    assert axes.get_xlim() == (0.8, 1.2)

"""The shipped scan: made by its script, and simulated on areas whose difference answers state."""

import numpy as np
import pytest

import pipeline
from pipeline.shipped import WORKFLOWS
from workflows.make_scan import make_scan


def test_the_shipped_scan_is_what_its_script_writes():
    np.testing.assert_array_equal(np.load(WORKFLOWS / "scan.npy"), make_scan())


def test_answers_state_surface_sampling_by_the_areas_of_a_scan(tmp_path):
    """The mean of three areas is known better than one, and is their mean."""
    overrides = {"sweep.loads": ["600 N"], "sweep.velocities": ["0.8 m/s", "1.2 m/s"]}
    sweep = pipeline.load_scene("scan", overrides=overrides)
    assert [dict(case.name)["realization"] for case in sweep.cases] == [0, 1, 2]
    pipeline.run_sweep(sweep, tmp_path / "scan.zarr", workers=1)
    ds = pipeline.open_sweep(tmp_path / "scan.zarr")
    point = {"load": "600 N", "velocity": "0.8 m/s"}
    scan_answer = pipeline.margin(ds, **point)
    area_answers = [pipeline.margin(ds.sel(realization=[area]), **point) for area in range(3)]
    errors = [float(answer["temperature_error_surface"]) for answer in area_answers]
    assert 0 < float(scan_answer["temperature_error_surface"]) < max(errors)
    rises = [float(answer["governing_temperature"]) for answer in area_answers]
    assert len({*rises}) == 3
    assert float(scan_answer["governing_temperature"]) == pytest.approx(np.mean(rises), abs=0.5)

"""Processor time against the error of the boundary, measured on a small scene."""

import pytest

import pipeline

SMALL = {
    "without": ["tests"],
    "window.pixels": [96, 48],
    "window.pixel_size": ["5 um", "5 um"],
    "disk.roughness.correlation_length": "12 um",
    "sweep.loads": ["200 N", "750 N"],
    "sweep.velocities": {"from": "0.5 m/s", "to": "8 m/s", "count": 4},
}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    out = tmp_path_factory.mktemp("trade") / "trade.zarr"
    scene = pipeline.load_scene("first_try", overrides=SMALL)
    found = pipeline.trade(scene, out, accuracies=(0.2, 0.1), workers=1)
    return found, out


def test_smaller_errors_cost_more_and_go_on_in_one_store(measured):
    found, out = measured
    first, second = found.runs
    assert second.error <= 0.1
    assert first.error <= 0.2
    assert first.points <= second.points == pipeline.summary(out).done
    assert first.seconds > 0
    assert second.seconds > 0


def test_planes_have_all_points_and_slower_presets_err_less(measured):
    planes = measured[0].planes
    assert [(one.preset, one.has_steps) for one in planes] == [
        ("standard", False), ("standard", True), ("fine", False), ("reference", False),
    ]  # fmt: skip
    assert {one.points for one in planes} == {8}
    errors = [one.error for one in planes if not one.has_steps]
    assert errors == sorted(errors, reverse=True)
    assert all(one.seconds > 0 for one in planes)


def test_table_and_figure_have_each_run(measured, tmp_path):
    found = measured[0]
    errors = [100 * one.error for one in (*found.runs, *found.planes)]
    assert found.table["numerical error [%]"].tolist() == pytest.approx(errors, rel=1e-2)
    assert "accuracy 10%" in str(found)
    assert pipeline.plot(found, out=tmp_path / "trade.svg").exists()

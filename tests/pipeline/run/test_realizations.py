"""Sweeps over several random surfaces."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline import run_sweep
from pipeline.sweep.case_table import surfaces
from pipeline.sweep.plan import points
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.scenes import SCENE

SEEDS = (4, 1)


def several(seeds=SEEDS):
    return tiny.full(case_table=surfaces(seeds), loads=(150.0, 600.0), velocities=(0.5, 1.5))


def alone_on(seed):
    """The same sweep on a single surface, without realizations."""
    plain = several(())
    return changed(plain, roughness=replace(plain.scene.roughness, seed=seed))


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    path = tmp_path_factory.mktemp("several") / "several.zarr"
    outcome = run_sweep(several(), path, workers=2)
    assert (outcome.total, outcome.computed, outcome.failed) == (8, 8, ())
    return path


def test_a_point_among_others_equals_the_point_alone_bit_for_bit(swept):
    ds = pipeline.open_sweep(swept)
    assert ds["realization"].values.tolist() == sorted(SEEDS)
    for point in points(several()):
        seed = dict(point.case)["realization"]
        expected = pipeline.run_point(alone_on(seed), point.load, point.velocity)
        stored = ds.sel(realization=seed, load=point.load, velocity=point.velocity)
        for name, values in expected.columns.items():
            assert stored[name].values[-len(values) :].tobytes() == values.tobytes()
        for name, field in expected.fields.items():  # only the first surface has them
            if seed == min(SEEDS):
                assert stored[name].values.tobytes() == field.astype(np.float32).tobytes()
            else:
                assert stored[name].isnull().all()
    first, second = (ds["max_rise"].sel(realization=seed).values for seed in SEEDS)
    assert not np.array_equal(first, second, equal_nan=True)


def test_commands_answer_for_several_surfaces(swept, tmp_path, irg):
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.replace("fields = true", "realizations = 2"))
    assert "18: 3 loads, 3 velocities, 2 surfaces" in irg("check", scene)
    assert "8 points: 8 done" in irg("status", swept)
    document = irg("boundary", swept, "--json")
    assert [row["outcome"] for row in document] == ["mild"] * 2
    place = ["--load", "400 N", "--velocity", "2 m/s", "--realization", "1", "--json"]
    (point,) = irg("point", scene, *place)
    take_surface = pipeline.load_scene(scene)._take_surface(1)
    rise = 0.1 * pipeline.run_point(take_surface, 400.0, 2.0).columns["max_rise"][-1]
    assert point["highest temperature [°C]"] == pytest.approx(25 + rise, rel=1e-12)

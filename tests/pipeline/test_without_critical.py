"""A scene without a critical temperature can do all that needs none."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

import pipeline
from tests.helpers import tiny
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all
from tribo import InputError

mpl.use("agg")
KNOWN = tiny.sweep(fields=True).conditions
UNKNOWN = replace(KNOWN, critical_temperature=None)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("unknown") / "out.zarr"
    commit_all(path, tiny.sweep(fields=True, conditions=UNKNOWN))
    return path


def test_temperatures_are_known_and_the_failed_share_is_not(store):
    ds = pipeline.temperatures(store)
    assert np.isfinite(ds["max_temperature"].values).any()
    assert "failed_area_fraction" not in ds


def test_the_boundary_asks_for_it_by_its_key(store):
    ds = pipeline.open_sweep(store)
    for judge in (pipeline.boundary, lambda ds: pipeline.plot(ds, "diagram", "figure.png")):
        with pytest.raises(InputError, match=r"temperature\.critical.*--critical-temperature"):
            judge(ds)
    assert pipeline.plot(ds, "ramp").axes
    crossings = pipeline.boundary(ds, critical_temperature=330.0)
    assert crossings["critical_velocity"].notnull().any()


def test_a_scene_file_may_leave_it_out(tmp_path, irg):
    (tmp_path / "known.toml").write_text(SCENE)
    scene = tmp_path / "scene.toml"
    scene.write_text('extends = "known.toml"\nwithout = ["temperature.critical"]\n')
    assert pipeline.load_scene(scene).conditions == UNKNOWN
    place = ["--load", "200 N", "--velocity", "1 m/s"]
    (row,) = irg("point", scene, *place, "--json")
    assert "verdict" not in row
    assert row["highest temperature [°C]"] > 25
    assert "without temperature.critical there is no verdict" in irg("point", scene, *place)
    out = str(tmp_path / "out.zarr")
    assert "temperature.critical" in irg(
        "run", scene, "--accuracy", "2%", "-o", out, "--workers", "1", code=2
    )

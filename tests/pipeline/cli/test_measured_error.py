"""The error of a scene's own numerical choices: not known, and then measured on its store."""

import pytest
import xarray as xr

from tests.helpers.scenes import SCENE

PLACE = ("--load", "600 N", "--velocity", "2 m/s")
NOT_KNOWN = "how far boundary velocities err is not known; irg run SCENE -o STORE --measure"


@pytest.fixture
def scene(tmp_path):
    coarse = SCENE.replace("pixels_per_element = 1\nincrements = 10", "increments = 3")
    (tmp_path / "small.toml").write_text(coarse.replace('"400 N", ', ""))
    return tmp_path / "small.toml"


def test_an_error_that_nobody_asked_for_is_measured_later_on_the_finished_store(
    scene, tmp_path, irg, irg_both
):
    run = ("run", scene, "-o", tmp_path / "a.zarr", "--workers", 1)
    assert "not known; irg run SCENE -o STORE --measure measures it" in irg("check", scene)
    assert NOT_KNOWN in irg(*run)
    before = xr.open_zarr(tmp_path / "a.zarr").load()
    said, unknown = irg_both("margin", tmp_path / "a.zarr", *PLACE)
    assert said.startswith("Not decided: severe wear is ")
    assert " likely, numerical error not known, " in said
    assert unknown[0]["temperature error [K]"] is None
    assert NOT_KNOWN in irg("boundary", tmp_path / "a.zarr")
    assert NOT_KNOWN in irg("status", tmp_path / "a.zarr")

    document = irg(*run, "--measure", "--json")
    assert document["computed"] == 0
    assert before.equals(
        xr.open_zarr(tmp_path / "a.zarr").load().assign_coords(scene_id=before.scene_id)
    )
    (known,) = irg("margin", tmp_path / "a.zarr", *PLACE, "--json")
    assert known["temperature error [K]"] > 0
    assert known["probability"] == unknown[0]["probability"]
    assert "the scene's own fidelity; boundary velocities err" in irg("status", tmp_path / "a.zarr")

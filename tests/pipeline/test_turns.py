"""Bodies that roll as if each turn met a cold track say so, with the size of what is missing."""

import numpy as np

import pipeline
from tests.pipeline.conftest import commit_all

BOTH = "earlier turns of the pin and the disk are not counted"


def test_commands_say_what_a_scene_of_cold_discs_leaves_out(tmp_path, irg):
    scene, store = tmp_path / "cold.toml", tmp_path / "cold.zarr"
    scene.write_text(
        'extends = "twin_disc"\n'
        'without = ["pin.diameter", "pin.width", "disk.diameter", "disk.width"]\n'
        'motion.track_length = "314 mm"\nfidelity.preset = "draft"\n'
        'sweep.loads = ["3 kN"]\nsweep.velocities = ["4 m/s", "5 m/s", "6 m/s", "7 m/s"]\n'
    )
    assert BOTH in irg("check", scene)
    assert f"warning: {BOTH}" in irg("point", scene, "--load=3 kN", "--velocity=6.6 m/s")
    commit_all(store, pipeline.load_scene(scene))
    said = " ".join(irg("boundary", store).split())
    assert "would move the critical velocities by -25 to -25 %" in said
    cold = pipeline.boundary(pipeline.open_sweep(store))["critical_velocity"].item()
    warm = {"pin.track_length": "314.159 mm", "disk.track_length": "314.159 mm"}
    commit_all(store, pipeline.load_scene(scene, overrides=warm))
    assert "would move" not in irg("boundary", store)
    moved = pipeline.boundary(pipeline.open_sweep(store))["critical_velocity"].item() / cold - 1
    assert np.round(100 * moved) == -25

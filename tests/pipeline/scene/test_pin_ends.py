"""The whole pin with its ends, as a scene file has it."""

import pytest

import pipeline
import tribo
from pipeline import load_scene
from tests.helpers.stored import parse_sweep, sweep_text

RELIEF = {"depth": "2 um", "length": "0.3 mm"}
SHORT = {
    "pin.length": "0.5 mm", "disk.roughness.correlation_length": "16 um",
    "window": {"pixels": [96, 96], "pixel_size": ["5 um", "5.1 um"]},
    "sweep.loads": ["60 N"], "sweep.velocities": ["2 m/s"],
}  # fmt: skip


def test_free_ends_make_the_window_as_long_as_the_pin():
    window, pin = load_scene("first_try").scene, load_scene("whole_pin").scene
    assert pin.pixels.periodic == (False, False)
    assert pin.pixels.size[1] == pytest.approx(3.4e-3, rel=1e-12)
    assert pin.pixels.size[0] == window.pixels.size[0]
    assert 0.99 < pin.pixels.spacing[1] / window.pixels.spacing[1] <= 1
    assert pin.pin.windows(pin.pixels) == 1
    assert (pin.pin.relief, pin.wear) == (None, window.wear)
    relieved = load_scene("whole_pin", overrides={"pin.relief": RELIEF})
    assert relieved.scene.pin.relief == tribo.Relief(2e-6, 0.3e-3)
    assert parse_sweep(sweep_text(relieved), {}).scene == relieved.scene


def test_only_a_window_that_repeats_leaves_the_ends_out(irg, tmp_path):
    outputs = {}
    for name, ends in (("repeating", {}), ("free", {"pin.ends": "free"})):
        sweep = load_scene("first_try", overrides={"without": ["tests"], **SHORT, **ends})
        store = tmp_path / f"{name}.zarr"
        pipeline.run_sweep(sweep, store, workers=1)
        (row,) = irg("margin", store, "--load", "60 N", "--velocity", "2 m/s", "--json")
        outputs[name] = row["not_included"].split(", ")
    assert "pin ends" in outputs["repeating"]
    assert outputs["free"] == [part for part in outputs["repeating"] if part != "pin ends"]
